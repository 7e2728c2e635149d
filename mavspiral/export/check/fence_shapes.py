"""Fence and rally points, as QGroundControl's GeoFenceController and RallyPointController load them."""

from __future__ import annotations

from typing import Any

from mavspiral.export.check.findings import Findings
from mavspiral.export.check.shape import (
    ARRAY,
    FLAG,
    FLOAT_MAX,
    NUMBER,
    OBJECT,
    demand,
    is_kind,
    place_of,
    short,
)

__all__ = ["FenceCircle", "FencePolygon", "fence_shapes", "rally_points"]

Place = tuple[float, float]
FencePolygon = tuple[bool, tuple[Place, ...]]
"""Whether one must stay inside, and its corners as latitude and longitude."""

FenceCircle = tuple[bool, Place, float]
"""Whether one must stay inside, its centre, and its radius in metres."""


def fence_shapes(
    fence: dict[str, Any], findings: Findings
) -> tuple[tuple[FencePolygon, ...], tuple[FenceCircle, ...]]:
    """The polygons and circles that can be loaded."""
    if not fence:
        findings.warning("geoFence", "is empty: MAVSDK wants version, polygons and circles")
        return (), ()
    if fence.get("version") != 2:
        findings.warning("geoFence", f"version is {short(fence.get('version'))}, not 2: the fence is ignored")
        return (), ()
    if not demand(fence, {"polygons": ARRAY, "circles": ARRAY}, "geoFence", findings):
        return (), ()
    polygons, circles = [], []
    for number, shape in enumerate(fence["polygons"], start=1):
        place = f"fence polygon {number}"
        if _shape(shape, {"polygon": ARRAY}, place, findings):
            corners = [place_of(corner, 2) for corner in shape["polygon"]]
            if len(corners) < 3 or None in corners:
                findings.error(place, "is not three or more of [latitude, longitude]")
            else:
                polygons.append((shape["inclusion"], tuple((c[0], c[1]) for c in corners if c)))
    for number, shape in enumerate(fence["circles"], start=1):
        place = f"fence circle {number}"
        if _shape(shape, {"circle": OBJECT}, place, findings):
            center, radius = place_of(shape["circle"].get("center"), 2), shape["circle"].get("radius")
            if center is None or not is_kind(radius, NUMBER) or not 0 < radius < FLOAT_MAX:
                findings.error(place, "wants center [latitude, longitude] and a radius in metres")
            else:
                circles.append((shape["inclusion"], (center[0], center[1]), float(radius)))
    return tuple(polygons), tuple(circles)


def rally_points(rally: dict[str, Any], findings: Findings) -> tuple[tuple[float, float, float], ...]:
    """Latitude, longitude and height of the points that can be loaded."""
    if not demand(rally, {"version": NUMBER, "points": ARRAY}, "rallyPoints", findings):
        return ()
    if rally["version"] != 2:
        findings.error("rallyPoints", f"version is {short(rally['version'])}, wanted 2")
        return ()
    points = []
    for number, entry in enumerate(rally["points"], start=1):
        point = place_of(entry, 3)
        if point is None:
            findings.error(f"rally point {number}", "is not [latitude, longitude, height]")
        else:
            points.append((point[0], point[1], point[2]))
    return tuple(points)


def _shape(shape: Any, keys: dict[str, str], place: str, findings: Findings) -> bool:
    if not isinstance(shape, dict):
        findings.error(place, f"is {short(shape)}, wanted an object")
        return False
    if not demand(shape, {"version": NUMBER, "inclusion": FLAG} | keys, place, findings):
        return False
    if shape["version"] != 1:
        findings.error(place, f"version is {short(shape['version'])}, wanted 1")
        return False
    return True
