"""PX4's geofence: which areas hold, which places they allow, and what it does when it leaves them: GF_ACTION.

Source: PX4 v1.17, geofence.cpp, mission_feasibility_checker.cpp, navigator_main.cpp, geofenceCheck.cpp and failsafe.cpp,
fromGfActParam. Inside is within all uploaded inclusion areas (PX4's issue 27099: of several it wants all, not one) and outside all
exclusion areas, within GF_MAX_HOR_DIST and GF_MAX_VER_DIST of home. What it does on leaving them lasts until the mode is changed,
which lets the vehicle out; Hold is held where it left. Simpler than PX4: GF_PREDICT is not looked at.
"""

from __future__ import annotations

from collections.abc import Mapping

from sitl.autopilot.failsafe import Remark, call_for
from sitl.autopilot.fence import areas_beyond_m, areas_of
from sitl.autopilot.itinerary import stations_of
from sitl.autopilot.memory import CommanderState
from sitl.autopilot.modes import Waypoint
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.plans import PlanItem
from sitl.status import Severity

__all__ = ["TERMINATE", "allows", "breaches", "enforce", "watch_geofence", "waypoint_outside", "whereabouts"]

_WARN, TERMINATE = 1, 4
_MODES: Mapping[int, Mode] = {2: Mode.HOLD, 3: Mode.RETURN, 5: Mode.LAND}


def watch_geofence(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float]
) -> list[Remark]:
    """Note in `state.outside` whether it is outside, and call for what that asks for when it has just got there."""
    if condition.on_ground or not condition.knows_position or not _is_fenced(state, parameters):
        state.outside = False
        return []
    here, action = whereabouts(condition), int(parameters["GF_ACTION"])
    told, before = breaches(state, condition, parameters, here), state.outside
    state.outside = bool(told)
    mode = _MODES.get(action)
    under_way = mode is not None and state.for_need is mode
    if before or not told or not action or under_way:
        return []
    if mode is not None:
        call_for(state, mode, condition.time_us)
    if mode is Mode.HOLD and state.for_need is mode:
        state.left_at, state.course = here, None
    return told


def enforce(state: CommanderState, condition: Condition, parameters: Mapping[str, float]) -> list[Remark]:
    """Hold the uploaded areas, but for those that home or, in flight, the vehicle itself breaks already."""
    origin, told = condition.origin, list[Remark]()
    state.fence = state.plans.fence
    if origin is None or state.home is None:
        return told
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    home_north_m, home_east_m, _ = state.home.position_ned_m.tolist()
    places_m = {"Home position": complex(home_north_m, home_east_m)}
    if parameters["GF_ACTION"] and not condition.on_ground:
        places_m["current vehicle position"] = whereabouts(condition).place_m
    kept: tuple[PlanItem, ...] = ()
    for area in areas_of(state.plans.fence):
        broken = [
            name
            for name, place_m in places_m.items()
            if any(metres > 0.0 for _, metres in areas_beyond_m(area, anchor, place_m))
        ]
        told += [(Severity.CRITICAL, f"Geofence invalid, doesn't contain {name}") for name in broken]
        kept += () if broken else area
    state.fence = kept
    return told


def waypoint_outside(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float]
) -> str | None:
    """What PX4 says of the mission's first place beyond the fence; None when there is none, or nobody can tell yet."""
    if state.home is None or not _is_fenced(state, parameters):
        return None
    here_m = whereabouts(condition).place_m
    stations = stations_of(state.plans.mission, condition.origin, state.home, here_m)
    for seq, station in enumerate(stations):
        if station is not None and breaches(state, condition, parameters, station.waypoint):
            return f"Geofence violation for waypoint {seq + 1}"
    return None


def allows(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float], place: Waypoint
) -> bool:
    """Whether one may be sent there. A fence that only warns lets anybody go anywhere."""
    lax = int(parameters["GF_ACTION"]) in (0, _WARN)
    return lax or not breaches(state, condition, parameters, place)


def breaches(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float], place: Waypoint
) -> list[Remark]:
    """What PX4 says of that place: a line for each limit that it breaks."""
    home, origin = state.home, condition.origin
    if home is None or origin is None:
        return []
    far_m, high_m = parameters["GF_MAX_HOR_DIST"], parameters["GF_MAX_VER_DIST"]
    north_m, east_m, down_m = home.position_ned_m.tolist()
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    broken = {
        "exceeding maximum distance to Home": 0.0 < far_m < abs(place.place_m - complex(north_m, east_m)),
        "exceeding maximum altitude above Home": 0.0 < high_m < down_m - place.down_m,
        "approaching or outside geofence": any(
            metres > 0.0 for _, metres in areas_beyond_m(state.fence, anchor, place.place_m)
        ),
    }
    return [(Severity.CRITICAL, f"Geofence: {what}") for what, is_broken in broken.items() if is_broken]


def _is_fenced(state: CommanderState, parameters: Mapping[str, float]) -> bool:
    """Whether there is any limit to look at."""
    return bool(state.fence) or parameters["GF_MAX_HOR_DIST"] > 0.0 or parameters["GF_MAX_VER_DIST"] > 0.0


def whereabouts(condition: Condition) -> Waypoint:
    """Where the vehicle is."""
    north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
    return Waypoint(complex(north_m, east_m), down_m)
