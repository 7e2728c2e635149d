"""How far round a building a drone can go where neighbours stand close.

The line to fly at a height is the border of what lies within the stand-off of the building and not within the
clearance `q` of anything else, or else within `q` of the building:

    min( max(D_building − d, q − D_other), D_building − q ) = 0

Where there is room it is the stand-off; before a neighbour it draws in, as far as `q`; and where not even that
leaves `q` on both sides, it runs where nobody may fly. What remains without that are the accessible arcs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.contour import Ring, corners_closed, iso_line
from mavspiral.shape.slicing import SolidDistance

__all__ = ["Reach", "arcs_of", "reach_at"]

ROUNDING_M = 1.0
FACING = 0.35
"""Cosine between the way in and the way to the nearest wall: where it is less, a camera looks past the building."""
SHORTEST_M = 2.0
"""Arcs shorter than this are not worth a row."""
PROBE_M = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """The line at a height: points `(n, 3)` counter-clockwise, the way in, which can be flown, and wall distances.

    `free` tells whether the whole line is at the stand-off, as if nothing else stood there.
    """

    points_enu_m: FloatArray
    yaw_enu_rad: FloatArray
    accessible: NDArray[np.bool_]
    wall_m: FloatArray
    free: bool


def reach_at(
    solid: SolidDistance,
    others: SolidDistance,
    *,
    height_m: float,
    standoff_m: float,
    clearance_m: float,
    required_m: float,
    anchor_enu_m: FloatArray,
) -> Reach | None:
    """The line round what stands at the anchor; None where nothing does at that height.

    Args:
        solid: the building.
        others: all else, on the same grid.
        height_m: of the line.
        standoff_m: d.
        clearance_m: q, somewhat more than `required_m`, for what rounding takes.
        required_m: where the line keeps less than this from anything, it is not accessible.
        anchor_enu_m: `(2,)`.
    """
    at_standoff = solid.excess_m(solid.slice(height_m, standoff_m))
    at_clearance = solid.excess_m(solid.slice(height_m, clearance_m))
    near_others = -others.excess_m(others.slice(height_m, clearance_m))
    bounded = np.maximum(at_standoff, near_others)
    field = np.minimum(bounded, at_clearance)
    line = iso_line(field, solid.cell_m, solid.origin_enu_m, anchor_enu_m=anchor_enu_m)
    if line is None:
        return None
    plan = _opened(corners_closed(line, ROUNDING_M)).points_enu_m
    points = np.column_stack([plan, np.full(len(plan), height_m)])
    along = np.roll(plan, -1, axis=0) - np.roll(plan, 1, axis=0)
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    inward /= np.maximum(np.hypot(*inward.T), 1e-9)[:, None]
    wall_m = solid(points)
    room_m = np.minimum(wall_m, others(points))
    nearer_m = wall_m - solid(points + PROBE_M * np.column_stack([inward, np.zeros(len(plan))]))
    accessible = (room_m >= required_m) & (nearer_m >= FACING * PROBE_M)
    free = bool((others(points) >= clearance_m).all() and (np.abs(wall_m - standoff_m) < standoff_m).all())
    free = free and bool((wall_m >= standoff_m - 0.1).all())
    return Reach(points, np.unwrap(np.arctan2(inward[:, 1], inward[:, 0])), accessible, wall_m, free)


def arcs_of(reach: Reach) -> list[NDArray[np.int64]]:
    """The points of each accessible arc, in order; all of them, from the first on, where the whole line is."""
    count = len(reach.accessible)
    if reach.accessible.all():
        return [np.arange(count)]
    if not reach.accessible.any():
        return []
    start = int(np.argmin(reach.accessible))
    order = np.roll(np.arange(count), -start)
    edges = np.flatnonzero(np.diff(reach.accessible[order].astype(np.int8), append=np.int8(0)))
    arcs = [order[begin + 1 : end + 1] for begin, end in zip(edges[::2], edges[1::2], strict=True)]
    return [arc for arc in arcs if _length_m(reach.points_enu_m[arc]) >= SHORTEST_M]


def _opened(line: Ring) -> Ring:
    """The line with its outward corners rounded: the ball rolls inside."""
    inner = corners_closed(Ring(line.points_enu_m[::-1]), ROUNDING_M)
    return Ring(inner.points_enu_m[::-1])


def _length_m(points: FloatArray) -> float:
    return float(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1)).sum()) if len(points) > 1 else 0.0
