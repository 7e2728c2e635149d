"""PX4's answer when it leaves its geofence in flight: GF_ACTION.

Source: PX4 v1.17, geofence.cpp and failsafe.cpp, fromGfActParam. Inside is within any of the uploaded inclusion areas and outside all
exclusion areas, within GF_MAX_HOR_DIST and GF_MAX_VER_DIST of home. What it then does lasts until the mode is changed, which lets
the vehicle out. Simpler than PX4: missions, repositions and arming are not held against the fence; the text is not PX4's own.
"""

from __future__ import annotations

from collections.abc import Mapping

from sitl.autopilot.failsafe import Remark, call_for
from sitl.autopilot.fence import areas_beyond_m
from sitl.autopilot.memory import CommanderState
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.status import Severity

__all__ = ["TERMINATE", "watch_geofence"]

_WARN, TERMINATE = 1, 4
_MODES: Mapping[int, Mode] = {2: Mode.HOLD, 3: Mode.RETURN, 5: Mode.LAND}


def watch_geofence(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float]
) -> list[Remark]:
    """Note in `state.outside` whether it is outside, and call for what that asks for when it has just got there."""
    before, state.outside = state.outside, _is_outside(state, condition, parameters)
    action = int(parameters["GF_ACTION"])
    if before or not state.outside or not action:
        return []
    mode = _MODES.get(action)
    if mode is not None:
        call_for(state, mode, condition.time_us)
    return [(Severity.CRITICAL, "Geofence violation")]


def _is_outside(state: CommanderState, condition: Condition, parameters: Mapping[str, float]) -> bool:
    far_m, high_m = parameters["GF_MAX_HOR_DIST"], parameters["GF_MAX_VER_DIST"]
    fence, home, origin = state.plans.fence, state.home, condition.origin
    if not (fence or far_m > 0.0 or high_m > 0.0) or home is None or origin is None:
        return False
    if condition.on_ground or not condition.knows_position:
        return False
    north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
    home_north_m, home_east_m, home_down_m = home.position_ned_m.tolist()
    place_m = complex(north_m, east_m)
    if far_m > 0.0 and abs(place_m - complex(home_north_m, home_east_m)) > far_m:
        return True
    if high_m > 0.0 and home_down_m - down_m > high_m:
        return True
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    areas = list(areas_beyond_m(fence, anchor, place_m))
    included = [metres for is_inclusion, metres in areas if is_inclusion]
    in_excluded = any(metres > 0.0 for is_inclusion, metres in areas if not is_inclusion)
    return in_excluded or (bool(included) and min(included) > 0.0)
