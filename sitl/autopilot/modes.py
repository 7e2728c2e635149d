"""The modes as a table: what each does, and when it may be entered.

Apart from OFFBOARD and MISSION a mode is a route to glide along. A waypoint whose `down_m` is infinite is a landing.
Simpler than PX4: while returning, the nose keeps its heading.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sitl.autopilot.glide import Glide, stopping_point
from sitl.autopilot.homecoming import return_height_m
from sitl.condition import Condition
from sitl.geo import ned_of_geodetic
from sitl.orders import Mode, Reposition
from sitl.signals import GeoPoint
from sitl.status import Home

__all__ = ["MODES", "Briefing", "ModeRow", "Route", "Waypoint", "climbs", "repositioned"]

_LEAST_CLIMB_M = 0.1


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A place to glide to: north + i·east, and down. NaN keeps the heading, or the usual speed."""

    place_m: complex
    down_m: float
    yaw_ned_rad: float = math.nan
    speed_mps: float = math.nan

    @property
    def is_landing(self) -> bool:
        """Whether this is the ground, wherever it is."""
        return math.isinf(self.down_m)


@dataclass(frozen=True, slots=True, eq=False)
class Briefing:
    """What a mode may know when it lays its route."""

    condition: Condition
    glide: Glide
    home: Home | None
    takeoff_alt_amsl_m: float
    parameters: Mapping[str, float]


Route = tuple[Waypoint, ...]


@dataclass(frozen=True, slots=True)
class ModeRow:
    """One mode: its route, what follows it in the air and after disarming, and whether one may arm in it."""

    route: Callable[[Briefing], Route]
    then: Mode | None = None
    after_disarm: Mode | None = None
    arms: bool = True
    leaves_ground: bool = False
    needs_home: bool = False
    needs_mission: bool = False


def climbs(condition: Condition, alt_amsl_m: float) -> bool:
    """Whether a take-off to that height (NaN: the usual one) leads up. Else PX4 says yes and stays down."""
    if condition.origin is None or math.isnan(alt_amsl_m):
        return True
    here_m = float(condition.estimate.position_ned_m[2])
    return condition.origin.alt_amsl_m - alt_amsl_m < here_m - _LEAST_CLIMB_M


def repositioned(order: Reposition, origin: GeoPoint, here: Waypoint) -> Waypoint:
    """Where the order sends a vehicle that would otherwise hold `here`."""
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    north_m, east_m, _ = ned_of_geodetic(anchor, (order.lat_deg, order.lon_deg, origin.alt_amsl_m))
    down_m = origin.alt_amsl_m - order.alt_amsl_m
    return Waypoint(
        place_m=complex(north_m, east_m) if math.isfinite(north_m + east_m) else here.place_m,
        down_m=down_m if math.isfinite(down_m) else here.down_m,
        yaw_ned_rad=order.yaw_ned_rad,
        speed_mps=order.speed_mps,
    )


def _stop_here(briefing: Briefing) -> Route:
    place_m, down_m = stopping_point(briefing.glide, briefing.parameters["MPC_ACC_HOR"])
    return (Waypoint(place_m, down_m),)


def _climb(briefing: Briefing) -> Route:
    """Straight up, never down."""
    here_m = briefing.glide.down_m
    origin, alt_amsl_m = briefing.condition.origin, briefing.takeoff_alt_amsl_m
    if origin is None or math.isnan(alt_amsl_m):
        top_m = here_m - briefing.parameters["MIS_TAKEOFF_ALT"]
    else:
        top_m = min(here_m, origin.alt_amsl_m - alt_amsl_m)
    place_m, _ = stopping_point(briefing.glide, briefing.parameters["MPC_ACC_HOR"])
    return (Waypoint(place_m, top_m),)


def _land_here(briefing: Briefing) -> Route:
    place_m, _ = stopping_point(briefing.glide, briefing.parameters["MPC_ACC_HOR"])
    return (Waypoint(place_m, math.inf),)


def _fly_home(briefing: Briefing) -> Route:
    if briefing.home is None:
        return _land_here(briefing)
    north_m, east_m, home_down_m = briefing.home.position_ned_m.tolist()
    home_m = complex(north_m, east_m)
    place_m, down_m = stopping_point(briefing.glide, briefing.parameters["MPC_ACC_HOR"])
    height_m = return_height_m(abs(home_m - place_m), home_down_m - down_m, briefing.parameters)
    high_m = home_down_m - height_m
    return (Waypoint(place_m, high_m), Waypoint(home_m, high_m), Waypoint(home_m, math.inf))


MODES: Mapping[Mode, ModeRow] = {
    Mode.POSITION: ModeRow(_stop_here, leaves_ground=True),
    Mode.HOLD: ModeRow(_stop_here),
    Mode.TAKEOFF: ModeRow(_climb, then=Mode.HOLD, after_disarm=Mode.HOLD, leaves_ground=True),
    Mode.MISSION: ModeRow(
        _stop_here, then=Mode.HOLD, leaves_ground=True, needs_home=True, needs_mission=True
    ),
    Mode.RETURN: ModeRow(_fly_home, after_disarm=Mode.HOLD, arms=False, needs_home=True),
    Mode.LAND: ModeRow(_land_here, after_disarm=Mode.HOLD, arms=False),
    Mode.OFFBOARD: ModeRow(_stop_here, leaves_ground=True),
    Mode.ORBIT: ModeRow(_stop_here, arms=False),
}
