"""What stands on the ground: a grid of solid boxes, and which of them are the building to inspect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray, locked
from mavspiral.frames import LocalFrame

__all__ = ["HeightMap", "Site", "box_of"]


@dataclass(frozen=True, slots=True, eq=False)
class HeightMap:
    """Heights above ground per cell. A cell is a solid box from the ground (z = 0) to its height.

    Row 0 is the southernmost, column 0 the westernmost. Cell `[r, c]` covers `x` from
    `origin_enu_m[0] + c·cell_m` to one cell further east, and `y` likewise with `r`, to the north.
    """

    height_agl_m: FloatArray
    cell_m: float
    frame: LocalFrame
    origin_enu_m: FloatArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the fields."""
        heights = locked(self.height_agl_m, shape=(None, None), name="height_agl_m")
        if heights.size == 0:
            raise ValueError(f"height_agl_m is empty: shape {heights.shape}")
        if not (np.isfinite(self.cell_m) and self.cell_m > 0.0):
            raise ValueError(f"cell_m is {self.cell_m}, wanted a positive number")
        object.__setattr__(self, "height_agl_m", heights)
        object.__setattr__(self, "cell_m", float(self.cell_m))
        object.__setattr__(self, "origin_enu_m", locked(self.origin_enu_m, shape=(2,), name="origin_enu_m"))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, cols = self.height_agl_m.shape
        return rows, cols

    @property
    def bounds_enu_m(self) -> tuple[float, float, float, float]:
        """West, south, east and north edge."""
        rows, cols = self.shape
        west, south = (float(v) for v in self.origin_enu_m)
        return west, south, west + cols * self.cell_m, south + rows * self.cell_m

    @property
    def top_m(self) -> float:
        """The height of the highest cell."""
        return float(self.height_agl_m.max())

    def centres_enu_m(self) -> tuple[FloatArray, FloatArray]:
        """East of every column and north of every row, at the cells' centres."""
        rows, cols = self.shape
        west, south = self.origin_enu_m
        return west + (np.arange(cols) + 0.5) * self.cell_m, south + (np.arange(rows) + 0.5) * self.cell_m

    def index(self, position_enu_m: ArrayLike) -> NDArray[np.int64]:
        """Row and column `(…, 2)` of the cell that holds each position, on an endless grid.

        Positions are in plan or, with a height that is ignored, in space.
        """
        plan = np.asarray(position_enu_m, dtype=np.float64)[..., :2]
        cells = np.floor((plan - self.origin_enu_m) / self.cell_m)
        return cells[..., ::-1].astype(np.int64)

    def sample(self, position_enu_m: ArrayLike) -> FloatArray:
        """Height above ground `(…)` of what stands at each plan position; 0 outside the map."""
        row, col = np.moveaxis(self.index(position_enu_m), -1, 0)
        rows, cols = self.shape
        inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        return np.where(inside, self.height_agl_m[np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)], 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """Everything that stands there, and which of its cells are the building; the others are obstacles."""

    heights: HeightMap
    building: NDArray[np.bool_]

    def __post_init__(self) -> None:
        """Copies, checks and locks the fields."""
        mask = np.array(self.building, dtype=np.bool_)
        if mask.shape != self.heights.shape:
            raise ValueError(f"building has shape {mask.shape}, the map {self.heights.shape}")
        mask.setflags(write=False)
        object.__setattr__(self, "building", mask)

    @property
    def building_box(self) -> tuple[slice, slice]:
        """The rows and columns that hold the building; empty where there is none."""
        return box_of(self.building)

    @property
    def building_top_m(self) -> float:
        """The height of the building's highest cell; 0 where none stands above the ground."""
        box = self.building_box
        return float(self.heights.height_agl_m[box].max(where=self.building[box], initial=0.0))

    @property
    def building_height_m(self) -> FloatArray:
        """Heights of the building's cells, 0 elsewhere."""
        return np.where(self.building, np.maximum(self.heights.height_agl_m, 0.0), 0.0)

    def padded(self, margin_m: float) -> Site:
        """The same site with at least `margin_m` of empty ground added on every side.

        Raises:
            ValueError: the margin is negative.
        """
        if margin_m < 0.0:
            raise ValueError(f"margin_m is {margin_m}, wanted zero or more")
        heights = self.heights
        cells = int(np.ceil(margin_m / heights.cell_m))
        wider = HeightMap(
            np.pad(heights.height_agl_m, cells),
            heights.cell_m,
            heights.frame,
            heights.origin_enu_m - cells * heights.cell_m,
        )
        return Site(wider, np.pad(self.building, cells))


def box_of(cells: NDArray[np.bool_]) -> tuple[slice, slice]:
    """The rows and columns that hold all of the cells `(rows, cols)`; empty where there are none."""
    held = np.flatnonzero(cells.any(axis=1))
    if not held.size:
        return slice(0, 0), slice(0, 0)
    rows = slice(int(held[0]), int(held[-1]) + 1)
    held = np.flatnonzero(cells[rows].any(axis=0))
    return rows, slice(int(held[0]), int(held[-1]) + 1)
