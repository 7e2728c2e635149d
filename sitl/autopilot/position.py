"""Position error to velocity: PX4's proportional controller with velocity feedforward."""

from __future__ import annotations

import math

import numpy as np

from sitl.kernels import FloatArray, kernel

__all__ = ["constrained", "control_position"]


@kernel
def constrained(first: tuple[float, float], second: tuple[float, float], limit: float) -> tuple[float, float]:
    """`first + second` within `limit`: `first` keeps its place, `second` is cut (PX4's constrainXY).

    Where cut, it is first + s·û with |first + s·û| = limit, so s = -m + √(m² - |first|² + limit²), m =
    û·first.
    """
    x, y = first[0] + second[0], first[1] + second[1]
    if math.hypot(x, y) <= limit:
        return x, y
    length = math.hypot(first[0], first[1])
    if length >= limit:
        return first[0] * limit / length, first[1] * limit / length
    other = math.hypot(second[0], second[1])
    ux, uy = second[0] / other, second[1] / other
    m = ux * first[0] + uy * first[1]
    s = -m + math.sqrt(m * m - length * length + limit * limit)
    return first[0] + s * ux, first[1] + s * uy


@kernel
def control_position(
    mind: np.record, gains: np.record, demand: np.record, position_ned_m: FloatArray
) -> None:
    """Set `mind.velocity_wanted_ned_mps`; NaN where an axis is flown by acceleration alone.

    An axis that nothing commands shall stop. Position error and feedforward add up; horizontally the part
    that corrects the position has the right of way below MPC_XY_VEL_MAX.
    """
    wanted = mind.velocity_wanted_ned_mps
    correction = mind.correction_ned_mps
    for i in range(3):
        place, speed = demand.position_ned_m[i], demand.velocity_ned_mps[i]
        correction[i] = 0.0 if math.isnan(place) else (place - position_ned_m[i]) * gains.position_p[i]
        feedforward = 0.0 if math.isnan(speed) else speed
        wanted[i] = correction[i] + feedforward
        if math.isnan(place) and math.isnan(speed) and not math.isnan(demand.acceleration_ned_mps2[i]):
            wanted[i] = np.nan
    if not math.isnan(wanted[0]) and not math.isnan(wanted[1]):
        rest = (wanted[0] - correction[0], wanted[1] - correction[1])
        wanted[0], wanted[1] = constrained((correction[0], correction[1]), rest, gains.speed_max_mps)
    if not math.isnan(wanted[2]):
        wanted[2] = min(max(wanted[2], -gains.climb_max_mps), gains.descent_max_mps)
