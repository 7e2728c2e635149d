"""The roofs of a building: pieces of its top without a high step, on a grid as coarse as flying above them needs.

Where the cells of two neighbours differ by no more than a step, they are one roof: a gable, a dome, a terrace with
its parapet. The coarse cells take the highest of what they hold, so nothing that stands there is lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.distance import cells_away
from mavspiral.shape.heightmap import Site, box_of

__all__ = ["Roof", "RoofGrid", "roof_grid", "roofs_of"]

PITCH_M = 0.5
CELLS_MAX = 320
"""Along the longer side of the building: a larger one gets coarser cells."""

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class RoofGrid:
    """Heights of everything `(rows, cols)`, which cells hold the building, and where the south-west corner lies."""

    height_agl_m: FloatArray
    building: BoolArray
    cell_m: float
    origin_enu_m: FloatArray

    def distance_m(self, mask: BoolArray) -> FloatArray:
        """Signed distance in plan of each cell's centre to the edge of `mask`: positive outside, infinite without one."""
        if not mask.any():
            return np.full(mask.shape, np.inf)
        cells = np.where(mask, 0.5 - cells_away(~mask), cells_away(mask) - 0.5)
        return np.asarray(cells * self.cell_m, dtype=np.float64)

    def slope_enu(self, cells: BoolArray) -> FloatArray:
        """The rise per metre east and north `(n, 2)` of each of `cells`, by those beside it that are among them."""
        slopes = []
        for height, mask in ((self.height_agl_m, cells), (self.height_agl_m.T, cells.T)):
            both = np.pad(mask[:, 1:] & mask[:, :-1], ((0, 0), (1, 1)))
            step = np.pad(np.diff(height, axis=1), ((0, 0), (1, 1))) * both
            rise = (step[:, :-1] + step[:, 1:]) / np.maximum(both[:, :-1].astype(int) + both[:, 1:], 1)
            slopes.append(rise / self.cell_m)
        return np.stack([slopes[0][cells], slopes[1].T[cells]], axis=1)

    def centres_enu_m(self, mask: BoolArray) -> FloatArray:
        """The centres `(n, 2)` of the cells of `mask`."""
        row, col = np.nonzero(mask)
        centres: FloatArray = self.origin_enu_m + (np.stack([col, row], axis=1) + 0.5) * self.cell_m
        return centres

    def index(self, place_enu_m: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Row and column of the cells that hold places `(n, 2)`, moved onto the grid."""
        cells = np.floor((place_enu_m - self.origin_enu_m) / self.cell_m).astype(np.int64)
        rows, cols = self.height_agl_m.shape
        return np.clip(cells[:, 1], 0, rows - 1), np.clip(cells[:, 0], 0, cols - 1)


@dataclass(frozen=True, slots=True, eq=False)
class Roof:
    """One roof: its cells on the grid and the height of the highest."""

    cells: BoolArray
    high_m: float


def roof_grid(site: Site, reach_m: float) -> RoofGrid:
    """The building of `site` and what stands within `reach_m` of it, `reach_m` of ground around it at the least."""
    heights = site.heights
    stands = site.building & (heights.height_agl_m > 0.0)
    rows, cols = box_of(stands)
    long_m = (max(rows.stop - rows.start, cols.stop - cols.start) - 1) * heights.cell_m
    pool = max(1, int(max(PITCH_M, long_m / CELLS_MAX) / heights.cell_m + 1e-9))
    pad = int(np.ceil(reach_m / heights.cell_m)) + 1
    first = np.array([rows.start - pad, cols.start - pad])
    count = np.ceil((np.array([rows.stop, cols.stop]) + pad - first) / pool).astype(np.int64)
    low = np.maximum(first, 0)
    high = np.minimum(first + count * pool, heights.shape)
    here = (slice(low[0], high[0]), slice(low[1], high[1]))
    there = (slice(low[0] - first[0], high[0] - first[0]), slice(low[1] - first[1], high[1] - first[1]))
    height = np.zeros(count * pool)
    height[there] = np.maximum(heights.height_agl_m[here], 0.0)
    building = np.zeros(count * pool, dtype=np.bool_)
    building[there] = stands[here]
    return RoofGrid(
        np.maximum.reduce(_blocks(height, pool)),
        np.logical_or.reduce(_blocks(building, pool)),
        heights.cell_m * pool,
        heights.origin_enu_m + first[::-1] * heights.cell_m,
    )


def _blocks(values: NDArray[Any], side: int) -> list[NDArray[Any]]:
    """The values at each place of blocks of `side` by `side`."""
    return [values[r::side, c::side] for r in range(side) for c in range(side)]


def roofs_of(grid: RoofGrid, *, step_m: float, least_m2: float) -> tuple[Roof, ...]:
    """The building's roofs of `least_m2` or more, the highest first; neighbouring cells of one differ by at most `step_m`."""
    labels = _flooded(grid.height_agl_m, grid.building, step_m)
    areas_m2 = np.bincount(labels.ravel())[1:] * grid.cell_m**2
    roofs = []
    for label in np.flatnonzero(areas_m2 >= least_m2) + 1:
        cells = labels == label
        roofs.append(Roof(cells, float(grid.height_agl_m[cells].max())))
    return tuple(sorted(roofs, key=lambda roof: -roof.high_m))


@njit(cache=True)
def _flooded(height: FloatArray, building: BoolArray, step: float) -> NDArray[np.int64]:
    """A label from 1 on for each piece of the building without a high step; 0 elsewhere."""
    rows, cols = height.shape
    labels = np.zeros((rows, cols), dtype=np.int64)
    queue = np.empty((rows * cols, 2), dtype=np.int64)
    label = 0
    for r in range(rows):
        for c in range(cols):
            if not building[r, c] or labels[r, c] != 0:
                continue
            label += 1
            labels[r, c] = label
            queue[0, 0], queue[0, 1] = r, c
            head, tail = 0, 1
            while head < tail:
                i, j = queue[head]
                head += 1
                for side in range(4):
                    k = i + (1 if side == 0 else -1 if side == 1 else 0)
                    m = j + (1 if side == 2 else -1 if side == 3 else 0)
                    if k < 0 or k >= rows or m < 0 or m >= cols or not building[k, m] or labels[k, m] != 0:
                        continue
                    if abs(height[k, m] - height[i, j]) > step:
                        continue
                    labels[k, m] = label
                    queue[tail, 0], queue[tail, 1] = k, m
                    tail += 1
    return labels
