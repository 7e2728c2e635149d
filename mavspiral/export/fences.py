"""Fence and rally point of a flight. A fence has no height: what is flown over cannot be forbidden ground."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.heightmap import Site

__all__ = ["SafeArea", "exclusion_fences_enu_m", "fence_enu_m", "safe_area"]

FENCE_SIDES = 16
FENCE_VERTICES_MAX = 64
"""PX4's store, with the inclusion fence in it."""

CORNERS_MAX = 8
STANDING_M = 1.0
"""Lower things are no obstacles."""


@dataclass(frozen=True, slots=True, eq=False)
class SafeArea:
    """The polygons `(k, 2)` to stay inside and out of, a place `(3,)` to flee to, and what could not be fenced off."""

    inside_enu_m: FloatArray
    outside_enu_m: tuple[FloatArray, ...]
    rally_enu_m: FloatArray
    omitted: str | None


def safe_area(
    position_enu_m: FloatArray,
    site: Site,
    home_enu_m: FloatArray,
    *,
    margin_m: float,
    return_m: float,
) -> SafeArea:
    """The fences round the flown positions `(n, 3)`, and a rally point above home at the height `return_m`.

    Whatever fails on the way, the autopilot's own Return flies straight to home: no exclusion fence comes within
    `margin_m` of a flown segment or of any of these lines. Round the building itself there is none ever: what is flown
    round has a side from which Return leads over it.
    """
    inside = fence_enu_m(np.vstack([position_enu_m, home_enu_m]), margin_m)
    outside, omitted_enu_m = exclusion_fences_enu_m(position_enu_m, site, home_enu_m, inside, margin_m)
    omitted = None
    if len(omitted_enu_m):
        place = site.heights.frame.geo_point(omitted_enu_m[0])
        which = "an obstacle" if len(omitted_enu_m) == 1 else f"{len(omitted_enu_m)} obstacles, the largest"
        omitted = (
            f"no exclusion fence round {which} at lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, {omitted_enu_m[0, 2]:.1f} m "
            f"high: the flight or its Return comes over or near, and a fence has no height. Fix: a Return at {return_m:.0f} m or more"
        )
    return SafeArea(inside, outside, np.array([*home_enu_m[:2], return_m]), omitted)


def fence_enu_m(position_enu_m: FloatArray, margin_m: float) -> FloatArray:
    """A convex polygon `(16, 2)` whose every side keeps at least `margin_m` from all positions."""
    angle = np.arange(FENCE_SIDES) * 2 * np.pi / FENCE_SIDES
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    reach = (position_enu_m[:, :2] @ normal.T).max(axis=0) + margin_m
    following = np.roll(normal, -1, axis=0)
    sides = np.stack([normal, following], axis=1)
    corners: FloatArray = np.linalg.solve(sides, np.column_stack([reach, np.roll(reach, -1)])[:, :, None])[
        :, :, 0
    ]
    return corners


def exclusion_fences_enu_m(
    position_enu_m: FloatArray,
    site: Site,
    home_enu_m: FloatArray,
    inside_enu_m: FloatArray,
    margin_m: float,
) -> tuple[tuple[FloatArray, ...], FloatArray]:
    """Convex polygons `(k, 2)` round obstacles in reach that neither flight nor Return comes near, the largest first.

    Beside them the tops `(n, 3)` of the other obstacles in reach, the building aside and what it is joined to.
    """
    heights = site.heights
    cell_m, origin = heights.cell_m, heights.origin_enu_m

    def pixels(place_enu_m: FloatArray) -> NDArray[np.int32]:
        return np.asarray(np.floor((place_enu_m[:, :2] - origin) / cell_m), dtype=np.int32)

    shape = heights.height_agl_m.shape
    reach = np.zeros(shape, dtype=np.uint8)
    cv2.fillConvexPoly(reach, pixels(inside_enu_m), 1)
    swept = np.zeros(shape, dtype=np.uint8)
    width = max(1, 2 * int(np.ceil(margin_m / cell_m)) + 2)
    flown, home = pixels(position_enu_m), pixels(home_enu_m[None, :])[0]
    cv2.polylines(swept, [flown.reshape(-1, 1, 2)], isClosed=False, color=1, thickness=width)
    for x, y in np.unique(flown, axis=0):
        cv2.line(swept, (int(x), int(y)), (int(home[0]), int(home[1])), 1, width)
    solid = (heights.height_agl_m > STANDING_M).astype(np.uint8)
    _, labels, figures, _ = cv2.connectedComponentsWithStats(solid, connectivity=8)
    near = [label for label in np.unique(labels[reach.astype(bool)]) if label]
    polygons, left_out = list[FloatArray](), list[FloatArray]()
    spare = FENCE_VERTICES_MAX - len(inside_enu_m)
    for label in sorted(near, key=lambda label: -int(figures[label, cv2.CC_STAT_AREA])):
        cells = labels == label
        corners = _hull(cells)
        area = np.zeros(shape, dtype=np.uint8)
        cv2.fillConvexPoly(area, corners, 1)
        if len(corners) > spare or np.any(area & swept):
            if not site.building[cells].any():
                row, col = np.divmod(int(np.argmax(np.where(cells, heights.height_agl_m, -1.0))), shape[1])
                middle = origin + (np.array([col, row]) + 0.5) * cell_m
                left_out.append(np.append(middle, heights.height_agl_m[row, col]))
            continue
        spare -= len(corners)
        polygons.append(origin + (corners + 0.5) * cell_m)
    return tuple(polygons), np.array(left_out).reshape(-1, 3)


def _hull(cells: NDArray[np.bool_]) -> NDArray[np.int32]:
    """The convex hull of the cells in pixels; where that has more than `CORNERS_MAX` corners, the box around it."""
    rows, cols = np.nonzero(cells)
    hull = cv2.convexHull(np.column_stack([cols, rows]).astype(np.int32)).reshape(-1, 2)
    if len(hull) > CORNERS_MAX:
        left, low, wide, high = cv2.boundingRect(hull.reshape(-1, 1, 2))
        hull = np.array(
            [[left, low], [left + wide, low], [left + wide, low + high], [left, low + high]], dtype=np.int32
        )
    return np.asarray(hull, dtype=np.int32)
