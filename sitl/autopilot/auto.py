"""AUTO: the uploaded mission by ArduCopter's rules. Item 0 is home; the flight begins with item 1.

What navigates comes one after another; what stands between two items that navigate is done on the way to the
second, and a condition holds up what comes after it. A waypoint has no yaw of its own.
How a leg is flown is in `auto_passage`, which legs there are in `auto_route`.
Source: ArduPilot 4.6, AP_Mission.cpp and mode_auto.cpp. Simpler: a speed that is changed in mid-leg counts from the
next one on, and a circle ends at rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sitl.autopilot.auto_items import PLACES, WAYPOINTS, AutoItem, next_item
from sitl.autopilot.auto_passage import NEVER, AutoPassage
from sitl.autopilot.auto_route import Route
from sitl.autopilot.glide import start_glide
from sitl.autopilot.trip import Speeds, Stop, Trip, climb, fly_home
from sitl.condition import Condition
from sitl.orders import TurnTo
from sitl.plans import MissionRun, PlanItem
from sitl.signals import Setpoint
from sitl.status import Home

__all__ = ["Auto", "begin_auto", "changed"]

_TWO_LEGS = (AutoItem.LOITER_TURNS, AutoItem.LOITER_TO_ALT)
_YAW_WITHIN_RAD = math.radians(2.0)


@dataclass(frozen=True, slots=True)
class Auto:
    """A mission under way. `deed` is the item for camera or gimbal that came up just now.

    `trip` climbs, lands or returns; else the target goes its `way`. `at_place` is what LOITER_TURNS and LOITER_TO_ALT do
    where they have come to; `todo` are the items to be done on the way.
    """

    items: tuple[PlanItem, ...]
    home: Home
    anchor: tuple[float, float, float]
    run: MissionRun
    way: AutoPassage
    speeds: Speeds
    trip: Trip | None = None
    at_place: bool = False
    arrived_at_us: int | None = None
    todo: tuple[int, ...] = ()
    doing_since_us: int | None = None
    deed: PlanItem | None = None

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now."""
        return self.way.glide.setpoint() if self.trip is None else self.trip.setpoint

    @property
    def goal_ned_m(self) -> tuple[float, float, float] | None:
        """Where the leg under way ends."""
        return self.way.goal_ned_m if self.trip is None else self.trip.goal_ned_m

    @property
    def comes_down(self) -> bool:
        """Whether the item under way ends on the ground."""
        return self.trip is not None and self.trip.stops[-1].is_landing

    def step(
        self, condition: Condition, dt_s: float, parameters: Mapping[str, float], bearing_rad: float
    ) -> Auto:
        """The mission `dt_s` later. `bearing_rad` is where the region of interest lies, if there is one."""
        auto = replace(self, deed=None) if self.deed is not None else self
        if auto._is_done(condition, parameters):
            auto = auto._advanced(parameters)
        else:
            auto = auto._arriving(condition, parameters)
        auto = auto._did(condition, parameters)
        if auto.trip is not None:
            trip = auto.trip.step(condition, dt_s, parameters, auto.speeds)
            return replace(auto, trip=trip, way=replace(auto.way, glide=trip.glide))
        return replace(auto, way=auto.way.step(condition, dt_s, parameters, bearing_rad))

    def held(self, *, paused: bool) -> Auto:
        """Standing still on the way, or going on."""
        return replace(self, way=replace(self.way, paused=paused))

    def turned(self, turn: TurnTo) -> Auto:
        """With CONDITION_YAW's heading, as an order."""
        yaw = turn.yaw_rad
        if turn.relative:
            yaw = yaw * (turn.sign or 1) + self.way.glide.yaw_ned_rad
        return replace(self, way=self.way.headed(yaw, turn.rate_radps or math.nan))

    @property
    def _item(self) -> PlanItem:
        return self.items[self.run.seq]

    def _is_done(self, condition: Condition, parameters: Mapping[str, float]) -> bool:
        """Whether the navigating item is done."""
        item = self._item
        if self.run.finished or self.comes_down or item.command == AutoItem.LOITER_UNLIM:
            return False
        if self.trip is not None:
            return self.trip.is_over(condition, parameters)
        if item.command == AutoItem.DELAY:
            return self._waited(condition, item.params[0])
        if not self.way.is_over:
            return self.way.leg is None
        if self.way.goes_on:
            return True
        if item.command in _TWO_LEGS:
            return self.at_place
        hold_s = item.params[0] if item.command in (*WAYPOINTS, AutoItem.LOITER_TIME) else 0.0
        return self._waited(condition, max(0.0, hold_s))

    def _waited(self, condition: Condition, hold_s: float) -> bool:
        return self.arrived_at_us is not None and condition.time_us - self.arrived_at_us >= 1e6 * hold_s

    def _arriving(self, condition: Condition, parameters: Mapping[str, float]) -> Auto:
        """Note when the vehicle is there; over the place of a landing it goes down."""
        if self.arrived_at_us is not None or self.trip is not None or self.run.finished:
            return self
        glide = self.way.glide
        if self._item.command != AutoItem.DELAY:
            if not self.way.is_over:
                return self
            north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
            off_m = math.hypot(abs(complex(north_m, east_m) - glide.position_m), down_m - glide.down_m)
            if off_m > 0.01 * parameters["WPNAV_RADIUS"]:
                return self
        if self._item.command == AutoItem.LAND:
            ground_m = float(self.home.position_ned_m[2])
            down = Trip((Stop(glide.position_m, math.inf),), glide, ground_m)
            return replace(self, trip=down, arrived_at_us=condition.time_us)
        if self._item.command in _TWO_LEGS and not self.at_place:
            leg = self._route(parameters).second_leg(self.run.seq, self.way.end(parameters))
            return replace(self, way=self.way.onto(leg), at_place=True)
        return replace(self, arrived_at_us=condition.time_us)

    def _advanced(self, parameters: Mapping[str, float]) -> Auto:
        """On with the next item that navigates; what was not done on the way to this one is not done any more."""
        run = replace(self.run, reached=self.run.seq)
        seq, jumps, passed = next_item(self.items, run.seq, run.jumps)
        auto = replace(self, todo=passed)._hastened()
        if seq is None:
            return replace(auto, run=replace(run, finished=True), trip=None)
        return replace(auto, run=replace(run, seq=seq, jumps=jumps))._begun(parameters)

    def _begun(self, parameters: Mapping[str, float]) -> Auto:
        """The current item, as it begins. A new one takes CONDITION_YAW's heading away, unless yaw is never changed."""
        item, route, way = self._item, self._route(parameters), self.way
        if int(parameters["WP_YAW_BEHAVIOR"]) != NEVER:
            way = replace(way, heading_rad=math.nan)
        auto = replace(self, trip=None, arrived_at_us=None, doing_since_us=None, at_place=False)
        if item.command == AutoItem.TAKEOFF:
            top = route.place(self.run.seq, Stop(way.glide.position_m, way.glide.down_m))
            return replace(auto, trip=climb(way.glide, top.down_m), way=way.onto(None))
        if item.command == AutoItem.RETURN:
            return replace(auto, trip=fly_home(way.glide, self.home, parameters), way=way.onto(None))
        here = way.end(parameters)
        if item.command not in PLACES:
            return replace(auto, way=way.onto(route.straight(here, here)))
        if way.joined is None:
            way = way.onto(route.leg(self.run.seq, self.run.jumps, here, way.leg))
        else:
            way = way.onto(way.joined, way.after_s)
        return replace(auto, way=replace(way, after=route.onward(self.run.seq, self.run.jumps, here)))

    def _route(self, parameters: Mapping[str, float]) -> Route:
        return Route(self.items, self.home, self.anchor, self.speeds, parameters)

    def _did(self, condition: Condition, parameters: Mapping[str, float]) -> Auto:
        """One of the items on the way a frame; a condition waits."""
        now_us = condition.time_us
        if not self.todo:
            return self
        item = self.items[self.todo[0]]
        done = replace(self, todo=self.todo[1:], doing_since_us=None)
        begun_us = now_us if self.doing_since_us is None else self.doing_since_us
        waiting = self if self.doing_since_us is not None else replace(self, doing_since_us=now_us)
        match item.command:
            case AutoItem.CONDITION_DELAY:
                return done if now_us - begun_us >= 1e6 * item.params[0] else waiting
            case AutoItem.CONDITION_DISTANCE:
                if self.way.leg is None:
                    return done
                left_m = abs(self.way.end(parameters).place_m - self.way.glide.position_m)
                return done if left_m <= item.params[0] else waiting
            case AutoItem.CONDITION_YAW:
                if self.doing_since_us is None:
                    return waiting._headed(item)
                off = math.remainder(self.way.heading_rad - self.way.glide.yaw_ned_rad, math.tau)
                return done if not abs(off) > _YAW_WITHIN_RAD else waiting
            case AutoItem.CHANGE_SPEED:
                return replace(done, speeds=changed(self.speeds, item.params[0], item.params[1]))
            case _:
                return replace(done, deed=item)

    def _hastened(self) -> Auto:
        """With the speeds that are to be changed first: the leg that begins is flown at them."""
        speeds, todo = self.speeds, self.todo
        while todo and self.items[todo[0]].command == AutoItem.CHANGE_SPEED:
            kind, speed_mps = self.items[todo[0]].params[:2]
            speeds, todo = changed(speeds, kind, speed_mps), todo[1:]
        return replace(self, speeds=speeds, todo=todo)

    def _headed(self, item: PlanItem) -> Auto:
        """CONDITION_YAW: degrees, degrees a second, direction, and whether it is relative."""
        angle, rate, sign, relative = item.params[:4]
        heading = math.radians(angle)
        if relative:
            heading = self.way.glide.yaw_ned_rad + math.copysign(1.0, sign or 1.0) * heading
        return replace(self, way=self.way.headed(heading, math.radians(rate)))


def begin_auto(
    items: tuple[PlanItem, ...],
    run: MissionRun,
    condition: Condition,
    home: Home,
    speeds: Speeds,
    parameters: Mapping[str, float],
) -> Auto:
    """The mission from its current item on, as the vehicle moves now. Needs an origin."""
    origin = condition.origin
    assert origin is not None
    begin = 0 if run.finished else max(0, run.seq - 1)
    seq, jumps, passed = next_item(items, begin, () if run.finished else run.jumps)
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    fresh = replace(run, seq=seq or 1, jumps=jumps, finished=seq is None)
    way = AutoPassage(start_glide(condition.estimate))
    auto = Auto(items, home, anchor, fresh, way, speeds, todo=passed)
    return auto._hastened()._begun(parameters) if seq is not None else auto


def changed(speeds: Speeds, kind: float, speed_mps: float) -> Speeds:
    """After DO_CHANGE_SPEED; a speed that is not positive changes nothing."""
    if not speed_mps > 0.0:
        return speeds
    match int(kind):
        case 2:
            return speeds._replace(up_mps=speed_mps)
        case 3:
            return speeds._replace(down_mps=speed_mps)
        case _:
            return speeds._replace(level_mps=speed_mps)
