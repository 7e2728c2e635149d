"""The fewest waypoints that keep a trajectory's shape and heading, or as many as a board can hold."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.motion.trajectory import Trajectory

__all__ = ["Thinned", "thin"]

GRID_S = 0.1
CHORD_M = 0.25
HEADING_RAD = np.radians(10.0)


@dataclass(frozen=True, slots=True, eq=False)
class Thinned:
    """Waypoints along a trajectory, and how far straight legs between them stray from it."""

    t_s: FloatArray
    position_enu_m: FloatArray
    yaw_enu_rad: FloatArray
    chord_error_m: float
    heading_error_rad: float


def thin(trajectory: Trajectory, count_max: int) -> Thinned:
    """At most `count_max` waypoints (at least one a leg and its ends) with the smallest errors that allows.

    The chord error is the distance from the trajectory to the straight line between two waypoints, the
    heading error half the turn between them. They start at 0.25 m and 10° and grow together until the
    waypoints fit.
    """
    states = trajectory.sampled(GRID_S)
    corners = np.cumsum([0.0, *(leg.law.duration_s for leg in trajectory.legs)])
    stops = np.unique(np.clip(np.round(corners / GRID_S).astype(np.int64), 0, len(states.t_s) - 1))
    stops[-1] = len(states.t_s) - 1

    def chosen(scale: float) -> list[int]:
        kept = [0]
        for begin, end in itertools.pairwise(stops):
            kept += _leg(states.position_enu_m, states.yaw_enu_rad, int(begin), int(end), scale)
        return kept

    low = high = 1.0
    kept = chosen(high)
    while len(kept) > count_max and high < 1e4:
        low, high = high, high * 2.0
        kept = chosen(high)
    while high - low > 0.02 * low:
        middle = 0.5 * (low + high)
        fewer = chosen(middle)
        if len(fewer) <= count_max:
            high, kept = middle, fewer
        else:
            low = middle
    index = np.array(kept)
    position, yaw = states.position_enu_m, states.yaw_enu_rad
    chord_m = max((_chord_m(position[a : b + 1]).max() for a, b in itertools.pairwise(kept)), default=0.0)
    heading = max((np.ptp(yaw[a : b + 1]) / 2 for a, b in itertools.pairwise(kept)), default=0.0)
    return Thinned(states.t_s[index], position[index], yaw[index], float(chord_m), float(heading))


def _leg(position_m: FloatArray, yaw_rad: FloatArray, begin: int, end: int, scale: float) -> list[int]:
    """Greedy: from each waypoint the farthest next one whose chord and heading are still within bounds."""
    kept, here = [], begin
    while here < end:
        good, step = here + 1, 1
        while good < end:
            ahead = min(good + step, end)
            if _within(position_m[here : ahead + 1], yaw_rad[here : ahead + 1], scale):
                good, step = ahead, step * 2
            elif step == 1:
                break
            else:
                step = 1
        kept.append(good)
        here = good
    return kept


def _within(position_m: FloatArray, yaw_rad: FloatArray, scale: float) -> bool:
    return bool(np.ptp(yaw_rad) <= 2 * HEADING_RAD * scale and _chord_m(position_m).max() <= CHORD_M * scale)


def _chord_m(position_m: FloatArray) -> FloatArray:
    """Distances of the points from the straight line between the first and the last of them."""
    offset, chord = position_m - position_m[0], position_m[-1] - position_m[0]
    length_2 = float((chord * chord).sum())
    along = (
        np.clip((offset * chord).sum(axis=1) / length_2, 0.0, 1.0) if length_2 > 0 else np.zeros(len(offset))
    )
    distance: FloatArray = np.sqrt(((offset - along[:, None] * chord) ** 2).sum(axis=1))
    return distance
