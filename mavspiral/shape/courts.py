"""Courtyards: what the building encloses, how wide it is, and between which heights it is enclosed."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.contour import Ring, corners_closed, iso_line
from mavspiral.shape.distance import cells_away, with_neighbours
from mavspiral.shape.slicing import SolidDistance

__all__ = ["Court", "court_ring", "courts_of", "enclosed_ground"]

LEAST_WIDTH_M = 2.0
"""What is narrower is a shaft and not told of."""


@dataclass(frozen=True, slots=True, eq=False)
class Court:
    """Enclosed ground or roof: its middle `place_enu_m` (2,) is `half_width_m` from the nearest wall.

    Its floor lies at `floor_m`, up to `rim_m` there are walls on all sides, and the highest wall ends at `wall_m`.
    """

    place_enu_m: FloatArray
    half_width_m: float
    floor_m: float
    rim_m: float
    wall_m: float


def courts_of(
    solid: SolidDistance, *, shut_m: tuple[float, ...] = (), room_m: float = 0.0
) -> tuple[Court, ...]:
    """The courts, widest first. A roof in a court is a floor of its own only where the court below is none.

    A gate counts as shut where its walls leave no more than one of `shut_m` on either side, and behind it is a court
    if that leaves `room_m` more.
    """
    found: list[Court] = []
    taken = np.zeros(solid.plan_m.shape[1:], dtype=np.bool_)
    floors_m = [0.0, *(float(level) for level in solid.levels_m[:-1])]
    for level, floor_m in enumerate(floors_m):
        for gate_m in (0.0, *shut_m):
            for hole in _holes(solid.plan_m[level], gate_m):
                place = _middle(solid.plan_m[level], hole)
                half_width_m = float(solid.plan_m[level][place])
                least_m = gate_m + room_m if gate_m else 0.5 * LEAST_WIDTH_M
                if half_width_m < least_m or (taken & hole).any():
                    continue
                whole = _grown(hole, gate_m / solid.cell_m)
                taken |= whole
                position = solid.origin_enu_m + np.array([place[1], place[0]]) * solid.cell_m
                rim_m, wall_m = _rim_m(solid, level, place, gate_m), _wall_m(solid, level, whole)
                found.append(Court(position, half_width_m, floor_m, rim_m, wall_m))
    return tuple(sorted(found, key=lambda court: -court.half_width_m))


def enclosed_ground(building: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The cells `(rows, cols)` that are not the building's but enclosed by it."""
    holes = _holes(np.pad(~building, 1, constant_values=True).astype(np.float32), 0.0)
    enclosed = np.zeros(np.add(building.shape, 2), dtype=np.bool_)
    for hole in holes:
        enclosed |= hole
    return enclosed[1:-1, 1:-1]


def court_ring(
    solid: SolidDistance, court: Court, *, height_m: float, standoff_m: float, corner_radius_m: float
) -> Ring | None:
    """The line within a court at `standoff_m` from its walls, clockwise, so that they lie to its left.

    None where the middle of the court is nearer than that. It has no corner sharper than `corner_radius_m`,
    where there is room.
    """
    excess_m = solid.excess_m(solid.slice(height_m, standoff_m))
    _, labels = cv2.connectedComponents((excess_m > 0.0).astype(np.uint8), connectivity=4)
    col, row = np.rint((court.place_enu_m - solid.origin_enu_m) / solid.cell_m).astype(int)
    inside = (labels == labels[row, col]) & (excess_m > 0.0)
    field = np.where(inside, -excess_m, np.abs(excess_m))
    border = iso_line(field, solid.cell_m, solid.origin_enu_m, anchor_enu_m=court.place_enu_m)
    if border is None:
        return None
    return corners_closed(Ring(border.points_enu_m[::-1]), corner_radius_m)


def _grown(hole: NDArray[np.bool_], cells: float) -> NDArray[np.bool_]:
    """The hole and what is no farther from it than so many cells."""
    if not cells:
        return hole
    return np.asarray(cells_away(hole) <= cells)


def _holes(plan_m: NDArray[np.float32], gate_m: float) -> list[NDArray[np.bool_]]:
    """What lies farther than `gate_m` outside of the solid but does not reach the edge of the map."""
    _, labels = cv2.connectedComponents((plan_m > gate_m).astype(np.uint8), connectivity=4)
    outside = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    inside = np.setdiff1d(np.unique(labels), [0, *outside])
    return [labels == label for label in inside]


def _middle(plan_m: NDArray[np.float32], hole: NDArray[np.bool_]) -> tuple[int, int]:
    row, col = np.unravel_index(int(np.argmax(np.where(hole, plan_m, -1.0))), hole.shape)
    return int(row), int(col)


def _wall_m(solid: SolidDistance, level: int, hole: NDArray[np.bool_]) -> float:
    """The highest level of what stands round the hole."""
    rim = with_neighbours(hole, 2) & ~hole
    reached = [bool((plan[rim] == 0.0).any()) for plan in solid.plan_m[level:]]
    return float(solid.levels_m[level:][np.flatnonzero(reached)[-1]])


def _rim_m(solid: SolidDistance, level: int, place: tuple[int, int], gate_m: float) -> float:
    """The highest level, from `level` on, that still encloses the place."""
    rim_m = float(solid.levels_m[level])
    for plan, level_m in zip(solid.plan_m[level + 1 :], solid.levels_m[level + 1 :], strict=True):
        if not any(hole[place] for hole in _holes(plan, gate_m)):
            break
        rim_m = float(level_m)
    return rim_m
