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

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.shape.distance import cells_away
from mavspiral.shape.heightmap import Site, box_of

__all__ = ["Slice", "SolidDistance", "obstacle_distance", "solid_distance"]

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
    that reaches `levels_m[j]`. Levels ascend. Heights above a roof count `roof_ratio` times: with the stand-off
    over a smaller distance, the surface at the stand-off comes as near as that to roofs, but not to walls.
    """

    levels_m: FloatArray
    plan_m: NDArray[np.float32]
    cell_m: float
    origin_enu_m: FloatArray
    roof_ratio: float = 1.0

    def __call__(self, position_enu_m: ArrayLike) -> FloatArray:
        """The distance `(…)` of each position `(…, 3)`, a thousandth of a cell too much at the worst.

        It is too little by cell²/8E, 2 mm for cells of 0.25 m seen from 4 m, and by up to a third of a cell
        where two walls are equally near. Beyond the edge of the map it is that of the edge.
        """
        position = np.asarray(position_enu_m, dtype=np.float64)
        flat = np.ascontiguousarray(position.reshape(-1, 3))
        distance: FloatArray = _distance(
            flat, self.levels_m, self.plan_m, self.cell_m, self.origin_enu_m, self.roof_ratio
        )
        return distance.reshape(position.shape[:-1])

    def slice(self, height_m: float, distance_m: float, corner_radius_m: float = 0.0) -> Slice:
        """What lies within `distance_m` of the solid at `height_m`.

        Just below the height at which a roof drops out, its slice has nearly the roof's own sharp corners;
        with a `corner_radius_m` it keeps that radius until then, which is farther from the roof than need be.
        """
        levels, radii_m = [], []
        for level, level_m in enumerate(self.levels_m.tolist()):
            drop_m = self.roof_ratio * max(0.0, height_m - level_m)
            if drop_m < distance_m:
                levels.append(level)
                radius_m = math.sqrt(distance_m**2 - drop_m**2)
                radii_m.append(max(radius_m, min(corner_radius_m, distance_m)))
            if drop_m == 0.0:  # of the levels at or above the height, the lowest holds all the others
                break
        return Slice(tuple(levels), tuple(radii_m))

    def excess_m(self, cut: Slice) -> NDArray[np.float32]:
        """How far outside of the slice, in plan, each corner of the grid is; not above 0 inside."""
        field = np.full(self.plan_m.shape[1:], np.inf, dtype=np.float32)
        for level, radius in zip(cut.levels, cut.radii_m, strict=True):
            np.minimum(field, self.plan_m[level] - np.float32(radius), out=field)
        return field


def solid_distance(site: Site, *, reach_m: float) -> SolidDistance:
    """The distance to the building of `site`, on a map that reaches `reach_m` beyond its walls.

    Raises:
        InputError: no cell of the building stands above the ground.
    """
    box = site.building_box
    heights = np.where(site.building[box], np.maximum(site.heights.height_agl_m[box], 0.0), 0.0)
    rows, cols = box_of(heights > 0.0)
    if not rows.stop:
        raise InputError("no cell of the building stands above the ground, so there is nothing to fly around")
    cell_m = site.heights.cell_m
    pad = int(np.ceil(reach_m / cell_m)) + 2
    block = np.pad(heights[rows, cols], pad + 1)
    first = np.array([box[1].start + cols.start - pad, box[0].start + rows.start - pad])
    return _of_block(block, cell_m, site.heights.origin_enu_m + first * cell_m)


def obstacle_distance(site: Site, solid: SolidDistance) -> SolidDistance | None:
    """The distance to all that is not the building, on the grid of `solid`; None where nothing stands there."""
    rows, cols = (side + 1 for side in solid.plan_m.shape[1:])
    cell_m = solid.cell_m
    col, row = np.rint((solid.origin_enu_m - site.heights.origin_enu_m) / cell_m).astype(int) - 1
    box = slice(max(0, row), max(0, row + rows)), slice(max(0, col), max(0, col + cols))
    heights = site.heights.height_agl_m[box]
    stands = (heights > 0.0) & ~site.building[box]
    if not stands.any():
        return None
    there = np.where(stands, heights, 0.0)
    block = np.zeros((rows, cols))
    south, west = max(0, -row), max(0, -col)
    block[south : south + there.shape[0], west : west + there.shape[1]] = there
    return _of_block(block, cell_m, solid.origin_enu_m)


def _of_block(block: FloatArray, cell_m: float, origin_enu_m: FloatArray) -> SolidDistance:
    """The distance at the inner corners of the cells of `block`, the first of which lies at the origin."""
    levels = np.unique(block[block > 0.0])
    if levels.size > MAX_LEVELS:
        grid = np.linspace(0.0, levels[-1], MAX_LEVELS + 1)[1:]
        block = np.where(block > 0.0, grid[np.minimum(np.searchsorted(grid, block), MAX_LEVELS - 1)], 0.0)
        levels = np.unique(block[block > 0.0])
    sides = np.maximum(block[:, :-1], block[:, 1:])
    corners = np.maximum(sides[:-1], sides[1:])
    plan = np.empty((levels.size, *corners.shape), dtype=np.float32)
    for j, level in enumerate(levels):
        plan[j] = cells_away(corners >= level)
    plan *= np.float32(cell_m)
    origin = np.array(origin_enu_m)
    for array in (levels, plan, origin):
        array.setflags(write=False)
    return SolidDistance(levels, plan, cell_m, origin)


@njit(cache=True)
def _distance(
    position: FloatArray,
    levels: FloatArray,
    plan: NDArray[np.float32],
    cell: float,
    origin: FloatArray,
    ratio: float,
) -> FloatArray:
    """D of the module's first equation at positions `(M, 3)`.

    Between the corners the E_j are bilinear. Where an E bends most, around a corner of the building, that is
    too much by cell²/8E at the most, which is taken off.
    """
    out = np.empty(position.shape[0])
    rows, cols = plan.shape[1:]
    for i in range(position.shape[0]):
        x = min(max((position[i, 0] - origin[0]) / cell, 0.0), cols - 1.0)
        y = min(max((position[i, 1] - origin[1]) / cell, 0.0), rows - 1.0)
        c, r = min(int(x), cols - 2), min(int(y), rows - 2)
        s, t = x - c, y - r
        best = np.inf
        for j in range(levels.size):
            drop = ratio * max(0.0, position[i, 2] - levels[j])
            if drop * drop < best:
                south = (1.0 - s) * plan[j, r, c] + s * plan[j, r, c + 1]
                north = (1.0 - s) * plan[j, r + 1, c] + s * plan[j, r + 1, c + 1]
                e = (1.0 - t) * south + t * north
                if e > 0.0:
                    e = max(0.0, e - 0.125 * cell * cell / e)
                best = min(best, e * e + drop * drop)
            if drop == 0.0:
                break
        out[i] = np.sqrt(best)
    return out
