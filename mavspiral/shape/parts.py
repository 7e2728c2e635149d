"""Which part of a building one spiral goes around, and what that leaves out.

Dilated by the stand-off, what reaches a level falls into components, and those of a higher level lie inside
those of a lower one: a tree. One spiral climbs one branch of it, at every fork the one with the most volume.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.slicing import SolidDistance

__all__ = ["LeftOut", "Part", "main_part"]


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A piece of the building that the spiral does not go around, from `base_m` to its highest roof `top_m`.

    `bounds_enu_m` are its west, south, east and north edge.
    """

    bounds_enu_m: tuple[float, float, float, float]
    base_m: float
    top_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One branch: all its outlines go around `anchor_enu_m` (2,), and its highest roof is `top_m`."""

    anchor_enu_m: FloatArray
    top_m: float
    left_out: tuple[LeftOut, ...]


def main_part(solid: SolidDistance, *, standoff_m: float) -> Part:
    """The branch of the building with the most volume at every fork."""
    kept = np.ones(solid.plan_m.shape[1:], dtype=np.bool_)
    left_out: list[LeftOut] = []
    heights_m = _heights(solid)
    base_m = 0.0
    anchor = (0, 0)
    top_m = 0.0
    for plan, level_m in zip(solid.plan_m, solid.levels_m, strict=True):
        solid_here = (plan == 0.0) & kept
        if not solid_here.any():
            break
        count, labels = cv2.connectedComponents(((plan <= standoff_m) & kept).astype(np.uint8))
        weights = np.bincount(labels[solid_here], weights=heights_m[solid_here] - base_m, minlength=count)
        best = int(np.argmax(weights))
        left_out += [
            _left_out(solid, solid_here & (labels == other), base_m)
            for other in np.flatnonzero(weights > 0.0)
            if other != best
        ]
        kept = labels == best
        anchor = _deepest(solid_here & kept)
        base_m = top_m = float(level_m)
    position = solid.origin_enu_m + np.array([anchor[1], anchor[0]]) * solid.cell_m
    return Part(position, top_m, tuple(left_out))


def _heights(solid: SolidDistance) -> FloatArray:
    """The height of what touches each corner of the grid."""
    heights = np.zeros(solid.plan_m.shape[1:])
    for plan, level_m in zip(solid.plan_m, solid.levels_m, strict=True):
        heights[plan == 0.0] = level_m
    return heights


def _deepest(mask: NDArray[np.bool_]) -> tuple[int, int]:
    """Row and column of the place farthest from the edge of `mask`."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    row, col = np.unravel_index(int(np.argmax(depth)), depth.shape)
    return int(row), int(col)


def _left_out(solid: SolidDistance, mask: NDArray[np.bool_], base_m: float) -> LeftOut:
    rows, cols = np.nonzero(mask)
    west, south = solid.origin_enu_m + np.array([cols.min(), rows.min()]) * solid.cell_m
    east, north = solid.origin_enu_m + np.array([cols.max(), rows.max()]) * solid.cell_m
    reached = (solid.plan_m[:, mask] == 0.0).any(axis=1)
    return LeftOut(
        (float(west), float(south), float(east), float(north)), base_m, float(solid.levels_m[reached].max())
    )
