"""Thrust vector and yaw to attitude, attitude to body rates: PX4's quaternion controller.

Brescianini, Hehn, D'Andrea, "Nonlinear quadrocopter attitude control" (ETH 2013), as PX4 has it: the turn
that points the thrust comes first, of the turn about it only `yaw_weight`.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.kernels import FloatArray, Quaternion, Triple, kernel
from sitl.rotation import between, from_axes, multiply, rotate, unrotate

__all__ = ["attitude_for", "control_attitude", "rates_for"]


@kernel
def attitude_for(thrust_ned: FloatArray, yaw_rad: float) -> Quaternion:
    """The attitude whose -z lies along `thrust_ned` (up) and whose nose heads for `yaw_rad`."""
    length = math.sqrt(thrust_ned[0] ** 2 + thrust_ned[1] ** 2 + thrust_ned[2] ** 2)
    z = (-thrust_ned[0] / length, -thrust_ned[1] / length, -thrust_ned[2] / length)
    s, c = math.sin(yaw_rad), math.cos(yaw_rad)
    x0, x1, x2 = c * z[2], s * z[2], -c * z[0] - s * z[1]  # (-s, c, 0) × z
    n = math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
    x = (x0 / n, x1 / n, x2 / n)
    y = (z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0])
    return from_axes(x, y, z)


@kernel
def rates_for(q: Quaternion, wanted: Quaternion, p: FloatArray, yaw_weight: float) -> Triple:
    """Body rates that turn `q` into `wanted`."""
    down, down_wanted = rotate(q, (0.0, 0.0, 1.0)), rotate(wanted, (0.0, 0.0, 1.0))
    tilted = multiply(between(down, down_wanted), q)
    spin = multiply((tilted[0], -tilted[1], -tilted[2], -tilted[3]), wanted)
    half = math.atan2(spin[3], spin[0])
    if half > 0.5 * math.pi:
        half -= math.pi
    elif half < -0.5 * math.pi:
        half += math.pi
    half *= yaw_weight
    aim = multiply(tilted, (math.cos(half), 0.0, 0.0, math.sin(half)))
    error = multiply((q[0], -q[1], -q[2], -q[3]), aim)
    twice = 2.0 if error[0] >= 0.0 else -2.0
    yaw_p = p[2] / yaw_weight if yaw_weight > 1e-4 else p[2]
    return twice * error[1] * p[0], twice * error[2] * p[1], twice * error[3] * yaw_p


@kernel
def control_attitude(
    mind: np.record, gains: np.record, q_ned_frd: FloatArray, yaw_rate_ned_radps: float
) -> None:
    """Set `mind.rate_wanted_frd_radps` for `mind.q_wanted_ned_frd`, with the yaw rate fed forward."""
    q = (q_ned_frd[0], q_ned_frd[1], q_ned_frd[2], q_ned_frd[3])
    w = mind.q_wanted_ned_frd
    wanted = (w[0], w[1], w[2], w[3])
    rates = rates_for(q, wanted, gains.attitude_p, gains.yaw_weight)
    forward = unrotate(q, (0.0, 0.0, yaw_rate_ned_radps))
    for i in range(3):
        limit = gains.rate_max_radps[i]
        mind.rate_wanted_frd_radps[i] = min(max(rates[i] + forward[i], -limit), limit)
