"""The places of a mission in AUTO, and the legs between them: straight ones and splines.

Source: ArduPilot 4.6, mode_auto.cpp and AC_WPNav.cpp. A spline leaves a place in the direction in which the leg before came in; it
arrives parallel to the way from its begin to the next place where that is a spline's too, else parallel to the next leg. Legs beside a spline
are joined at speed, straight ones by adding their motions up (`scurve`).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sitl.autopilot.auto_items import PLACES, WAYPOINTS, AutoItem, Jumps, next_item
from sitl.autopilot.curves import CircleLeg, SplineLeg, spline_between
from sitl.autopilot.scurve import Leg, leg_between, reaches_within, stops_within
from sitl.autopilot.trip import Speeds, Stop, acceleration_of, speeds_of, vertical_limits
from sitl.geo import ned_of_geodetic
from sitl.plans import PlanItem
from sitl.signals import FloatArray
from sitl.status import Home

__all__ = ["AnyLeg", "Route"]

AnyLeg = Leg | SplineLeg | CircleLeg
_LEAST_JERK, _LEAST_RADIUS_M, _STIFF = 0.1, 0.5, 10.0
_NOWHERE = np.zeros(3)


@dataclass(frozen=True, slots=True)
class Route:
    """A mission's items, where home is and where the local frame is anchored; `speeds` and `parameters` as they are now."""

    items: tuple[PlanItem, ...]
    home: Home
    anchor: tuple[float, float, float]
    speeds: Speeds
    parameters: Mapping[str, float]

    def leg(self, seq: int, jumps: Jumps, begin: Stop, last: AnyLeg | None) -> Leg | SplineLeg:
        """The leg to item `seq` after `last`, which it goes on from at speed if that ends with one."""
        begin_mps = 0.0 if last is None else last.end_mps
        before_m = _exit_m(last) if last is not None and begin_mps > 0.0 else _NOWHERE
        bare = self._leg(seq, jumps, begin, begin_mps, before_m, 0.0)
        end_mps = self._end_mps(seq, jumps, begin, bare)
        return self._leg(seq, jumps, begin, begin_mps, before_m, end_mps) if end_mps > 0.0 else bare

    def onward(self, seq: int, jumps: Jumps, begin: Stop) -> Leg | None:
        """The leg after item `seq`, which is flown to from `begin`, when its motion shall be added to this one's."""
        after = self._passed(seq, jumps)
        spline = AutoItem.SPLINE_WAYPOINT
        if after is None or spline in (self.items[seq].command, self.items[after].command):
            return None
        leg = self.leg(after, jumps, self.stop(seq, begin), None)
        assert isinstance(leg, Leg)
        return leg

    def straight(self, begin: Stop, end: Stop) -> Leg:
        """From rest to rest."""
        most = speeds_of(self.speeds, self.parameters)
        return leg_between(
            begin.place_m,
            begin.down_m,
            end.place_m,
            end.down_m,
            (most.speed_mps, most.up_mps, most.down_mps),
            (most.acceleration_mps2, vertical_limits(self.parameters)[0]),
            max(_LEAST_JERK, self.parameters["WPNAV_JERK"]),
        )

    def stop(self, seq: int, begin: Stop) -> Stop:
        """Where the leg to an item ends: at its place, or on the edge of its circle, or over its place as high as now."""
        item, place = self.items[seq], self.place(seq, begin)
        if item.command == AutoItem.LOITER_TURNS:
            out_m = begin.place_m - place.place_m
            way = out_m / abs(out_m) if abs(out_m) > _LEAST_RADIUS_M else -1.0
            return replace(place, place_m=place.place_m + self._radius_m(item) * way)
        return replace(place, down_m=begin.down_m) if item.command == AutoItem.LOITER_TO_ALT else place

    def place(self, seq: int, begin: Stop) -> Stop:
        """An item's place. Latitude and longitude zero, and height zero, are those of `begin`, as ArduPilot has it."""
        item = self.items[seq]
        lat_deg, lon_deg, alt_m = item.params[4:]
        place_m = begin.place_m
        if lat_deg or lon_deg:
            north_m, east_m, _ = ned_of_geodetic(self.anchor, (lat_deg, lon_deg, self.anchor[2]))
            place_m = complex(north_m, east_m)
        down_m = float(self.home.position_ned_m[2]) - alt_m if item.is_relative else self.anchor[2] - alt_m
        if item.command == AutoItem.LAND or (not alt_m and item.command != AutoItem.TAKEOFF):
            down_m = begin.down_m
        return Stop(place_m, down_m)

    def second_leg(self, seq: int, begin: Stop) -> Leg | CircleLeg | None:
        """What an item flies once it has come to its place: turns, or the rest of the height."""
        item, place = self.items[seq], self.place(seq, begin)
        if item.command == AutoItem.LOITER_TO_ALT:
            return self.straight(begin, place)
        if item.command != AutoItem.LOITER_TURNS:
            return None
        radius_m, accel_mps2 = self._radius_m(item), acceleration_of(self.parameters, "WPNAV_ACCEL")
        most_mps = min(
            speeds_of(self.speeds, self.parameters).speed_mps, math.sqrt(0.5 * accel_mps2 * radius_m)
        )
        rate_radps = math.radians(abs(self.parameters["CIRCLE_RATE"]))
        speed_mps = max(0.1, min(rate_radps * radius_m, most_mps))
        length_m = math.tau * radius_m * max(0.0, item.params[0])
        # It reaches its rate within a second.
        arc = Leg(0j, 0.0, 1.0, 0.0, length_m, speed_mps, speed_mps, _STIFF * speed_mps)
        turn = -1 if item.params[2] < 0.0 else 1
        centre_m = self.place(seq, Stop(begin.place_m, begin.down_m)).place_m
        if abs(begin.place_m - centre_m) < 0.5 * radius_m:
            centre_m = begin.place_m + radius_m
        out_rad = cmath.phase(begin.place_m - centre_m)
        return CircleLeg(centre_m, begin.down_m, abs(begin.place_m - centre_m), out_rad, turn, arc)

    def _radius_m(self, item: PlanItem) -> float:
        return max(_LEAST_RADIUS_M, abs(item.params[2]) or 0.01 * self.parameters["CIRCLE_RADIUS"])

    def _passed(self, seq: int, jumps: Jumps) -> int | None:
        """The place after item `seq`, when that is flown past."""
        item = self.items[seq]
        if item.command not in WAYPOINTS or item.params[0] > 0.0:
            return None
        after = next_item(self.items, seq, jumps).seq
        return after if after is not None and self.items[after].command in PLACES else None

    def _end_mps(self, seq: int, jumps: Jumps, begin: Stop, leg: Leg | SplineLeg) -> float:
        """How fast the leg may end: beside a spline it goes on at speed."""
        after = self._passed(seq, jumps)
        if after is None:
            return 0.0
        if AutoItem.SPLINE_WAYPOINT not in (self.items[seq].command, self.items[after].command):
            return 0.0
        onward = self._leg(after, jumps, self.stop(seq, begin), 0.0, _exit_m(leg), 0.0)
        return onward.entry_mps if isinstance(onward, SplineLeg) else stops_within(onward)

    def _leg(
        self, seq: int, jumps: Jumps, begin: Stop, begin_mps: float, before_m: FloatArray, end_mps: float
    ) -> Leg | SplineLeg:
        end = self.stop(seq, begin)
        if self.items[seq].command == AutoItem.SPLINE_WAYPOINT:
            spline = self._spline(seq, jumps, (begin, end), before_m, (begin_mps, end_mps))
            if spline is not None:
                return spline
        straight = self.straight(begin, end)
        if not straight.length_m:
            return straight
        ends = reaches_within(straight, begin_mps, min(end_mps, straight.speed_mps))
        return replace(straight, begin_mps=begin_mps, end_mps=ends)

    def _spline(
        self,
        seq: int,
        jumps: Jumps,
        stops: tuple[Stop, Stop],
        before_m: FloatArray,
        ends_mps: tuple[float, float],
    ) -> SplineLeg | None:
        begin, end = stops
        after, exit_m = self._passed(seq, jumps), _NOWHERE
        if after is not None:
            beyond = _ned_m(self.stop(after, end))
            from_begin = self.items[after].command == AutoItem.SPLINE_WAYPOINT
            exit_m = beyond - _ned_m(begin if from_begin else end)
        most = speeds_of(self.speeds, self.parameters)
        return spline_between(
            _ned_m(begin),
            _ned_m(end),
            (before_m, exit_m),
            (most.speed_mps, most.up_mps, most.down_mps),
            (most.acceleration_mps2, vertical_limits(self.parameters)[0]),
            ends_mps,
        )


def _ned_m(stop: Stop) -> FloatArray:
    return np.array((stop.place_m.real, stop.place_m.imag, stop.down_m))


def _exit_m(leg: AnyLeg) -> FloatArray:
    """The vector with which a leg ends."""
    match leg:
        case SplineLeg():
            return leg.exit_m
        case Leg():
            level_m = leg.level * leg.length_m
            return np.array((level_m.real, level_m.imag, leg.down * leg.length_m))
        case _:
            return _NOWHERE
