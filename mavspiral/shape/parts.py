"""The parts of a building that one spiral each goes around: the tree of its superlevel sets.

Dilated by the stand-off, what reaches a level falls into components, and those of a higher level lie inside
those of a lower one: a tree. A part follows one branch of it upward, and ends at the roof where the branch
forks into several that are high enough for a spiral of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.distance import cells_away
from mavspiral.shape.heightmap import box_of
from mavspiral.shape.slicing import SolidDistance

__all__ = ["LeftOut", "Part", "parts_of"]


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A piece of the building too low for a spiral of its own, from `base_m` to its highest roof `top_m`.

    `bounds_enu_m` are its west, south, east and north edge.
    """

    bounds_enu_m: tuple[float, float, float, float]
    base_m: float
    top_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One branch from the roof or ground `base_m` up: all its outlines go around `anchor_enu_m` (2,).

    `top_m` is its highest roof; a part that `forks` has others on it. `parent` is the index of the part that it
    stands on.
    """

    anchor_enu_m: FloatArray
    base_m: float
    top_m: float
    parent: int | None
    forks: bool
    left_out: tuple[LeftOut, ...]


def parts_of(
    solid: SolidDistance, *, standoff_m: float, worth: Callable[[float, float], bool]
) -> tuple[Part, ...]:
    """The parts, each after the one that it stands on.

    `worth(base_m, top_m)` tells which branches, from a fork to their highest roof, are high enough. Where fewer
    than two are, the branch goes on along the one that is, or else along the one with the most volume.
    """
    parts: list[Part] = []
    heights_m = _heights(solid)

    def follow(kept: NDArray[np.bool_], level: int, base_m: float, parent: int | None) -> None:
        """One branch, and after it those on it, from the component `kept` of the level below `level`."""
        left_out: list[LeftOut] = []
        begin_m, roofs, fork = base_m, kept, None
        while level < len(solid.levels_m):
            branches = _branches(solid, kept, level, standoff_m, heights_m, base_m)
            if not branches:
                break
            worthy = [b for b in branches if worth(base_m, b.top_m)]
            best = max(worthy or branches, key=lambda b: b.volume)
            dropped = [b for b in branches if b is not best and b not in worthy]
            left_out += [_left_out(solid, b.roofs, base_m) for b in dropped]
            if len(worthy) > 1:
                fork = worthy
                break
            kept, roofs = best.dilated, best.roofs
            base_m = float(solid.levels_m[level])
            level += 1
        ends_here = base_m > begin_m  # else it forks at once: blocks that never touch
        index = parent
        if ends_here:
            anchor = _deepest(roofs)
            position = solid.origin_enu_m + np.array([anchor[1], anchor[0]]) * solid.cell_m
            index = len(parts)
            parts.append(Part(position, begin_m, base_m, parent, fork is not None, tuple(left_out)))
        for branch in fork or ():
            follow(branch.dilated, level, base_m, index)

    follow(np.ones(solid.plan_m.shape[1:], dtype=np.bool_), 0, 0.0, None)
    return tuple(parts)


@dataclass(frozen=True, slots=True, eq=False)
class _Branch:
    """A component of a level: its cells' corners `roofs` and those within the stand-off, `dilated`."""

    roofs: NDArray[np.bool_]
    dilated: NDArray[np.bool_]
    volume: float
    top_m: float


def _branches(
    solid: SolidDistance,
    kept: NDArray[np.bool_],
    level: int,
    standoff_m: float,
    heights_m: FloatArray,
    base_m: float,
) -> list[_Branch]:
    """The components of a level within `kept`."""
    plan = solid.plan_m[level]
    roofs = (plan == 0.0) & kept
    if not roofs.any():
        return []
    count, labels = cv2.connectedComponents(((plan <= standoff_m) & kept).view(np.uint8))
    of, above_m = labels[roofs], heights_m[roofs] - base_m
    volumes = np.bincount(of, weights=above_m, minlength=count)
    tops_m = np.zeros(count)
    np.maximum.at(tops_m, of, above_m)
    found = []
    for label in np.flatnonzero(volumes > 0.0):
        dilated = labels == label
        found.append(_Branch(roofs & dilated, dilated, float(volumes[label]), base_m + float(tops_m[label])))
    return found


def _heights(solid: SolidDistance) -> FloatArray:
    """The height of what touches each corner of the grid."""
    heights = np.zeros(solid.plan_m.shape[1:])
    for plan, level_m in zip(solid.plan_m, solid.levels_m, strict=True):
        heights[plan == 0.0] = level_m
    return heights


def _deepest(mask: NDArray[np.bool_]) -> tuple[int, int]:
    """Row and column of the place farthest from the edge of `mask`."""
    rows, cols = box_of(mask)
    depth = cells_away(~np.pad(mask[rows, cols], 1))
    row, col = np.unravel_index(int(np.argmax(depth)), depth.shape)
    return int(rows.start + row - 1), int(cols.start + col - 1)


def _left_out(solid: SolidDistance, mask: NDArray[np.bool_], base_m: float) -> LeftOut:
    rows, cols = box_of(mask)
    west, south = solid.origin_enu_m + np.array([cols.start, rows.start]) * solid.cell_m
    east, north = solid.origin_enu_m + np.array([cols.stop - 1, rows.stop - 1]) * solid.cell_m
    reached = (solid.plan_m[:, mask] == 0.0).any(axis=1)
    return LeftOut(
        (float(west), float(south), float(east), float(north)), base_m, float(solid.levels_m[reached].max())
    )
