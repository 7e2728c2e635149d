"""The rings above a roof: its outline moved inward, and around what stands on it.

With f the distance in plan inward of the roof's edge, less the first ring's, and g the distance to what stands on the
roof, less what is kept from it, the ring of inset s is the border of

    { f > s }  ∪  { g < 0 },

around what stands there, at the end all around that alone; where nothing does, the rings shrink to the roof's middle.
A wall beside the roof counts as its edge, with the distance that is kept from walls. f is blurred: an inset corner is
sharp, and so is the ridge of f where two insets meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.contour import Ring, corners_closed, iso_line
from mavspiral.shape.roofs import RoofGrid

__all__ = ["KEYS_PER_TURN", "Insets", "insets_of"]

KEYS_PER_TURN = 8
ROUNDING_SHARE = 0.1
"""Of a picture's height: the blur of f. A rounder ring is flown faster, and shows less of the corners."""
FIRST_SHARE = 0.33
"""Of the way from ring to ring: how far from the edge the first is. At a half the corners are left out."""
STANDING_M = 0.5
"""What rises above a roof's highest cell by more than this stands on it or beside it."""
OUTER_SHARE = 0.9
REACH_SHARE = 0.46
"""Of a picture's height: so far inward a ring shows the roof; and where it looks in from outside, `OUTER_SHARE`."""
THIN_SHARE = 0.12
"""Of a picture's height: the last ring is so far from the roof's middle, where there would be none."""
BULGE_SHARE, BULK = 0.3, 0.85
"""A middle deeper than `BULK` of the roof is by no more than this share of a picture's height is not spiralled into."""
WIDEST_SHARE = 0.67
"""Of a picture's height: on the last turn to the middle, the way from one side's strip to the other's."""


@dataclass(frozen=True, slots=True, eq=False)
class Insets:
    """Rings from the outermost to the innermost, `KEYS_PER_TURN` for each of `turns` and one more.

    `closed` tells whether the last is to be flown all around, as the first is.
    """

    rings: tuple[Ring, ...]
    turns: int
    closed: bool

    def shortened(self) -> Insets:
        """The same without the last turn inward, and the ring there closed."""
        turns = self.turns - 1
        return Insets(self.rings[: turns * KEYS_PER_TURN + 1], turns, True)


def insets_of(
    grid: RoofGrid,
    cells: NDArray[np.bool_],
    high_m: float,
    *,
    picture_m: float,
    spacing_m: float,
    beside_m: float,
    corner_radius_m: float,
    outward_m: float = 0.0,
    encircled: bool = False,
) -> Insets | None:
    """The rings above `cells`, a roof or what is left of one; None where there is no room for any.

    Args:
        grid: everything that stands there.
        cells: the roof's cells.
        high_m: what is higher than this stands on the roof or beside it.
        picture_m: what one ring shows across.
        spacing_m: the most from ring to ring.
        beside_m: kept in plan from what is higher.
        corner_radius_m: no concave corner is sharper.
        outward_m: the first ring is so much farther out, to look square at what slopes up to the middle.
        encircled: a wall beside the roof is gone around, too, as what stands on it is.
    """
    higher = (grid.height_agl_m > high_m + STANDING_M) & ~cells
    holes, courts = _holes(cells, higher, least_cells=(0.5 * picture_m / grid.cell_m) ** 2)
    standing = higher & holes
    if encircled:
        standing |= _touching(higher, cells)
    beside = higher & ~standing
    edge_m = grid.distance_m(~(cells | holes | higher))
    wall_m = grid.distance_m(beside) - beside_m
    width_m = float(edge_m[cells & (wall_m > 0.0)].max(initial=0.0))
    rounding_m = min(ROUNDING_SHARE * picture_m, 0.2 * width_m)
    first_m = min(FIRST_SHARE * spacing_m, width_m - 2.0 * rounding_m) - outward_m
    inward_m = np.clip(np.minimum(edge_m - first_m, wall_m), -50.0, 1e3).astype(np.float32)
    if rounding_m:
        inward_m = cv2.GaussianBlur(inward_m, (0, 0), rounding_m / grid.cell_m)
    around_m = np.minimum(grid.distance_m(standing) - beside_m, grid.distance_m(courts) - first_m)
    around = bool((around_m < 0.0).any())
    if around:
        anchor = np.unravel_index(int(np.argmin(around_m)), around_m.shape)
        last_m = max(0.0, float(inward_m[(around_m > 0.0) & cells].max(initial=0.0)))
        turns = math.ceil(last_m / spacing_m - 0.3)
    else:
        anchor = np.unravel_index(int(np.argmax(inward_m)), inward_m.shape)
        deepest_m = float(inward_m[anchor])
        if deepest_m < 0.5 * grid.cell_m:
            return None
        last_m = _last_inset_m(inward_m, deepest_m, picture_m, grid.cell_m)
        # From farther out a tilted camera sees more of a slope than one that looks straight down.
        shown_share = OUTER_SHARE if outward_m else FIRST_SHARE * spacing_m / picture_m + REACH_SHARE
        to_middle = math.ceil(last_m / min(spacing_m, WIDEST_SHARE * picture_m))
        turns = 0 if width_m < shown_share * picture_m else to_middle
        last_m = last_m if turns else 0.0
    place = grid.origin_enu_m + (np.array(anchor[::-1]) + 0.5) * grid.cell_m
    rings = _rings(grid, inward_m, around_m, last_m, turns, place, corner_radius_m if around else None)
    if not rings:
        return None
    whole = len(rings) == turns * KEYS_PER_TURN + 1
    turns = (len(rings) - 1) // KEYS_PER_TURN
    return Insets(tuple(rings[: turns * KEYS_PER_TURN + 1]), turns, around or not turns or not whole)


