"""Holes in a survey: what stands between what was measured?

Seen from above a roof hides nothing of itself: a long strip without heights beside it is ground in its shadow, and stays
empty. A hole that a wall or a roof goes on behind, or one so small that it may hide a corner, is as high as what is beside
it, so that nothing which stands there is nearer than told.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.frames import LocalFrame
from mavspiral.shape.distance import cells_away, with_neighbours

__all__ = ["fill_holes", "gaps_told"]

SMALL_M = 3.0
"""Holes that are no larger either way are filled whole."""
SPAN_M = 6.0
"""Across so much, what stands on both sides of a hole goes on in it."""
DIRECTIONS = 48


def fill_holes(
    surface_m: FloatArray, standing: NDArray[np.bool_], cell_m: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The surface `(rows, cols)` with its holes in what is `standing` filled, and which cells those are.

    Cells without a height are NaN. A small hole takes the highest cell at its edge, if that stands. In any other, a cell
    between two that stand takes the higher; the highest, where there are several such pairs; and the cells beside it as well.
    """
    unknown = np.isnan(surface_m)
    filled_m = surface_m.copy()
    beside = with_neighbours(standing)
    if not (unknown & beside).any():
        return filled_m, np.zeros_like(unknown)
    small = math.floor(SMALL_M / cell_m + 1e-9)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(unknown.astype(np.uint8), connectivity=8)
    at_rim = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    whole = np.maximum(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) <= small
    whole[0] = False
    whole[at_rim] = False
    for label in np.unique(labels[unknown & beside]):
        if not whole[label]:
            continue
        left, top, wide, high = (int(v) for v in stats[label, :4])
        box = slice(max(0, top - 1), top + high + 1), slice(max(0, left - 1), left + wide + 1)
        hole = labels[box] == label
        edge = with_neighbours(hole) & standing[box]
        filled_m[box][hole] = surface_m[box][edge].max()
    reach = SPAN_M / cell_m
    asked = np.argwhere(unknown & ~whole[labels] & (cells_away(standing) < reach))
    stands_m = np.where(unknown, np.nan, np.where(standing, surface_m, -np.inf))
    between_m = _between(stands_m, asked, reach)
    filling_m = np.full(surface_m.shape, -np.inf)
    filling_m[asked[:, 0], asked[:, 1]] = between_m
    # And one cell farther: a slanting wall's line of cells has steps, whose corners lie between no two.
    filling_m = cv2.dilate(filling_m, np.ones((3, 3), dtype=np.uint8))
    between = unknown & ~whole[labels] & (filling_m > -np.inf)
    filled_m[between] = filling_m[between]
    return filled_m, unknown & np.isfinite(filled_m)


def gaps_told(
    building: NDArray[np.bool_],
    measured: NDArray[np.bool_],
    known: NDArray[np.bool_],
    cell_m: float,
    frame: LocalFrame,
    south_west_m: FloatArray,
) -> tuple[str, ...]:
    """In words what was not measured around the building, and where that may hide a piece of it."""
    share = 1.0 - np.count_nonzero(measured) / measured.size
    holes = np.argwhere(known & ~measured & building)
    beside = np.argwhere(~known & with_neighbours(building))

    def example(cells: NDArray[np.int64]) -> str:
        x, y = south_west_m + (cells[0, ::-1] + 0.5) * cell_m
        lat, lon, _ = frame.to_geodetic([x, y, 0.0])
        return f"e.g. at lat {float(lat):.6f}, lon {float(lon):.6f}"

    told = []
    if len(holes):
        told.append(
            f"{len(holes) * cell_m**2:.1f} m² of the building was not measured, {example(holes)}, and is taken to be as high "
            "as what is beside it"
        )
    if share <= 0.005 and not len(beside):
        return tuple(told)
    line = f"{share:.1%} of the map around the building was not measured and is, but for such holes, taken to be empty"
    line = line if told else line.replace(", but for such holes,", "")
    if len(beside):
        line += (
            f"; {len(beside) * cell_m:.1f} m of it lie at the building's wall, {example(beside)}: "
            "no clearance is known from what may stand there"
        )
    return (*told, line)


@njit(cache=True)
def _between(stands_m: FloatArray, asked: NDArray[np.int64], reach: float) -> FloatArray:
    """For each cell the highest of two that stand no farther apart than `reach` cells and see each other past it, else -∞.

    `stands_m` is NaN where nothing was measured, and -∞ where nothing stands.
    """
    rows, cols = stands_m.shape
    found = np.full(len(asked), -math.inf)
    for n in range(len(asked)):
        row, col = asked[n]
        for d in range(DIRECTIONS):
            down, right = math.sin(math.pi * d / DIRECTIONS), math.cos(math.pi * d / DIRECTIONS)
            span, both = 0.0, -math.inf
            for side in (-0.5, 0.5):
                here, k = math.nan, 0
                while math.isnan(here) and span + 0.5 * k <= reach:
                    k += 1
                    r, c = round(row + side * k * down), round(col + side * k * right)
                    if r < 0 or r >= rows or c < 0 or c >= cols:
                        break
                    here = stands_m[r, c]
                span += 0.5 * k
                if math.isnan(here) or here == -math.inf or span > reach:
                    both = -math.inf
                    break
                both = max(both, here)
            found[n] = max(found[n], both)
    return found
