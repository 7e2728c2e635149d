"""One step of the stream as one kernel: the governor moves path time on, and the reference is read there and ahead of it.

All kernels of a step are in this file, because numba's cache sees no change in another.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from mavspiral.arrays import FloatArray
from mavspiral.flight.messages import Setpoint

__all__ = ["PACE_N", "SETPOINT_N", "paced", "setpoint_at", "steered", "wanted_rate"]

PACE_N, SETPOINT_N = 3, 11
_SLOWEST_MPS = 0.5  # below this speed any change of rate is gentle
_TAU = 2 * math.pi


@njit(cache=True)
def wanted_rate(error_m: float, slow_m: float, stop_m: float) -> float:
    """The rate to aim for with a position error of `error_m`: 1 up to `slow_m`, 0 from `stop_m` on."""
    return min(1.0, max(0.0, (stop_m - error_m) / (stop_m - slow_m)))


@njit(cache=True)
def paced(
    path_t_s: float,
    rate: float,
    rate_change_per_s: float,
    dt_s: float,
    wanted: float,
    speed_mps: float,
    brake_mps2: float,
    recover_mps2: float,
) -> tuple[float, float, float]:
    """Path time, its rate and that rate's change after `dt_s` of the vehicle's time, drawn towards the rate `wanted`.

    Args:
        path_t_s: where path time stands.
        rate: how fast it runs.
        rate_change_per_s: how that changes; stays as it is while no time passes.
        dt_s: the vehicle's time that has passed; nothing changes unless it is positive.
        wanted: the rate to aim for, in [0, 1].
        speed_mps: the reference's speed here at rate 1, by which braking is turned into a change of rate.
        brake_mps2: how hard the reference may brake along its path.
        recover_mps2: how hard it may speed up again.
    """
    if dt_s <= 0.0:
        return path_t_s, rate, rate_change_per_s
    scale = dt_s / max(speed_mps, _SLOWEST_MPS)
    before = rate
    if wanted < before:
        rate = max(wanted, before - brake_mps2 * scale)
    else:
        rate = min(wanted, before + recover_mps2 * scale)
    return path_t_s + dt_s * (before + rate) / 2, rate, (rate - before) / dt_s


@njit(cache=True)
def _quintic(
    c: FloatArray, row: int, axis: int, s: float, r1: float, r2: float, rr: float
) -> tuple[float, float, float]:
    """Value, rate and acceleration of one axis at `s` of [0, 1] on a row of the table."""
    k0, k1, k2 = c[row, axis, 0], c[row, axis, 1], c[row, axis, 2]
    k3, k4, k5 = c[row, axis, 3], c[row, axis, 4], c[row, axis, 5]
    value = ((((k5 * s + k4) * s + k3) * s + k2) * s + k1) * s + k0
    first = (((5.0 * k5 * s + 4.0 * k4) * s + 3.0 * k3) * s + 2.0 * k2) * s + k1
    second = ((20.0 * k5 * s + 12.0 * k4) * s + 6.0 * k3) * s + 2.0 * k2
    return value, r1 * first, r2 * second + rr * first


@njit(cache=True)
def setpoint_at(c: FloatArray, knot_s: float, t_s: float, rate: float, rate_change_per_s: float) -> Setpoint:
    """The setpoint at path time `t_s` from the table `c` (n, 4, 6) of power coefficients, `knot_s` apart.

    A path time that runs at `rate` r stretches the motion: velocity r·v, acceleration r²·a + ṙ·v.
    """
    x = min(max(t_s / knot_s, 0.0), float(len(c)))
    row = min(int(x), len(c) - 1)
    s = x - row
    r1 = rate / knot_s
    r2, rr = r1 * r1, rate_change_per_s / knot_s
    n, v_n, a_n = _quintic(c, row, 0, s, r1, r2, rr)
    e, v_e, a_e = _quintic(c, row, 1, s, r1, r2, rr)
    d, v_d, a_d = _quintic(c, row, 2, s, r1, r2, rr)
    yaw, yaw_rate, _ = _quintic(c, row, 3, s, r1, r2, rr)
    return n, e, d, v_n, v_e, v_d, a_n, a_e, a_d, (yaw + math.pi) % _TAU - math.pi, yaw_rate


@njit(cache=True)
def steered(
    c: FloatArray,
    knot_s: float,
    path_t_s: float,
    rate: float,
    rate_change_per_s: float,
    dt_s: float,
    error_m: float,
    slow_m: float,
    stop_m: float,
    speed_mps: float,
    brake_mps2: float,
    recover_mps2: float,
    lead_s: float,
    tilt_lead_s: float,
    turn_lead_s: float,
    gain: float,
    drag_per_s: float,
) -> tuple[Any, ...]:
    """The pace after `dt_s` (`wanted_rate`, `paced`), the setpoint that is due there, and the one to be sent: 3 + 11 + 11 numbers.

    What is sent is the reference's position, velocity and yaw of `lead_s` of the vehicle's time later, its yaw rate of
    `turn_lead_s` later and its acceleration a of `tilt_lead_s` later: gain·a + drag·v horizontally (`feedforward`).
    """
    wanted = wanted_rate(error_m, slow_m, stop_m)
    pace = paced(path_t_s, rate, rate_change_per_s, dt_s, wanted, speed_mps, brake_mps2, recover_mps2)
    t_s, r, change = pace
    due = setpoint_at(c, knot_s, t_s, r, change)
    later = setpoint_at(c, knot_s, t_s + r * lead_s, r, change)
    tilting = setpoint_at(c, knot_s, t_s + r * tilt_lead_s, r, change)
    turning = setpoint_at(c, knot_s, t_s + r * turn_lead_s, r, change)
    north_mps2 = gain * tilting[6] + drag_per_s * later[3]
    east_mps2 = gain * tilting[7] + drag_per_s * later[4]
    told = (*later[:6], north_mps2, east_mps2, tilting[8], later[9], turning[10])
    all_of_it: tuple[Any, ...] = pace + due + told
    return all_of_it
