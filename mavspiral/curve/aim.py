"""Where nose and camera point above a roof.

The nose points along the left normal of the way, as on the walls, averaged along the arc. Every cell of the roof
belongs to the place of the way that is nearest to it in plan, and the camera looks at the middle of what belongs to
where it is: straight down in the midst of a flat roof, square to a gable's slope, inward on a terrace. Where what
belongs to the right is out of the picture of a camera that looks straight down, at the foot of a wall beside the roof,
the nose turns there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve.gaze import GIMBAL_RADPS, box_average
from mavspiral.curve.profile import Profile
from mavspiral.shape.roofs import RoofGrid

__all__ = ["Belonging", "roof_gaze"]

KNOT_M = 2.0
WINDOW_M = 4.0
"""The camera looks at the middle of what belongs to so long a piece of the way."""


@dataclass(frozen=True, slots=True, eq=False)
class Belonging:
    """Which cells belong to which place of a way, the one that is nearest in plan.

    `cell_enu_m` (n, 3) are the cells of the mask `cells` and `place` (n,) theirs. `way_m` (m,) is the way to each place, and its window is
    from the place `first` to before the place `last`.
    """

    cells: NDArray[np.bool_]
    cell_enu_m: FloatArray
    place: NDArray[np.int64]
    way_m: FloatArray
    first: NDArray[np.int64]
    last: NDArray[np.int64]

    @classmethod
    def of(
        cls, place_enu_m: FloatArray, grid: RoofGrid, cells: NDArray[np.bool_], reach_m: FloatArray
    ) -> Belonging:
        """Of the places `(m, 3)`, with those of `cells` that are no farther in plan than their own `reach_m` (rows, cols)."""
        row, col = grid.index(place_enu_m[:, :2])
        away = np.ones(cells.shape, dtype=np.uint8)
        away[row, col] = 0
        distance, labels = cv2.distanceTransformWithLabels(
            away, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
        )
        owner = np.zeros(int(labels.max()) + 1, dtype=np.int64)
        owner[labels[row, col]] = np.arange(len(place_enu_m))
        mine = cells & (distance * grid.cell_m <= reach_m)
        cell = np.column_stack([grid.centres_enu_m(mine), grid.height_agl_m[mine]])
        steps_m = np.sqrt((np.diff(place_enu_m, axis=0) ** 2).sum(axis=1))
        way_m = np.concatenate([[0.0], np.cumsum(steps_m)])
        first = np.searchsorted(way_m, way_m - 0.5 * WINDOW_M)
        last = np.searchsorted(way_m, way_m + 0.5 * WINDOW_M, side="right")
        return cls(mine, cell, owner[labels[mine]], way_m, first, last)

    def angles_rad(self, place_enu_m: FloatArray, yaw_enu_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The least and the greatest pitch to what belongs to each window, beyond -π/2 behind a nose at that yaw."""
        toward = self.cell_enu_m - place_enu_m[self.place]
        yaw = yaw_enu_rad[self.place]
        ahead_m = toward[:, 0] * np.cos(yaw) + toward[:, 1] * np.sin(yaw)
        angle = np.arctan2(toward[:, 2], ahead_m)
        low, high = _extremes(angle, self.place, self.first, self.last)
        known = np.flatnonzero(np.isfinite(low))
        if not len(known):
            return np.full(len(low), -0.5 * np.pi), np.full(len(low), -0.5 * np.pi)
        every = np.arange(len(low))
        return np.interp(every, known, low[known]), np.interp(every, known, high[known])


def roof_gaze(
    u_rad: FloatArray,
    jet: FloatArray,
    belonging: Belonging,
    *,
    near_wall: NDArray[np.bool_],
    picture_rad: float,
    smoothing_m: float,
    speed_mps: float,
) -> tuple[Profile, Profile]:
    """Yaw and gimbal pitch along a path above a roof.

    Args:
        u_rad: phases `(n,)` from 0 to the path's end, of places less than a metre apart.
        jet: the positions there and their derivatives, `(2 or more, n, 3)`.
        belonging: which cells belong to which of the places.
        near_wall: `(n,)`, where there may be something to look at on the right.
        picture_rad: half the angle that a picture shows from its top to its bottom.
        smoothing_m: the yaw is averaged over a triangle of this half width.
        speed_mps: at this speed the pitch turns no faster than `GIMBAL_RADPS`.
    """
    way_m = belonging.way_m
    inward = np.unwrap(np.arctan2(jet[1, :, 1], jet[1, :, 0])) + 0.5 * np.pi
    low, high = belonging.angles_rad(jet[0], inward)
    rightward = (low < -0.5 * np.pi - picture_rad) & (low + high < -np.pi) & near_wall
    yaw = inward + np.pi * rightward
    for _ in range(2):
        yaw = box_average(way_m, yaw, smoothing_m)
    low, high = belonging.angles_rad(jet[0], yaw)
    pitch = np.clip(0.5 * (low + high), -0.5 * np.pi, 0.0)
    width_m = WINDOW_M
    while True:
        smooth = box_average(way_m, box_average(way_m, pitch, width_m), width_m)
        rate = np.abs(np.diff(smooth)) / np.maximum(np.diff(way_m), 1e-9) * speed_mps
        if float(rate.max()) <= 0.9 * GIMBAL_RADPS or width_m > way_m[-1]:
            break
        width_m *= 1.4
    spans = max(8, math.ceil(way_m[-1] / KNOT_M))
    knot_rad = float(u_rad[-1]) / spans
    return Profile.along(u_rad, yaw, knot_rad, spans), Profile.along(u_rad, smooth, knot_rad, spans)


@njit(cache=True)
def _extremes(
    angle: FloatArray, place: NDArray[np.int64], first: NDArray[np.int64], last: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """The least and the greatest angle of those that belong to the places from `first` to before `last`, of each window."""
    lowest, highest = np.full(first.size, np.inf), np.full(first.size, -np.inf)
    for k in range(angle.size):
        lowest[place[k]] = min(lowest[place[k]], angle[k])
        highest[place[k]] = max(highest[place[k]], angle[k])
    low, high = np.full(first.size, np.inf), np.full(first.size, -np.inf)
    for i in range(first.size):
        for j in range(first[i], last[i]):
            low[i] = min(low[i], lowest[j])
            high[i] = max(high[i], highest[j])
    return low, high
