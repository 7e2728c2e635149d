"""Whether a plan's places keep to its own fence: PX4 refuses a mission that leaves it."""

from __future__ import annotations

import math

from mavspiral.export.check.autopilot_rules import DEGREE_M, MISSION_FRAME, PLACES
from mavspiral.export.check.fence_shapes import FenceCircle, FencePolygon, Place
from mavspiral.export.check.findings import Findings
from mavspiral.export.check.loading import PlanParts

__all__ = ["judge_fence"]


def judge_fence(parts: PlanParts, autopilot: str, findings: Findings) -> None:
    """Notes every place outside the fence, home's too.

    PX4 is content with one of several inclusion areas; ArduPilot wants all of them.
    """
    shapes: list[FencePolygon | FenceCircle] = [*parts.polygons, *parts.circles]
    inside = [shape for shape in shapes if shape[0]]
    outside = [shape for shape in shapes if not shape[0]]
    enough = any if autopilot == "px4" else all
    for item in parts.items:
        place = (item.params[4], item.params[5])
        if item.command not in PLACES or item.frame == MISSION_FRAME or not all(map(math.isfinite, place)):
            continue
        if place == (0.0, 0.0):
            continue  # here, wherever that is
        if inside and not enough(_within(place, shape) for shape in inside):
            findings.error(item.place, "lies outside the plan's own inclusion fence")
        if any(_within(place, shape) for shape in outside):
            findings.error(item.place, "lies inside the plan's own exclusion fence")
    if parts.home is not None and inside:
        home = parts.home[0], parts.home[1]
        if not enough(_within(home, shape) for shape in inside):
            findings.warning("mission.plannedHomePosition", "lies outside the plan's own inclusion fence")


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