def _last_inset_m(inward_m: NDArray[np.float32], deepest_m: float, picture_m: float, cell_m: float) -> float:
    """How far inward the last ring lies where the rings shrink to the roof's middle."""
    last_m = max(0.1, deepest_m - max(THIN_SHARE * picture_m, cell_m))
    # Where wings meet, the middle is deeper than theirs: the last ring is one of theirs, too.
    bulk_m = float(np.quantile(inward_m[inward_m > 0.0], BULK))
    return min(last_m, bulk_m) if deepest_m - bulk_m < BULGE_SHARE * picture_m else last_m


def _rings(
    grid: RoofGrid,
    inward_m: NDArray[np.float32],
    around_m: FloatArray,
    last_m: float,
    turns: int,
    place_enu_m: FloatArray,
    corner_radius_m: float | None,
) -> list[Ring]:
    """The rings about a place, from the first one to that of inset `last_m`, or as far as the outline shrinks smoothly.

    With a radius no concave corner is sharper.
    """
    rings: list[Ring] = []
    for step in range(turns * KEYS_PER_TURN + 1):
        inset_m = last_m * (step / (turns * KEYS_PER_TURN) if turns else 1.0)
        field = np.minimum(inset_m - inward_m, around_m).astype(np.float32)
        ring = iso_line(field, grid.cell_m, grid.origin_enu_m + 0.5 * grid.cell_m, anchor_enu_m=place_enu_m)
        if ring is None:
            break
        rings.append(ring if corner_radius_m is None else corners_closed(ring, corner_radius_m))
        if len(rings) > 1 and _jumps(rings[-2], rings[-1], last_m / (turns * KEYS_PER_TURN)):
            rings.pop()
            break
    return rings


def _holes(
    cells: NDArray[np.bool_], higher: NDArray[np.bool_], *, least_cells: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """What the cells enclose, and those of the holes that nothing stands in, unless they are small."""
    _, labels = cv2.connectedComponents((~np.pad(cells, 1)).astype(np.uint8), connectivity=4)
    labels = labels[1:-1, 1:-1]
    outer = labels[0, 0]
    holes = (labels != outer) & ~cells
    count = np.bincount(labels[holes], minlength=1)
    standing = np.bincount(labels[holes & higher], minlength=len(count)) > 0
    courts = holes & ((count >= least_cells) & ~standing)[np.minimum(labels, len(count) - 1)]
    return holes, courts


def _touching(mask: NDArray[np.bool_], cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The pieces of `mask` that touch the cells."""
    _, labels = cv2.connectedComponents(mask.astype(np.uint8))
    near = cv2.dilate(cells.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    touching: NDArray[np.bool_] = np.isin(labels, np.unique(labels[near & mask])) & mask
    return touching


def _jumps(before: Ring, after: Ring, step_m: float) -> bool:
    """Whether the outline lost much more of its area than its own length times the step."""
    lost_m2 = _area_m2(before) - _area_m2(after)
    return lost_m2 > 2.5 * (step_m + 0.2) * before.length_m + 4.0


def _area_m2(ring: Ring) -> float:
    x, y = ring.points_enu_m.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
