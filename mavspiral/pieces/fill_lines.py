"""Level straight lines through a pose that shows what is unseen, as far to either side as they show more of it."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve.line import LinePath
from mavspiral.motion.turn import TurnGaze
from mavspiral.pieces.gap import Fill, Gap, Pose, worth_flying
from mavspiral.survey.seeable import Room
from mavspiral.survey.solids import Solids

__all__ = ["lines_through"]

AWAY_N = 40
"""A line goes so many shots to either side at the most."""
SHORTEST_M = 1.0
UP = np.array([0.0, 0.0, 1.0])
"""What is safe stays safe straight up, on a height map."""


def lines_through(pose: Pose, gap: Gap, *, solids: Solids, room: Room, spacing_m: float) -> list[Fill]:
    """The lines along the wall that the pose looks at and square to where it looks, with a shot every `spacing_m`."""
    yaw, pitch, normal = pose.yaw_enu_rad, pose.pitch_rad, pose.normal_enu
    ways = [np.array([-np.sin(yaw), np.cos(yaw), 0.0])]
    if (upright := float(np.hypot(*normal[:2]))) > 0.05:
        ways.append(np.array([-normal[1], normal[0], 0.0]) / upright)
    lines = []
    for along in ways:
        places, here = _safe_along(solids, room.clearance_m, pose.place_enu_m, spacing_m * along)
        n = len(places)
        shows = gap.shows(places, np.full(n, yaw), np.full(n, pitch))
        first, last = worth_flying(shows, here)
        start, end = places[first], places[last]
        if first == last:
            sides = np.array([along, -along, UP]) * SHORTEST_M
            safe = solids.clear(np.array([start] * len(sides)), sides, room.clearance_m)
            safe &= start[2] + sides[:, 2] <= room.highest_m
            if not safe.any():
                continue
            end = start + sides[int(np.argmax(safe))]
        shown_by_it = np.asarray(shows[first : last + 1].any(axis=0))
        length_m = float(np.linalg.norm(end - start))
        lines.append(Fill(LinePath(start, end), TurnGaze(yaw, yaw), pose, 0, length_m, shown_by_it))
    return lines


def _safe_along(
    solids: Solids, clearance_m: float, place_enu_m: FloatArray, step_m: FloatArray
) -> tuple[FloatArray, int]:
    """Places a step apart `(n, 3)` on the line through one, as far as it stays safe, and which of them that one is."""
    places = place_enu_m + np.arange(-AWAY_N, AWAY_N + 1)[:, None] * step_m
    safe = solids.distance_m(places[:-1], np.diff(places, axis=0)) >= clearance_m
    before = int(np.argmin(np.append(safe[:AWAY_N][::-1], False)))
    after = int(np.argmin(np.append(safe[AWAY_N:], False)))
    return places[AWAY_N - before : AWAY_N + after + 1], before
