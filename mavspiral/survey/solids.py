"""Exact distances in space to the solid boxes of a height map.

The boxes stand in a quadtree whose nodes know their greatest height. A node whose own box is farther
than the best found so far is not opened, and the search begins with the box that was nearest to the
query before, so along a trajectory few nodes are opened at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray, locked
from mavspiral.shape.heightmap import HeightMap, box_of

__all__ = ["Solids"]


FOUNDATION_M = 1000.0
"""A wall goes on below the map's ground: beside a building on a slope, that is where its foot is."""

FEW = 16
"""One of so many ways is looked at beforehand where only the least distance of all is wanted."""
ROUNDING_M = 1e-9
"""So much more than the least of those few is looked for, so that the way that has it is found again."""


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """Boxes from far below the ground to `height_agl_m` over the cells of a grid; cells of height 0 are empty."""

    height_agl_m: FloatArray
    cell_m: float
    origin_enu_m: FloatArray
    _pyramid_m: FloatArray

    @classmethod
    def of(cls, height_agl_m: ArrayLike, cell_m: float, origin_enu_m: ArrayLike) -> Solids:
        """The boxes of `height_agl_m (rows, cols)`; `origin_enu_m` is the outer south-west corner."""
        heights, origin = _cropped(np.asarray(height_agl_m, dtype=np.float64), cell_m, origin_enu_m)
        heights = locked(heights, shape=(None, None), name="height_agl_m")
        side = 1 << max(heights.shape[0] - 1, heights.shape[1] - 1, 0).bit_length()
        pyramid = np.zeros((4 * side * side - 1) // 3)
        above = pyramid[-side * side :].reshape(side, side)
        rows, cols = heights.shape
        above[:rows, :cols] = heights
        while side > 1:
            rows, cols, side = (rows + 1) // 2, (cols + 1) // 2, side // 2
            pairs = np.maximum(above[: 2 * rows : 2, : 2 * cols], above[1 : 2 * rows : 2, : 2 * cols])
            first = (side * side - 1) // 3
            above = pyramid[first : first + side * side].reshape(side, side)
            np.maximum(pairs[:, ::2], pairs[:, 1::2], out=above[:rows, :cols])
        pyramid.setflags(write=False)
        return cls(heights, float(cell_m), locked(origin, shape=(2,), name="origin_enu_m"), pyramid)

    @classmethod
    def of_map(cls, heights: HeightMap) -> Solids:
        """The boxes of everything on the map."""
        return cls.of(heights.height_agl_m, heights.cell_m, heights.origin_enu_m)

    def distance_m(self, position_enu_m: ArrayLike, sweep_enu_m: ArrayLike = 0.0) -> FloatArray:
        """How near each straight way, from a position `(n, 3)` over its sweep, comes to a box.

        0 inside a box, infinity where there are no boxes. Without a sweep the way is a point.
        """
        return self._searched(position_enu_m, sweep_enu_m, math.inf, 0.0)[0]

    def least(self, position_enu_m: ArrayLike, sweep_enu_m: ArrayLike) -> tuple[float, int]:
        """The least of what `distance_m` would tell, and the first way that has it, but sooner.

        A way comes no nearer to what stands in a node than to the node's own box. So where that is no nearer than the
        least distance so far, nothing in it can be the least, and it is not opened: all of the way is proved by that.
        A few of the ways tell beforehand how small the least is at the most.
        """
        positions = np.asarray(position_enu_m, dtype=np.float64)
        sweeps = np.broadcast_to(sweep_enu_m, positions.shape)
        few_m, _ = self._searched(positions[::FEW], sweeps[::FEW], math.inf, 0.0, least=True)
        most_m = float(few_m.min()) + ROUNDING_M
        distances, nearest = self._searched(positions, sweeps, most_m, 0.0, least=True)
        return float(distances[nearest]), nearest

    def clear(
        self, position_enu_m: ArrayLike, sweep_enu_m: ArrayLike, distance_m: float
    ) -> NDArray[np.bool_]:
        """Whether each way keeps `distance_m` from every box: what `distance_m` would tell, but sooner."""
        return self._searched(position_enu_m, sweep_enu_m, distance_m, distance_m)[0] >= distance_m

    def _searched(
        self,
        position_enu_m: ArrayLike,
        sweep_enu_m: ArrayLike,
        farthest_m: float,
        enough_m: float,
        *,
        least: bool = False,
    ) -> tuple[FloatArray, int]:
        positions = np.array(position_enu_m, dtype=np.float64, order="C")
        sweeps = np.empty_like(positions)
        sweeps[...] = sweep_enu_m
        distances, nearest = _distances(
            self._pyramid_m,
            self.height_agl_m.shape,
            self.cell_m,
            self.origin_enu_m,
            positions,
            sweeps,
            farthest_m,
            enough_m,
            least,
        )
        return distances, nearest


def _cropped(heights_m: FloatArray, cell_m: float, origin_enu_m: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """The grid without the empty rows and columns round it, and its new origin: a wide map costs no more."""
    origin = np.asarray(origin_enu_m, dtype=np.float64)
    if heights_m.ndim != 2 or not (filled := heights_m > 0.0).any():
        return heights_m, origin
    rows, cols = box_of(filled)
    return heights_m[rows, cols], origin + np.array([cols.start, rows.start]) * cell_m


@njit(cache=True)
def _slope(p: FloatArray, w: FloatArray, s: float, box: FloatArray) -> float:
    """Half the derivative in s of the squared distance of p + s·w to the box."""
    slope = 0.0
    for c in range(3):
        x = p[c] + s * w[c]
        slope += w[c] * (min(x - box[2 * c], 0.0) + max(x - box[2 * c + 1], 0.0))
    return slope


@njit(cache=True)
def _distance2(p: FloatArray, w: FloatArray, s: float, box: FloatArray) -> float:
    """The squared distance of p + s·w to the box."""
    distance2 = 0.0
    for c in range(3):
        x = p[c] + s * w[c]
        over = max(box[2 * c] - x, x - box[2 * c + 1], 0.0)
        distance2 += over * over
    return distance2


@njit(cache=True)
def _way_distance2(p: FloatArray, w: FloatArray, box: FloatArray) -> float:
    """The least squared distance of p + s·w, s in [0, 1], to the box.

    It is convex in s and its slope is piecewise linear, so false position (Illinois) ends in a few steps.
    """
    low, high = 0.0, 1.0
    slope_low, slope_high = _slope(p, w, low, box), _slope(p, w, high, box)
    s, last, flat = low, 0.0, 1e-12 * (slope_high - slope_low)
    if slope_low < 0.0 and slope_high <= 0.0:
        s = high
    while slope_low < -flat and slope_high > flat:
        s = (low * slope_high - high * slope_low) / (slope_high - slope_low)
        if not low < s < high:  # a way so short that rounding keeps every slope from being flat
            break
        slope = _slope(p, w, s, box)
        if abs(slope) <= flat:
            break
        if slope > 0.0:
            high, slope_high = s, slope
            slope_low *= 0.5 if last > 0.0 else 1.0
        else:
            low, slope_low = s, slope
            slope_high *= 0.5 if last < 0.0 else 1.0
        last = slope
    distance2: float = _distance2(p, w, s, box)
    return distance2


@njit(cache=True)
def _distances(
    pyramid: FloatArray,
    shape: tuple[int, int],
    cell: float,
    origin: FloatArray,
    positions: FloatArray,
    sweeps: FloatArray,
    farthest: float,
    enough: float,
    least: bool,
) -> tuple[FloatArray, int]:
    # Nothing is looked for beyond `farthest`, nor further where a box is nearer than `enough`; for the `least` of all,
    # nothing beyond the least so far. That way comes back with them.
    # Node (level, r, c) is pyramid[(4^level - 1)/3 + r·2^level + c]; level 0 is the whole grid.
    levels = 0
    while ((1 << (2 * (levels + 1))) - 1) // 3 < len(pyramid):
        levels += 1
    stack = np.empty((4 * levels + 4, 3), dtype=np.int64)
    north_east = origin[0] + shape[1] * cell, origin[1] + shape[0] * cell
    box = np.zeros(6)
    box[4] = -FOUNDATION_M
    distances = np.empty(len(positions))
    near_r = near_c = -1
    nearest = 0
    for k in range(len(positions)):
        p, w = positions[k], sweeps[k]
        # Two distances that the way's own is never less than, and cheap: its bounding box's and, beside it in plan, its line's.
        west, east = min(p[0], p[0] + w[0]), max(p[0], p[0] + w[0])
        south, north = min(p[1], p[1] + w[1]), max(p[1], p[1] + w[1])
        low = min(p[2], p[2] + w[2])
        length = max(math.sqrt(w[0] * w[0] + w[1] * w[1]), 1e-12)
        nx, ny = -w[1] / length, w[0] / length
        line = nx * p[0] + ny * p[1]
        best = farthest * farthest
        if near_r >= 0 and not least:
            _place(box, origin, north_east, cell, near_r, near_c)
            box[5] = pyramid[((1 << (2 * levels)) - 1) // 3 + (near_r << levels) + near_c]
            best = min(best, _way_distance2(p, w, box))
        stack[0] = 0
        top = 1
        while top > 0 and not best < enough * enough:
            top -= 1
            level, r, c = stack[top]
            height = pyramid[((1 << (2 * level)) - 1) // 3 + (r << level) + c]
            if height <= 0.0:
                continue
            size = cell * (1 << (levels - level))
            _place(box, origin, north_east, size, r, c)
            box[5] = height
            across = max(box[0] - east, west - box[1], 0.0)
            along = max(box[2] - north, south - box[3], 0.0)
            over = max(low - height, 0.0)
            if across * across + along * along + over * over >= best:
                continue
            middle = 0.5 * (nx * (box[0] + box[1]) + ny * (box[2] + box[3]))
            half_width = 0.5 * (abs(nx) * (box[1] - box[0]) + abs(ny) * (box[3] - box[2]))
            beside = max(abs(middle - line) - half_width, 0.0)
            if beside * beside + over * over >= best:
                continue
            if level == levels:
                distance2 = _way_distance2(p, w, box)
                if distance2 < best:
                    best, near_r, near_c = distance2, r, c
                continue
            for child in range(4):
                stack[top, 0] = level + 1
                stack[top, 1] = 2 * r + child // 2
                stack[top, 2] = 2 * c + child % 2
                top += 1
        distances[k] = farthest if best == farthest * farthest else math.sqrt(best)
        if distances[k] < distances[nearest]:
            nearest = k
        if least:
            farthest = min(farthest, distances[k])
    return distances, nearest


@njit(cache=True)
def _place(
    box: FloatArray, origin: FloatArray, north_east: tuple[float, float], size: float, r: int, c: int
) -> None:
    """Where the box stands of the node in row r and column c of its level: no farther than the grid goes."""
    box[0], box[1] = origin[0] + c * size, min(origin[0] + (c + 1) * size, north_east[0])
    box[2], box[3] = origin[1] + r * size, min(origin[1] + (r + 1) * size, north_east[1])
