"""How the pictures are commanded in a mission, by the camera's trigger."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Literal

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.export.items import Item, mission_frame_item
from mavspiral.export.thinning import GRID_S, Thinned
from mavspiral.survey.shots import Shots

__all__ = ["camera_orders", "shot_stops_s"]

Trigger = Literal["camera", "digicam", "distance", "none"]

MAV_CMD_DO_DIGICAM_CONTROL = 203
MAV_CMD_DO_SET_CAM_TRIGG_DIST = 206
MAV_CMD_IMAGE_START_CAPTURE = 2000
MAV_CMD_IMAGE_STOP_CAPTURE = 2001

CHANGE_PICTURES_N = 10.0
"""So many pictures must another interval spare: a change costs the board two items."""


def camera_orders(
    trigger: Trigger, shots: Shots, thinned: Thinned, *, interval_min_s: float
) -> Mapping[int, tuple[Item, ...]]:
    """What the camera is told at which waypoint, for pictures no farther apart than the planned `shots`.

    By time (`camera`) at the shortest interval of a stretch, because in AUTO no place is passed faster than planned;
    by `distance` at its shortest step that the shutter can follow; by `digicam` one order a picture, at a waypoint each
    (`shot_stops_s`). A stretch begins where another interval spares pictures enough. `shots` have their path times on
    what was thinned.
    """
    match trigger:
        case "camera":
            off = mission_frame_item(MAV_CMD_IMAGE_STOP_CAPTURE)
            gaps_s = np.diff(shots.t_s)
            orders: dict[int, tuple[Item, ...]] = {}
            for first, last, shortest_s in _stretches(shots, thinned, gaps_s, np.diff(thinned.t_s)):
                interval_s = max(interval_min_s, math.floor(100 * shortest_s) / 100)
                begin = mission_frame_item(MAV_CMD_IMAGE_START_CAPTURE, 0.0, interval_s, 0.0)
                orders |= {first: (*orders.get(first, ()), begin), last: (off,)}
            return orders
        case "distance":
            off = mission_frame_item(MAV_CMD_DO_SET_CAM_TRIGG_DIST)
            steps_m = np.hypot(*np.diff(shots.position_enu_m[:, :2], axis=0).T)
            sides_m = np.hypot(*np.diff(thinned.position_enu_m[:, :2], axis=0).T)
            speed_mps = max(stage.speed_mps for stage in thinned.stages if stage.inspects)
            steps_m = np.maximum(steps_m, speed_mps * interval_min_s)
            orders = {}
            for first, last, shortest_m in _stretches(shots, thinned, steps_m, sides_m):
                step_m = math.floor(100 * shortest_m) / 100
                begin = mission_frame_item(MAV_CMD_DO_SET_CAM_TRIGG_DIST, step_m, 0.0, 1.0)
                orders |= {first: (begin,), last: (off,)}
            return orders
        case "digicam":
            shoot = mission_frame_item(MAV_CMD_DO_DIGICAM_CONTROL, 0.0, 0.0, 0.0, 0.0, 1.0)
            stops = np.abs(thinned.t_s - shots.t_s[:, None]).argmin(axis=1)
            return {int(stop): (shoot,) for stop in stops}
        case "none":
            return {}


def shot_stops_s(trigger: Trigger, shots: Shots) -> tuple[float, ...]:
    """The path times that need a waypoint of their own."""
    return tuple(shots.t_s.tolist()) if trigger == "digicam" else ()


def _stretches(
    shots: Shots, thinned: Thinned, gaps: FloatArray, sides: FloatArray
) -> Iterator[tuple[int, int, float]]:
    """First and last waypoint and the shortest gap of each stretch: the fewest pictures and orders together.

    Args:
        shots: n of them, on the legs that are inspected.
        thinned: m waypoints.
        gaps: how far apart the shots are, (n - 1,), in time or space.
        sides: how far apart the waypoints are, (m - 1,), alike.
    """
    for stage, group in groupby(range(len(sides)), key=lambda side: thinned.stages[side + 1]):
        if stage.inspects:
            run = list(group)
            needed = _needed(shots, thinned, gaps, run)
            for begin, end in _cheapest(needed, sides[run]):
                yield run[0] + begin, run[0] + end, float(needed[begin:end].min())


def _needed(shots: Shots, thinned: Thinned, gaps: FloatArray, run: list[int]) -> FloatArray:
    """The shortest planned gap on each side of a leg's polygon, and on the way there within the acceptance radius.

    The plan begins and ends its legs at rest, with long gaps; in AUTO nothing rests there: there the next gap counts.
    """
    t_s = thinned.t_s[run[0] : run[-1] + 2]
    on_leg = np.flatnonzero((shots.t_s >= t_s[0] - GRID_S) & (shots.t_s <= t_s[-1] + GRID_S))
    between = on_leg[:-1]
    gaps = gaps[between].copy()
    if len(gaps) > 1:
        gaps[0], gaps[-1] = min(gaps[:2]), min(gaps[-2:])
    early_s = thinned.radius_m[run] / thinned.stages[run[-1] + 1].speed_mps
    on = shots.t_s[between] < t_s[1:, None]
    on &= shots.t_s[between + 1] > (t_s[:-1] - early_s)[:, None]
    shortest = gaps.min(initial=np.inf)
    needed: FloatArray = np.where(on, gaps, np.inf).min(axis=1, initial=np.inf)
    needed[~np.isfinite(needed)] = shortest
    return needed


def _cheapest(needed: FloatArray, sides: FloatArray) -> list[tuple[int, int]]:
    """Where to cut a row of sides: each stretch costs its pictures at its shortest gap, and its order."""
    count = len(needed)
    cost, came_from = np.full(count + 1, np.inf), np.zeros(count + 1, dtype=np.intp)
    cost[0] = 0.0
    for end in range(1, count + 1):
        shortest = np.minimum.accumulate(needed[:end][::-1])[::-1]
        length = np.cumsum(sides[:end][::-1])[::-1]
        costs = cost[:end] + length / shortest + CHANGE_PICTURES_N
        came_from[end] = int(costs.argmin())
        cost[end] = costs[came_from[end]]
    cuts = [count]
    while cuts[-1]:
        cuts.append(int(came_from[cuts[-1]]))
    return list(zip(cuts[:0:-1], cuts[-2::-1], strict=True))
