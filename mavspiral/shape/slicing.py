"""Distance in space to a building of solid boxes, and its slices.

A stand-off is a distance in space: the ring above a podium must keep it from the podium's roof as well. With
the roofs at `J` levels `H_j` and `E_j(x)` the distance in plan from `x` to the cells that reach `H_j`,

    D_h(x)² = min over j of  E_j(x)² + max(0, h − H_j)²

is the exact squared distance of `(x, h)` to the solid. So `J` plan transforms serve every height, and

    D_h(x) ≤ d    if and only if    E_j(x) ≤ ρ_j for some j,    ρ_j = √(d² − max(0, h − H_j)²),

which makes a slice a few thresholds. The `E_j` are sampled at the corners of the cells, not at their centres:
seen from a corner of the grid, the nearest point of a square cell is always a corner of that cell, so the
transform of the corners is exact for the squares, and there is no half cell to correct.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.shape.heightmap import Site

__all__ = ["Slice", "SolidDistance", "solid_distance"]

MAX_LEVELS = 48
"""Roofs with more levels than this are rounded up, to the safe side, by 1/48 of their range at the most."""


@dataclass(frozen=True, slots=True)
class Slice:
    """What lies within a distance of the solid at a height: `radii_m[i]` in plan of roof level `levels[i]`.

    Equal slices have equal outlines, whatever their heights.
    """

    levels: tuple[int, ...]
    radii_m: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SolidDistance:
    """Distance to a building: `solid(position_enu_m)`.

    `plan_m[j, r, c]` is the distance in plan from the south-west corner of cell `[r, c]` to the nearest cell
    that reaches `levels_m[j]`. Levels ascend.
    """

    levels_m: FloatArray
    plan_m: NDArray[np.float32]
    cell_m: float
    origin_enu_m: FloatArray

    def __call__(self, position_enu_m: ArrayLike) -> FloatArray:
        """The distance `(…)` of each position `(…, 3)`; exact on the map, too small beyond its edge."""
        position = np.asarray(position_enu_m, dtype=np.float64)
        flat = np.ascontiguousarray(position.reshape(-1, 3))
        distance = _distance(flat, self.levels_m, self.plan_m, self.cell_m, self.origin_enu_m)
        return distance.reshape(position.shape[:-1])

    def slice(self, height_m: float, distance_m: float) -> Slice:
        """What lies within `distance_m` of the solid at `height_m`."""
        drop = np.maximum(0.0, height_m - self.levels_m)
        near = np.flatnonzero(drop < distance_m)
        # Of the levels at or above the height, the lowest holds all the others.
        reaching = near[drop[near] == 0.0]
        near = near[: near.size - max(0, reaching.size - 1)]
        radii = np.sqrt(distance_m**2 - drop[near] ** 2)
        return Slice(tuple(near.tolist()), tuple(radii.tolist()))

    def inside(self, cut: Slice) -> NDArray[np.bool_]:
        """Which corners of the grid lie in the slice."""
        mask = np.zeros(self.plan_m.shape[1:], dtype=np.bool_)
        for level, radius in zip(cut.levels, cut.radii_m, strict=True):
            mask |= self.plan_m[level] <= np.float32(radius)
        return mask

    def onto_border(self, cut: Slice, points_enu_m: FloatArray) -> FloatArray:
        """Points `(M, 2)` near the border of a slice, moved along the distance's gradient onto it."""
        levels = np.array(cut.levels, dtype=np.int64)
        radii = np.array(cut.radii_m, dtype=np.float64)
        return _onto_border(points_enu_m, levels, radii, self.plan_m, self.cell_m, self.origin_enu_m)


