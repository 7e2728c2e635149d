"""The roofs of a building as pieces of an inspection: above each an inward spiral with the camera tilted down.

What one spiral leaves of a roof, because the roof falls apart as it shrinks, is a roof of its own, until little is left.
What is smaller than a picture is crossed on a straight line.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve.insets import STANDING_M
from mavspiral.motion.limits import Limits
from mavspiral.pieces.roof_ways import RoofLook, best_way
from mavspiral.shape.heightmap import Site
from mavspiral.shape.roofs import Roof, RoofGrid, roof_grid, roofs_of
from mavspiral.tour.passes import Piece

__all__ = ["roof_pieces"]

STEP_SHARE = 0.25
"""Of the stand-off: a lower step does not part two roofs."""
SMALL_SHARE = 0.015
"""Of all roofs: what is smaller than this, and than `SMALL_M2`, is not flown to."""
SMALL_M2 = 12.0
SPIRALS_MAX = 6
"""Above one roof."""


def roof_pieces(site: Site, look: RoofLook, pace: Limits, *, start_enu_m: FloatArray) -> tuple[Piece, ...]:
    """A piece for each spiral or line above the roofs of the building, the highest roofs first.

    The look's stand-off is kept from the roof itself. From what is higher beside it the path keeps that or what a look at
    the wall's foot in fine enough pixels takes, but never less than the required clearance. Each piece begins near
    `start_enu_m`, `(2,)` or `(3,)`, as far as it can choose.
    """
    grid = roof_grid(site, reach_m=look.standoff_m + 4.0)
    total_m2 = float(grid.building.sum()) * grid.cell_m**2
    least_m2 = max(min(SMALL_M2, 0.5 * total_m2), SMALL_SHARE * total_m2)
    step_m = max(STEP_SHARE * look.standoff_m, 2.5 * grid.cell_m)
    pieces: list[Piece] = []
    roofs = roofs_of(grid, step_m=step_m, least_m2=least_m2)
    for number, roof in enumerate(roofs, start=1):
        pieces += _above(grid, roof, look, pace, f"roof {number}", least_m2, np.asarray(start_enu_m)[:2])
    return tuple(pieces)


def _above(
    grid: RoofGrid,
    roof: Roof,
    look: RoofLook,
    pace: Limits,
    name: str,
    least_m2: float,
    start_enu_m: FloatArray,
) -> list[Piece]:
    """The pieces above one roof."""
    wall_m = grid.distance_m((grid.height_agl_m > roof.high_m + STANDING_M) & ~roof.cells)
    left, pieces = roof.cells, list[Piece]()
    for _ in range(SPIRALS_MAX):
        part = _largest(left)
        if part.sum() * grid.cell_m**2 < least_m2:
            break
        left = left & ~part
        way = best_way(grid, roof, part, look, pace, wall_m, start_enu_m)
        if way is None or not (way.belonging.cells & part).any():
            continue
        left = (left | part) & ~way.belonging.cells
        # "roof 2", "roof 2b": a leg "…-2-2" would belong to the leg "…-2".
        pieces.append(way.piece(name + "abcdefgh"[len(pieces)] * bool(pieces), look.standoff_m, pace))
    return pieces


def _largest(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The largest piece of a mask."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    if len(stats) == 1:
        return mask
    return np.asarray(labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))
