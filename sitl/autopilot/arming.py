"""When the motors may start and when they are stopped, and where home is then."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from sitl.autopilot.modes import MODES
from sitl.condition import Condition
from sitl.geo import geodetic_of_ned, ned_of_geodetic
from sitl.orders import Mode
from sitl.signals import GeoPoint, vector
from sitl.status import Home

__all__ = ["UNWELL", "home_at", "home_in", "home_of", "idle_limit_us", "is_ready", "why_not_arm"]

UNWELL = "Resolve system health failures first"
"""Why one does not arm when it is something that was told before."""
_PREFLIGHT_EXTRA_US = 1_500_000
"""Auto-disarm without take-off was seen 11.5 s after arming, with COM_DISARM_PRFLT = 10 s."""


def is_ready(condition: Condition) -> bool:
    """Whether the vehicle knows enough of itself to fly."""
    estimate = condition.estimate
    return (
        estimate.attitude_ok
        and estimate.position_ok
        and estimate.velocity_ok
        and estimate.height_ok
        and condition.origin is not None
    )


def why_not_arm(condition: Condition, mode: Mode, *, streamed: bool, mission_ok: bool) -> str | None:
    """What speaks against arming in this mode; None when nothing does."""
    if not is_ready(condition):
        return UNWELL
    if not MODES[mode].arms:
        return "Mode not suitable for takeoff"
    if mode is Mode.OFFBOARD and not streamed:
        return "No offboard signal"
    if not streamed:
        return UNWELL
    if MODES[mode].needs_mission and not mission_ok:
        return "No valid mission available"
    return None


def home_of(condition: Condition) -> Home | None:
    """The place where the vehicle is now, if it knows it."""
    origin, estimate = condition.origin, condition.estimate
    if origin is None:
        return None
    north_m, east_m, down_m = estimate.position_ned_m.tolist()
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    point = GeoPoint(*geodetic_of_ned(anchor, (north_m, east_m, down_m)))
    return Home(point, estimate.position_ned_m, estimate.q_ned_frd)


def home_at(point: GeoPoint | None, condition: Condition) -> Home | None:
    """Home at that place, or here where none is given; nothing as long as the vehicle's own place is not known."""
    here = home_of(condition)
    return here if here is None or point is None else home_in(condition, replace(here, point=point))


def home_in(condition: Condition, home: Home | None) -> Home | None:
    """The same place, in the estimate's frame as it is now."""
    origin = condition.origin
    if home is None or origin is None:
        return home
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    point = home.point.lat_deg, home.point.lon_deg, home.point.alt_amsl_m
    return replace(home, position_ned_m=vector(ned_of_geodetic(anchor, point)))


def idle_limit_us(parameters: Mapping[str, float], *, flown: bool) -> float | None:
    """How long an armed vehicle may stand: before its flight, and after it. None: as long as it likes."""
    limit_s = parameters["COM_DISARM_LAND" if flown else "COM_DISARM_PRFLT"]
    if limit_s <= 0.0:
        return None
    return 1e6 * limit_s + (0 if flown else _PREFLIGHT_EXTRA_US)
