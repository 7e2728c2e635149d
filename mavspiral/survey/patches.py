"""The building's skin in small pieces: what a survey must see.

The cells of a wall that does not run along the grid are a staircase. Its treads and risers are not the wall: a
camera square to a wall at 45° would see both at 45°, and their areas add up to √2 of the wall's. So the normal of a
face is that of the faces around it, and its area is what it covers of a wall with that normal; straight runs
along the grid keep the grid's own normal, so that their corners stay sharp. A gable's cells are a staircase, too: the
normal of a roof cell is that of the slope around it, and its area what it covers of that slope.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray, locked
from mavspiral.shape.heightmap import Site

__all__ = ["Patches", "patches_of"]

PATCH_M = 1.0
WALL_MIN_M = 0.5
"""A lower step is roughness of a roof, such as the cells of a gable, and no wall."""

RUN_CELLS = 7
"""A straight run of at least so many cells lies along the grid; a wall that slants may then be 8° off. Odd, for the opening."""

SLOPE_CELLS = 5
"""The slope of a roof cell is that of a window of so many cells: the treads of a staircase of cells are no roof."""

SIDES_ENU = np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]])
"""East, north, west, south and up: what `Patches.side` counts."""


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Pieces of wall (`side` 0 to 3) and of roof (`side` 4), sorted by height.

    `before_enu_m` lies just before each patch, outside the staircase of the cells: there sight ends. `height_m` is
    how high a piece of wall is, from `centre_enu_m` up and down by one half; that of a roof is 0.
    """

    centre_enu_m: FloatArray
    before_enu_m: FloatArray
    normal_enu: FloatArray
    area_m2: FloatArray
    height_m: FloatArray
    side: NDArray[np.int64]
    cell_m: float

    def __post_init__(self) -> None:
        """Copies, checks and locks the fields."""
        n = len(self.side)
        for name in ("centre_enu_m", "before_enu_m", "normal_enu"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(n, 3), name=name))
        for name in ("area_m2", "height_m"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(n,), name=name))
        self.side.setflags(write=False)

    def __len__(self) -> int:
        """How many there are."""
        return len(self.side)

    @property
    def is_wall(self) -> NDArray[np.bool_]:
        """Which patches are pieces of wall."""
        return np.asarray(self.side < 4)


def patches_of(site: Site, patch_m: float = PATCH_M) -> Patches:
    """Every exposed vertical face of the building's cells, in pieces of at most `patch_m` of height, and every roof cell.

    A face is exposed above the height of the next cell, whatever stands there.
    """
    heights = np.pad(np.maximum(site.heights.height_agl_m, 0.0), 1)
    own_m = heights[1:-1, 1:-1]
    beside_m = [heights[1:-1, 2:], heights[2:, 1:-1], heights[1:-1, :-2], heights[:-2, 1:-1]]
    exposed = [site.building & (own_m - next_m >= WALL_MIN_M) for next_m in beside_m]
    normals = _wall_normals(exposed)
    columns = [_faces(site, side, exposed[side], beside_m[side], normals[side], patch_m) for side in range(4)]
    columns.append(_roof(site, heights))
    centre, normal, area, height, side = (np.concatenate(column) for column in zip(*columns, strict=True))
    order = np.argsort(centre[:, 2], kind="stable")
    centre, normal, side = centre[order], normal[order], side[order]
    return Patches(
        centre_enu_m=centre,
        before_enu_m=_before(site, centre, normal, side),
        normal_enu=normal,
        area_m2=area[order],
        height_m=height[order],
        side=side,
        cell_m=site.heights.cell_m,
    )


def _wall_normals(exposed: list[NDArray[np.bool_]]) -> list[FloatArray]:
    """For each side, the plan normals `(n, 2)` of the walls that its exposed faces belong to, row by row."""
    window = (2 * RUN_CELLS + 1,) * 2
    east, north, west, south = (
        cv2.boxFilter(
            mask.astype(np.float32), cv2.CV_32F, window, normalize=False, borderType=cv2.BORDER_CONSTANT
        )
        for mask in exposed
    )
    normals = []
    for side, mask in enumerate(exposed):
        outward = SIDES_ENU[side, :2]
        # The faces around, but for those that look the other way: the back of a thin wall.
        normal = np.stack([(east - west)[mask], (north - south)[mask]], axis=-1).astype(np.float64)
        normal[:, side % 2] = (east, north, west, south)[side][mask] * outward[side % 2]
        run = np.ones((RUN_CELLS, 1) if side % 2 == 0 else (1, RUN_CELLS), dtype=np.uint8)
        padded = np.pad(mask, RUN_CELLS).astype(np.uint8)
        straight = cv2.morphologyEx(padded, cv2.MORPH_OPEN, run)[RUN_CELLS:-RUN_CELLS, RUN_CELLS:-RUN_CELLS]
        normal[straight[mask] > 0] = outward
        normals.append(normal / np.sqrt((normal**2).sum(axis=1, keepdims=True)))
    return normals


