"""The items of a mission as places to fly to, their order, and what speaks against flying them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from sitl.autopilot.modes import Waypoint
from sitl.geo import ned_of_geodetic
from sitl.plans import PlanItem
from sitl.signals import GeoPoint
from sitl.status import Home

__all__ = ["NAV", "Station", "next_seq", "remarks", "station_after", "stations_of", "why_not_fly"]


class NAV(IntEnum):
    """The commands that steer the vehicle, by MAVLink's numbers."""

    WAYPOINT = 16
    LOITER_UNLIM = 17
    LOITER_TIME = 19
    RETURN = 20
    LAND = 21
    TAKEOFF = 22
    LOITER_TO_ALT = 31
    VTOL_TAKEOFF = 84
    VTOL_LAND = 85
    DELAY = 93
    JUMP = 177
    CHANGE_SPEED = 178


_TAKEOFFS, _LANDINGS = (NAV.TAKEOFF, NAV.VTOL_TAKEOFF), (NAV.LAND, NAV.VTOL_LAND)
_WITH_YAW = (NAV.WAYPOINT, NAV.LOITER_UNLIM, NAV.LOITER_TIME, *_LANDINGS)
_WITH_HOLD = (NAV.WAYPOINT, NAV.LOITER_TIME)
_PLACES = (*_TAKEOFFS, *_WITH_YAW, NAV.LOITER_TO_ALT)
_JUMPS_IN_A_ROW = 10


@dataclass(frozen=True, slots=True)
class Station:
    """An item's place, and what is done there. A radius of zero is the usual one."""

    waypoint: Waypoint
    hold_s: float = 0.0
    radius_m: float = 0.0
    lands: bool = False
    takes_off: bool = False

    @property
    def stays(self) -> bool:
        """Whether it waits there for ever."""
        return math.isinf(self.hold_s)


def stations_of(
    items: tuple[PlanItem, ...], origin: GeoPoint | None, home: Home | None, here_m: complex
) -> tuple[Station | None, ...]:
    """Each item's place in the estimator's frame; None where it has none to fly to."""
    if origin is None or home is None:
        return (None,) * len(items)
    return tuple(_station(item, origin, home, here_m) if item.command in _PLACES else None for item in items)


def _station(item: PlanItem, origin: GeoPoint, home: Home, here_m: complex) -> Station:
    p1, p2, _, p4, lat_deg, lon_deg, alt_m = item.params
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    place_m, command = here_m, item.command
    if math.isfinite(lat_deg + lon_deg) and (lat_deg or lon_deg):
        north_m, east_m, _ = ned_of_geodetic(anchor, (lat_deg, lon_deg, origin.alt_amsl_m))
        place_m = complex(north_m, east_m)
    home_down_m = float(home.position_ned_m[2])
    down_m = home_down_m - alt_m if item.is_relative else origin.alt_amsl_m - alt_m
    hold_s = p1 if command in _WITH_HOLD and p1 > 0.0 else 0.0
    return Station(
        Waypoint(place_m, down_m, math.radians(p4) if command in _WITH_YAW else math.nan),
        hold_s=math.inf if command == NAV.LOITER_UNLIM or not item.autocontinue else hold_s,
        radius_m=p2 if command == NAV.WAYPOINT and p2 > 0.0 else 0.0,
        lands=command in _LANDINGS,
        takes_off=command in _TAKEOFFS,
    )


Jumps = tuple[tuple[int, int], ...]


def next_seq(items: tuple[PlanItem, ...], seq: int, jumps: Jumps) -> tuple[int | None, Jumps]:
    """The item after `seq`, and the jumps taken so far. None after the last."""
    seq += 1
    for _ in range(_JUMPS_IN_A_ROW):
        if not 0 <= seq < len(items):
            return None, jumps
        item = items[seq]
        if item.command != NAV.JUMP:
            return seq, jumps
        taken, often = dict(jumps), item.params[1]
        if often < 0.0 or taken.get(seq, 0) < often:
            jumps = tuple(sorted({**taken, seq: taken.get(seq, 0) + 1}.items()))
            seq = int(item.params[0])
        else:
            seq += 1
    return None, jumps


def station_after(
    items: tuple[PlanItem, ...], stations: tuple[Station | None, ...], seq: int, jumps: Jumps
) -> Station | None:
    """The next place after `seq`, unless something waits or ends before it."""
    for _ in items:
        following, jumps = next_seq(items, seq, jumps)
        if following is None or items[following].command in (NAV.RETURN, NAV.DELAY):
            return None
        station = stations[following]
        if station is not None:
            return station
        seq = following
    return None


def why_not_fly(items: tuple[PlanItem, ...], parameters: Mapping[str, float]) -> str | None:
    """What speaks against the mission, as PX4 would put it; None when nothing does."""
    commands = [item.command for item in items]
    takes_off = any(command in _TAKEOFFS for command in commands)
    lands = any(command in _LANDINGS for command in commands)
    if any(command in _TAKEOFFS for command in [c for c in commands if c in _PLACES][1:]):
        return "takeoff is not the first waypoint item"
    for item in items:
        if item.command == NAV.JUMP and not 0 <= item.params[0] < len(items):
            return "jump to an item that is not there"
    required = int(parameters["MIS_TKO_LAND_REQ"])
    if required in (1, 3) and not takes_off:
        return "Takeoff waypoint required"
    if required in (2, 3) and not lands:
        return "Landing waypoint/pattern required"
    if required == 4 and takes_off is not lands:
        return "Takeoff or Landing item missing"
    return None


def remarks(
    items: tuple[PlanItem, ...], origin: GeoPoint, home: Home, parameters: Mapping[str, float]
) -> list[str]:
    """What PX4 warns of without refusing the mission."""
    home_north_m, home_east_m, home_down_m = home.position_ned_m.tolist()
    home_m, told = complex(home_north_m, home_east_m), []
    stations = stations_of(items, origin, home, home_m)
    most_m = parameters["MIS_DIST_1WP"]
    first = next((station for station in stations if station is not None), None)
    if first is not None and 0.0 < most_m < abs(first.waypoint.place_m - home_m):
        far_m = abs(first.waypoint.place_m - home_m)
        told.append(f"First waypoint far away from Home: {far_m:.0f}m (maximum {most_m:.0f}m)")
    for seq, station in enumerate(stations):
        if station is not None and not station.lands and station.waypoint.down_m > home_down_m:
            told.append(f"Waypoint {seq + 1} below home")
            break
    return told
