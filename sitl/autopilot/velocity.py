"""Velocity error to acceleration to thrust vector: PX4's PID with its anti-windup.

Thrust is normalised: 1 is all four motors at their greatest, `thrust_hover` carries the weight.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.geo import GRAVITY_MPS2
from sitl.kernels import Components, FloatArray, Triple, kernel

__all__ = ["control_velocity", "thrust_for"]


@kernel
def thrust_for(
    acceleration: Components,
    hover: float,
    thrust_min: float,
    thrust_max: float,
    margin: float,
    steepest_mps2: float,
) -> tuple[Triple, Triple]:
    """NED thrust for an acceleration: within all limits, and within those of tilt and least thrust only.

    The direction supposes gravity alone vertically (MPC_ACC_DECOUPLE); then tilt is limited; vertical
    thrust goes before horizontal except for the horizontal `margin`.
    """
    ax, ay = acceleration[0], acceleration[1]
    across = math.hypot(ax, ay)
    if across > steepest_mps2:
        ax, ay, across = ax * steepest_mps2 / across, ay * steepest_mps2 / across, steepest_mps2
    lift = hover - acceleration[2] * hover / GRAVITY_MPS2
    cosine = GRAVITY_MPS2 / math.hypot(across, GRAVITY_MPS2)
    total = max(lift / cosine, thrust_min)
    scale = total * cosine / GRAVITY_MPS2
    asked = (ax * scale, ay * scale, -total * cosine)

    level = across * scale
    reserved = min(level, margin)
    down = max(asked[2], -math.sqrt(thrust_max * thrust_max - reserved * reserved))
    room = math.sqrt(max(0.0, thrust_max * thrust_max - down * down))
    cut = room / level if level > room else 1.0
    return (asked[0] * cut, asked[1] * cut, down), asked


@kernel
def control_velocity(
    mind: np.record, gains: np.record, demand: np.record, velocity_ned_mps: FloatArray, dt: float
) -> None:
    """Set `mind.thrust_ned` and the acceleration asked for; move the integrals on."""
    wanted, integral, slope = mind.velocity_wanted_ned_mps, mind.velocity_integral, mind.velocity_slope
    acceleration, error = mind.acceleration_wanted_ned_mps2, mind.velocity_error
    for i in range(3):
        rise = (velocity_ned_mps[i] - mind.velocity_before[i]) / dt
        mind.velocity_before[i] = velocity_ned_mps[i]
        slope[i] += gains.velocity_slope_alpha * (rise - slope[i])
        forward = demand.acceleration_ned_mps2[i]
        acceleration[i] = 0.0 if math.isnan(forward) else forward
        error[i] = 0.0
        if not math.isnan(wanted[i]):
            error[i] = wanted[i] - velocity_ned_mps[i]
            acceleration[i] += error[i] * gains.velocity_p[i] + integral[i] - slope[i] * gains.velocity_d[i]

    hover, least, most = gains.thrust_hover, gains.thrust_min, gains.thrust_max
    given, asked = thrust_for(acceleration, hover, least, most, gains.thrust_margin, gains.steepest_mps2)
    mind.thrust_ned[0], mind.thrust_ned[1], mind.thrust_ned[2] = given

    if (asked[2] >= -least and error[2] >= 0.0) or (asked[2] <= -most and error[2] <= 0.0):
        error[2] = 0.0
    # Horizontal tracking anti-windup (Rundqwist 1990), only where saturation took something away.
    made_x, made_y = given[0] * GRAVITY_MPS2 / hover, given[1] * GRAVITY_MPS2 / hover
    if acceleration[0] ** 2 + acceleration[1] ** 2 > made_x**2 + made_y**2:
        back = 2.0 / gains.velocity_p[0]
        error[0] -= back * (acceleration[0] - made_x)
        error[1] -= back * (acceleration[1] - made_y)
    for i in range(3):
        if not math.isnan(wanted[i]):
            integral[i] += error[i] * gains.velocity_i[i] * dt
    integral[2] = min(max(integral[2], -GRAVITY_MPS2), GRAVITY_MPS2)
