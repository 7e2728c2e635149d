"""What an autopilot really flies between waypoints: straight lines, and corners cut within the acceptance radius."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray

__all__ = ["ACCEPTANCE_M", "acceptance_m", "cut_lines_m"]

ACCEPTANCE_M = 3.0
"""The bundled vehicle takes 98 s round the kiosk at 1 m, 83 s at 2 m, 71 s at 3 m, where 95 % of it is within 0.5 m of the
curve; 66 s at 4 m, where it is not."""

ACCEPTANCE_MIN_M = 0.5
CUT_M = 0.75
"""No corner is cut deeper, and less deep where the clearance demands a finer mission."""


def acceptance_m(position_enu_m: FloatArray, cut_m: float) -> FloatArray:
    """The acceptance radius of each waypoint of a polygon `(n, 3)`.

    3 m, but never more than half way to a neighbour, nor so much that it cuts off more than `cut_m`: from a corner
    where one turns by θ, the line between the points at a radius r from it is r·sin(θ/2) away.
    """
    sides = np.diff(position_enu_m, axis=0)
    length_m = np.sqrt((sides**2).sum(axis=1))
    unit = sides / np.maximum(length_m, 1e-9)[:, None]
    half_turn = np.zeros(len(position_enu_m))
    half_turn[1:-1] = np.sqrt(np.clip(0.5 - 0.5 * (unit[:-1] * unit[1:]).sum(axis=1), 0.0, 1.0))  # sin(θ/2)
    half_way_m = 0.5 * np.minimum(np.append(np.inf, length_m), np.append(length_m, np.inf))
    deepest_m = cut_m / np.maximum(half_turn, 1e-9)
    radius_m: FloatArray = np.clip(np.minimum(half_way_m, deepest_m), ACCEPTANCE_MIN_M, ACCEPTANCE_M)
    return radius_m


def cut_lines_m(position_enu_m: FloatArray, radius_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Begins and sweeps, `(m, 3)` each, of the polygon's sides and of the lines that cut its corners off.

    Whoever turns from one side to the next within the acceptance radius stays between the corner and the line that
    cuts it off; so what is near him is near one of these lines.
    """
    sides = np.diff(position_enu_m, axis=0)
    length_m = np.maximum(np.sqrt((sides**2).sum(axis=1, keepdims=True)), 1e-9)
    unit = sides / length_m
    reach_m = radius_m[1:-1, None]
    corner = position_enu_m[1:-1]
    begin = corner - unit[:-1] * np.minimum(reach_m, length_m[:-1])
    end = corner + unit[1:] * np.minimum(reach_m, length_m[1:])
    return np.vstack([position_enu_m[:-1], begin]), np.vstack([sides, end - begin])
