"""How far a place lies beyond a fence: beyond its uploaded areas, and beyond each part of ArduCopter's.

Source: ArduPilot 4.6, AC_Fence.cpp. Parts are bits of FENCE_TYPE: greatest height, circle round home, uploaded polygons and circles,
least height.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from sitl.autopilot.copter_memory import CopterState
from sitl.condition import Condition
from sitl.geo import ned_of_geodetic
from sitl.plans import PlanItem

__all__ = ["CIRCLE", "HIGH", "LOW", "POLYGON", "areas_beyond_m", "areas_of", "beyond", "fence_parts"]

HIGH, CIRCLE, POLYGON, LOW = 1, 2, 4, 8
_INSIDE_POLYGON, _OUTSIDE_POLYGON, _INSIDE_CIRCLE, _OUTSIDE_CIRCLE = 5001, 5002, 5003, 5004


def fence_parts(state: CopterState, parameters: Mapping[str, float]) -> int:
    """The parts that are watched, as bits."""
    if not parameters["FENCE_ENABLE"]:
        return 0
    parts = int(parameters["FENCE_TYPE"]) & (HIGH | CIRCLE | POLYGON | LOW)
    if not state.low_fence:
        parts &= ~LOW
    return parts if state.plans.fence else parts & ~POLYGON


def beyond(
    state: CopterState,
    condition: Condition,
    parameters: Mapping[str, float],
    place_m: complex,
    down_m: float,
) -> dict[int, float]:
    """How many metres that place (north + i·east) lies beyond each part that is watched; negative inside."""
    parts, home, origin = fence_parts(state, parameters), state.home, condition.origin
    if home is None or origin is None:
        return {}
    north_m, east_m, home_down_m = home.position_ned_m.tolist()
    height_m = home_down_m - down_m
    found = {
        HIGH: height_m - parameters["FENCE_ALT_MAX"],
        CIRCLE: abs(place_m - complex(north_m, east_m)) - parameters["FENCE_RADIUS"],
        LOW: parameters["FENCE_ALT_MIN"] - height_m,
    }
    if parts & POLYGON:
        anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
        areas = areas_beyond_m(state.plans.fence, anchor, place_m)
        found[POLYGON] = max((metres for _, metres in areas), default=-math.inf)
    return {part: metres for part, metres in found.items() if parts & part}


def areas_of(items: tuple[PlanItem, ...]) -> Iterator[tuple[PlanItem, ...]]:
    """The items of each uploaded area: one for a circle, its corners for a polygon."""
    seq = 0
    while seq < len(items):
        command = items[seq].command
        is_polygon = command in (_INSIDE_POLYGON, _OUTSIDE_POLYGON)
        count = max(1, int(items[seq].params[0])) if is_polygon else 1
        if is_polygon or command in (_INSIDE_CIRCLE, _OUTSIDE_CIRCLE):
            yield items[seq : seq + count]
        seq += count


def areas_beyond_m(
    items: tuple[PlanItem, ...], anchor: tuple[float, float, float], place_m: complex
) -> Iterator[tuple[bool, float]]:
    """Of each uploaded area, whether it is one to stay in, and how far the place lies on its wrong side."""
    for area in areas_of(items):
        command = area[0].command
        if command in (_INSIDE_CIRCLE, _OUTSIDE_CIRCLE):
            off_m = abs(place_m - _place_m(area[0], anchor)) - area[0].params[0]
        else:
            off_m = -_inside_m([_place_m(corner, anchor) for corner in area], place_m)
        stays_in = command in (_INSIDE_POLYGON, _INSIDE_CIRCLE)
        yield stays_in, off_m if stays_in else -off_m


def _place_m(item: PlanItem, anchor: tuple[float, float, float]) -> complex:
    north_m, east_m, _ = ned_of_geodetic(anchor, (item.params[4], item.params[5], anchor[2]))
    return complex(north_m, east_m)


def _inside_m(corners: list[complex], place_m: complex) -> float:
    """How far the place is from the polygon's edge: positive inside, negative outside (even-odd rule)."""
    inside, nearest_m = False, math.inf
    for begin, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        edge, to = end - begin, place_m - begin
        share = 0.0 if not edge else min(1.0, max(0.0, (to * edge.conjugate()).real / abs(edge) ** 2))
        nearest_m = min(nearest_m, abs(to - share * edge))
        if (begin.imag > place_m.imag) is not (end.imag > place_m.imag):
            crossing = begin.real + edge.real * (place_m.imag - begin.imag) / edge.imag
            inside = inside is not (place_m.real < crossing)
    return nearest_m if inside else -nearest_m