def _faces(
    site: Site,
    side: int,
    exposed: NDArray[np.bool_],
    beside_m: FloatArray,
    normals: FloatArray,
    patch_m: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
    """Centre, normal, area, height and side of the pieces of all faces that look to `side`."""
    cell_m = site.heights.cell_m
    east_m, north_m = site.heights.centres_enu_m()
    row, col = np.nonzero(exposed)
    low_m = beside_m[row, col]
    high_m = site.heights.height_agl_m[row, col]
    pieces = np.ceil((high_m - low_m) / patch_m - 1e-9).astype(np.int64)
    face = np.repeat(np.arange(len(row)), pieces)
    piece = np.arange(len(face)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    bottom_m = low_m[face] + piece * patch_m
    height_m = np.minimum(bottom_m + patch_m, high_m[face]) - bottom_m
    outward = SIDES_ENU[side]
    centre = np.stack(
        [
            east_m[col[face]] + 0.5 * cell_m * outward[0],
            north_m[row[face]] + 0.5 * cell_m * outward[1],
            bottom_m + 0.5 * height_m,
        ],
        axis=1,
    )
    normal = np.zeros((len(face), 3))
    normal[:, :2] = normals[face]
    area_m2 = cell_m * height_m * (normal @ outward)
    return centre, normal, area_m2, height_m, np.full(len(face), side)


def _roof(
    site: Site, padded_m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
    """Centre, normal, area, height and side of every roof cell; `padded_m` are the heights with a cell more all around."""
    heights = site.heights
    east_m, north_m = heights.centres_enu_m()
    row, col = np.nonzero(site.building & (heights.height_agl_m > 0.0))
    centre = np.stack([east_m[col], north_m[row], heights.height_agl_m[row, col]], axis=1)
    slope = np.stack([_slope(padded_m, axis)[row, col] for axis in (1, 0)], axis=1) / heights.cell_m
    normal = np.column_stack([-slope, np.ones(len(row))])
    normal /= np.sqrt((normal**2).sum(axis=1, keepdims=True))
    n = len(row)
    return centre, normal, heights.cell_m**2 / normal[:, 2], np.zeros(n), np.full(n, 4)


def _slope(padded_m: FloatArray, axis: int) -> FloatArray:
    """The rise from cell to cell along an axis, the mean of the steps around that are lower than a wall."""
    across_m = padded_m[1:-1] if axis == 1 else padded_m[:, 1:-1].T
    step_m = np.diff(across_m, axis=1)
    roof = (np.abs(step_m) < WALL_MIN_M) & (np.minimum(across_m[:, 1:], across_m[:, :-1]) > 0.0)
    sums = [
        cv2.boxFilter(values, cv2.CV_32F, (SLOPE_CELLS,) * 2, normalize=False, borderType=cv2.BORDER_CONSTANT)
        for values in ((step_m * roof).astype(np.float32), roof.astype(np.float32))
    ]
    # The window about a cell: of the steps to it and from it.
    rise, count = (values[:, :-1] + values[:, 1:] for values in sums)
    slope = np.asarray(rise / np.maximum(count, 1.0), dtype=np.float64)
    return slope if axis == 1 else slope.T


def _before(
    site: Site, centre_enu_m: FloatArray, normal_enu: FloatArray, side: NDArray[np.int64]
) -> FloatArray:
    """Half a cell before each piece of wall: along its normal, or square to its face where that is inside a cell."""
    half_m = np.where(side < 4, 0.5 * site.heights.cell_m, 0.0)[:, None]
    before = centre_enu_m + half_m * normal_enu
    inside = site.heights.sample(before) > before[:, 2]
    before[inside] = (centre_enu_m + half_m * SIDES_ENU[side])[inside]
    return before
