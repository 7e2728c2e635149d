"""Where a camera that keeps one point in view must look to see what a trajectory sees.

An autopilot turns towards a region of interest all by itself, and waits at no waypoint until it has turned. Round
a corner the gazes of a trajectory meet in the corner, along a wall they meet nowhere: then the point is far away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.frames import wrap_rad
from mavspiral.motion.trajectory import TrajectoryState

__all__ = ["FAR_M", "Aim", "aim_over"]

FAR_M = 500.0
NEAR_M = 2.0
"""Nearer than this a point runs out of the picture."""
STEEPEST_RAD = math.radians(85.0)
"""Straight down a line of sight meets nothing that is ahead: there the point lies so steeply below it."""


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """A point `(3,)` to keep in view, and the worst angle to the gaze that was planned."""

    point_enu_m: FloatArray
    error_rad: float


def aim_over(states: TrajectoryState, begin: int, end: int) -> Aim:
    """The point for the stretch between two rows of `states`, both included.

    It is the one with the least squared distances from all lines of sight (Gauss), or straight ahead and far away
    where that is better.
    """
    here = slice(begin, end + 1)
    place, yaw, pitch = states.position_enu_m[here], states.yaw_enu_rad[here], states.gimbal_pitch_rad[here]
    middle_rad = 0.5 * (float(yaw.min()) + float(yaw.max()))
    centre = place[:, :2].mean(axis=0)
    far = centre + FAR_M * np.array([np.cos(middle_rad), np.sin(middle_rad)])
    aims = [_aim(far, place, yaw, pitch)]
    across = np.column_stack([-np.sin(yaw), np.cos(yaw)])
    spread = across.T @ across
    if np.linalg.det(spread) > 1e-9 * float(np.trace(spread)) ** 2:
        wanted = (across * place[:, :2]).sum(axis=1)
        point = np.linalg.solve(spread, across.T @ wanted)
        if np.sqrt(((point - place[:, :2]) ** 2).sum(axis=1)).min() > NEAR_M:
            aims.append(_aim(point, place, yaw, pitch))
    return min(aims, key=lambda aim: aim.error_rad)


def _aim(point_m: FloatArray, place: FloatArray, yaw: FloatArray, pitch: FloatArray) -> Aim:
    way = point_m - place[:, :2]
    distance_m = np.hypot(*way.T)
    height_m = float((place[:, 2] + np.tan(np.maximum(pitch, -STEEPEST_RAD)) * distance_m).mean())
    turned = np.abs(wrap_rad(np.arctan2(way[:, 1], way[:, 0]) - yaw))
    tilted = np.abs(np.arctan2(height_m - place[:, 2], distance_m) - pitch)
    return Aim(np.append(point_m, height_m), float(max(turned.max(), tilted.max())))
