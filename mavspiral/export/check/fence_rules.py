"""Whether a plan's places keep to its own fence: PX4 refuses a mission that leaves it.

Source: PX4 v1.17, geofence.cpp (of several inclusions it wants all: its issue 27099); ArduPilot, AC_PolyFence_loader.cpp.
"""

from __future__ import annotations

import math

from mavspiral.export.check.autopilot_rules import DEGREE_M, MISSION_FRAME, PLACES
from mavspiral.export.check.dialects import DIALECTS
from mavspiral.export.check.fence_shapes import FenceCircle, FencePolygon, Place
from mavspiral.export.check.findings import Findings
from mavspiral.export.check.loading import PlanParts

__all__ = ["judge_fence"]


def judge_fence(parts: PlanParts, autopilot: str, findings: Findings) -> None:
    """Notes every place outside the fence, home's too. Of several areas to stay in, both autopilots want all at once.

    PX4 drops an area that home breaks, and says so when it is uploaded: that area keeps nobody in or out.
    """
    name, home = DIALECTS[autopilot].name, None if parts.home is None else (parts.home[0], parts.home[1])
    shapes: list[FencePolygon | FenceCircle] = [*parts.polygons, *parts.circles]
    inside_n = sum(shape[0] for shape in shapes)
    if inside_n > 1:
        findings.warning(
            "geoFence", f"{inside_n} areas to stay in: {name} wants to be in all of them at once"
        )
    held = shapes
    if autopilot == "px4" and home is not None:
        named = [f"fence polygon {number + 1}" for number in range(len(parts.polygons))]
        named += [f"fence circle {number + 1}" for number in range(len(parts.circles))]
        held = [shape for shape in shapes if _allows(home, shape)]
        for area, shape in zip(named, shapes, strict=True):
            if not _allows(home, shape):
                side = "outside" if shape[0] else "inside"
                findings.warning(area, f"PX4 does not hold this area: the planned home lies {side} it")
    elif home is not None and not all(_allows(home, shape) for shape in shapes if shape[0]):
        findings.warning("mission.plannedHomePosition", "lies outside the plan's own inclusion fence")
    for item in parts.items:
        place = (item.params[4], item.params[5])
        if item.command not in PLACES or item.frame == MISSION_FRAME or not all(map(math.isfinite, place)):
            continue
        if place == (0.0, 0.0):
            continue  # here, wherever that is
        broken = {shape[0] for shape in held if not _allows(place, shape)}
        if True in broken:
            findings.error(item.place, "lies outside the plan's own inclusion fence")
        if False in broken:
            findings.error(item.place, "lies inside the plan's own exclusion fence")


def _allows(place: Place, shape: FencePolygon | FenceCircle) -> bool:
    return _within(place, shape) is shape[0]


def _within(place: Place, shape: FencePolygon | FenceCircle) -> bool:
    if len(shape) == 3:
        _, (lat, lon), radius_m = shape
        north_m = (place[0] - lat) * DEGREE_M
        east_m = (place[1] - lon) * DEGREE_M * math.cos(math.radians(lat))
        return math.hypot(north_m, east_m) <= radius_m
    corners = shape[1]
    odd = False
    for (a_lat, a_lon), (b_lat, b_lon) in zip(corners, (*corners[1:], corners[0]), strict=True):
        if (a_lat > place[0]) != (b_lat > place[0]):
            crossing = a_lon + (place[0] - a_lat) / (b_lat - a_lat) * (b_lon - a_lon)
            odd ^= place[1] < crossing
    return odd
