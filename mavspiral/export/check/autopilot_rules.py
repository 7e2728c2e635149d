"""Whether the autopilot takes a plan that a ground station has loaded, and flies it as it reads."""

from __future__ import annotations

import math

from mavspiral.export.check.dialects import Dialect, command_name
from mavspiral.export.check.findings import Findings
from mavspiral.export.check.loading import PlanParts
from mavspiral.export.check.simple_item import PlanItem

__all__ = ["judge_items"]

WAYPOINT, TAKEOFF, VTOL_TAKEOFF, RETURN, JUMP, SPEED = 16, 22, 84, 20, 177, 178
PLACES = frozenset((16, 17, 18, 19, 21, 22, 31, 36, 82, 84, 85))
MISSION_FRAME = 2
RELATIVE_FRAMES = (3, 6)
FIRST_WAYPOINT_M = 900.0
FAR_M = 100_000.0
"""No multicopter flies so far: latitude and longitude may have changed places."""
DEGREE_M = 111_195.0


def judge_items(parts: PlanParts, dialect: Dialect, findings: Findings) -> None:
    """Notes what the autopilot refuses, drops or warns of, item by item and in all."""
    for item in parts.items:
        _judge_item(item, dialect, findings)
    _judge_yaw(parts.items, dialect, findings)
    _judge_jumps(parts.items, findings)
    _judge_start(parts, dialect, findings)
    _judge_counts(parts, dialect, findings)


def _judge_item(item: PlanItem, dialect: Dialect, findings: Findings) -> None:
    name, place = command_name(item.command), item.place
    has_place = item.frame != MISSION_FRAME
    if has_place and item.frame not in dialect.frames:
        findings.error(place, f"{dialect.name} does not know frame {item.frame}")
        return
    if item.command not in dialect.placed | dialect.placeless:
        findings.error(place, f"{dialect.name} does not take {name} in a mission")
        return
    if has_place and item.command not in dialect.placed and not dialect.any_frame:
        findings.error(place, f"{dialect.name} takes {name} in frame 2 (MISSION) only, not in {item.frame}")
        return
    if not has_place and item.command not in dialect.placeless:
        findings.error(place, f"{dialect.name} takes {name} in a global frame only, not in frame 2 (MISSION)")
        return
    if has_place and item.command in PLACES:
        lat, lon, alt = item.params[4:]
        if abs(lat) > 90 or abs(lon) > 180:
            findings.error(place, f"latitude {lat:g}, longitude {lon:g} is no place on the earth")
        if not math.isfinite(alt):
            findings.error(place, f"{name} without a height")
    if dialect.nan_in_yaw is not None:
        allowed = (3,) if item.command in dialect.nan_in_yaw else ()
        if any(math.isnan(p) for i, p in enumerate(item.params[:4]) if i not in allowed):
            findings.error(place, f"{dialect.name} refuses null among the first four parameters of {name}")
    if item.command == SPEED and not item.params[1] > 0:
        findings.warning(place, "DO_CHANGE_SPEED without a speed goes back to the usual one, or does nothing")


def _judge_yaw(items: tuple[PlanItem, ...], dialect: Dialect, findings: Findings) -> None:
    if dialect.nan_in_yaw is None:
        return
    for item in items:
        if item.command == WAYPOINT and math.isfinite(item.params[3]) and item.params[3] != 0.0:
            findings.warning(item.place, f"{dialect.name} drops the heading of a waypoint; use CONDITION_YAW")
        if item.command == WAYPOINT and math.isfinite(item.params[0]) and item.params[0] % 1.0:
            findings.warning(item.place, f"{dialect.name} waits whole seconds only")


def _judge_jumps(items: tuple[PlanItem, ...], findings: Findings) -> None:
    ids = {item.jump_id for item in items}
    for item in items:
        if item.command == JUMP and item.params[0] not in ids:
            findings.error(item.place, f"DO_JUMP to {item.params[0]:g}, which no item's doJumpId is")


def _judge_start(parts: PlanParts, dialect: Dialect, findings: Findings) -> None:
    places = [item for item in parts.items if item.command in PLACES]
    for item in places[1:]:
        if item.command in (TAKEOFF, VTOL_TAKEOFF) and dialect.name == "PX4":
            findings.error(item.place, "PX4 refuses a take-off that is not the first item with a place")
    if not places:
        if parts.items and not parts.hollow:
            findings.error("mission.items", "no item has a place to fly to")
        return
    if places[0].command not in (TAKEOFF, VTOL_TAKEOFF):
        findings.warning(places[0].place, "the mission begins without a take-off")
    relative = [item for item in places if item.frame in RELATIVE_FRAMES]
    if relative and parts.home is None:
        findings.warning("mission.plannedHomePosition", "heights are above a home that is not given")
    for item in relative:
        if item.params[6] < 0:
            findings.warning(item.place, f"{-item.params[6]:g} m below home")
    if parts.home is not None:
        _judge_distances(places, parts.home, dialect, findings)


def _judge_distances(
    places: list[PlanItem], home: tuple[float, float, float], dialect: Dialect, findings: Findings
) -> None:
    said = [item for item in places if item.params[4] or item.params[5] or item.command == WAYPOINT]
    for number, item in enumerate(said):
        lat, lon = item.params[4:6]
        if not math.isfinite(lat + lon) or (not (lat or lon) and dialect.name != "PX4"):
            continue  # where it is then
        away_m = _great_circle_m(lat, lon, *home[:2])
        if away_m > FAR_M:
            findings.warning(item.place, f"at {lat:g}, {lon:g}, {away_m / 1000:.0f} km from the planned home")
        elif number == 0 and dialect.name == "PX4" and away_m > FIRST_WAYPOINT_M:
            findings.warning(item.place, f"{away_m:.0f} m from home, more than MIS_DIST_1WP = 900 m")


def _great_circle_m(lat_deg: float, lon_deg: float, other_lat_deg: float, other_lon_deg: float) -> float:
    lat, lon, other_lat, other_lon = map(math.radians, (lat_deg, lon_deg, other_lat_deg, other_lon_deg))
    across = math.cos(lat) * math.cos(other_lat) * math.sin((lon - other_lon) / 2) ** 2
    return (
        2
        * DEGREE_M
        * math.degrees(math.asin(math.sqrt(min(1.0, math.sin((lat - other_lat) / 2) ** 2 + across))))
    )


def _judge_counts(parts: PlanParts, dialect: Dialect, findings: Findings) -> None:
    count = len(parts.items) + parts.made_n
    if count > dialect.stores[-1][0]:
        findings.error("mission", f"{count} items; {dialect.name} holds {dialect.stores[-1][0]} at most")
    elif count > dialect.stores[0][0]:
        (less, few), (enough, many) = next(
            (a, b) for a, b in zip(dialect.stores, dialect.stores[1:], strict=False) if count <= b[0]
        )
        findings.warning(
            "mission", f"{count} items: {few} hold {less}, {many} {enough}. Fix: [vehicle] max_items"
        )
    corners = sum(len(polygon) for _, polygon in parts.polygons) + len(parts.circles)
    if corners > dialect.fence_max:
        findings.error("geoFence", f"{corners} corners and circles; {dialect.name} holds {dialect.fence_max}")
    if len(parts.rally) > dialect.rally_max:
        findings.error("rallyPoints", f"{len(parts.rally)} points; {dialect.name} holds {dialect.rally_max}")
