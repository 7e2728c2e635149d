"""How high to fly home: PX4's RTL_RETURN_ALT inside its cone (RTL_TYPE 0)."""

from __future__ import annotations

import math
from collections.abc import Mapping

__all__ = ["return_height_m"]


def return_height_m(distance_m: float, height_home_m: float, parameters: Mapping[str, float]) -> float:
    """The height over home at which to fly home from `distance_m` away and `height_home_m` above it.

    Source: PX4 v1.17, rtl.cpp, calculate_return_alt_from_cone_half_angle. RTL_CONE_ANG 0 is no cone.
    """
    wanted_m = parameters["RTL_RETURN_ALT"]
    acceptance_m = parameters["NAV_ACC_RAD"]
    if parameters["RTL_CONE_ANG"] > 0:
        if distance_m <= acceptance_m:
            wanted_m = 2.0 * distance_m
        else:
            if distance_m <= parameters["RTL_MIN_DIST"]:
                half_angle_rad = math.radians(min(max(parameters["RTL_CONE_ANG"], 1.0), 89.0))
                wanted_m = min(distance_m / math.tan(half_angle_rad), wanted_m)
            wanted_m = max(wanted_m, 2.0 * acceptance_m)
    return max(wanted_m, height_home_m)