def solid_distance(site: Site, *, reach_m: float) -> SolidDistance:
    """The distance to the building of `site`, on a map that reaches `reach_m` beyond its walls.

    Raises:
        InputError: no cell of the building stands above the ground.
    """
    heights = site.building_height_m
    rows, cols = np.nonzero(heights > 0.0)
    if rows.size == 0:
        raise InputError("no cell of the building stands above the ground, so there is nothing to fly around")
    cell_m = site.heights.cell_m
    pad = int(np.ceil(reach_m / cell_m)) + 2
    block = np.pad(heights[rows.min() : rows.max() + 1, cols.min() : cols.max() + 1], pad + 1)
    levels = np.unique(block[block > 0.0])
    if levels.size > MAX_LEVELS:
        grid = np.linspace(0.0, levels[-1], MAX_LEVELS + 1)[1:]
        block = np.where(block > 0.0, grid[np.minimum(np.searchsorted(grid, block), MAX_LEVELS - 1)], 0.0)
        levels = np.unique(block[block > 0.0])
    corners = np.maximum.reduce([block[:-1, :-1], block[:-1, 1:], block[1:, :-1], block[1:, 1:]])
    plan = np.empty((levels.size, *corners.shape), dtype=np.float32)
    for j, level in enumerate(levels):
        below = (corners < level).astype(np.uint8)
        plan[j] = cv2.distanceTransform(below, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    plan *= np.float32(cell_m)
    first = np.array([cols.min() - pad, rows.min() - pad])
    origin = site.heights.origin_enu_m + first * cell_m
    for array in (levels, plan, origin):
        array.setflags(write=False)
    return SolidDistance(levels, plan, cell_m, origin)


@njit(cache=True)
def _at(x, y, field):  # type: ignore[no-untyped-def]
    """The bilinear value of `field` at column `x` and row `y`, and its slopes along both."""
    rows, cols = field.shape
    x = min(max(x, 0.0), cols - 1.0)
    y = min(max(y, 0.0), rows - 1.0)
    c = min(int(x), cols - 2)
    r = min(int(y), rows - 2)
    s, t = x - c, y - r
    a, b = float(field[r, c]), float(field[r, c + 1])
    d, e = float(field[r + 1, c]), float(field[r + 1, c + 1])
    south, north = a + s * (b - a), d + s * (e - d)
    return south + t * (north - south), (1.0 - t) * (b - a) + t * (e - d), north - south


@njit(cache=True)
def _distance(position, levels, plan, cell, origin):  # type: ignore[no-untyped-def]
    """D of the module's first equation, at positions `(M, 3)`."""
    out = np.empty(position.shape[0])
    for i in range(position.shape[0]):
        x = (position[i, 0] - origin[0]) / cell
        y = (position[i, 1] - origin[1]) / cell
        best = np.inf
        for j in range(levels.size):
            drop = max(0.0, position[i, 2] - levels[j])
            if drop * drop < best:
                e, _, _ = _at(x, y, plan[j])
                best = min(best, e * e + drop * drop)
            if drop == 0.0:
                break
        out[i] = np.sqrt(best)
    return out


@njit(cache=True)
def _onto_border(points, chosen, radii, plan, cell, origin):  # type: ignore[no-untyped-def]
    """Newton's steps onto min_j(E_j − ρ_j) = 0, each at most one cell long."""
    out = np.empty_like(points)
    for i in range(points.shape[0]):
        x = (points[i, 0] - origin[0]) / cell
        y = (points[i, 1] - origin[1]) / cell
        for _ in range(4):
            excess, gx, gy = np.inf, 0.0, 0.0
            for k in range(chosen.size):
                e, ex, ey = _at(x, y, plan[chosen[k]])
                if e - radii[k] < excess:
                    excess, gx, gy = e - radii[k], ex, ey
            slope = np.sqrt(gx * gx + gy * gy)
            if abs(excess) < 1e-4 * cell or slope < 0.1 * cell:
                break
            step = min(max(-excess / slope, -1.0), 1.0)
            x += step * gx / slope
            y += step * gy / slope
        out[i, 0] = origin[0] + x * cell
        out[i, 1] = origin[1] + y * cell
    return out
