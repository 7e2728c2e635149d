"""AUTO: the uploaded mission by ArduCopter's rules. Item 0 is home; the flight begins with item 1.

What navigates comes one after another; what stands between two items that navigate is done on the way to the
second, and a condition holds up what comes after it. A waypoint has no yaw of its own.
Source: ArduPilot 4.6, AP_Mission.cpp and mode_auto.cpp. Simpler: a speed that is changed in mid-leg counts from the next one
on, and a circle ends at rest.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sitl.autopilot.auto_items import PLACES, WAYPOINTS, AutoItem, next_item
from sitl.autopilot.auto_route import AnyLeg, Route
from sitl.autopilot.curves import CircleLeg
from sitl.autopilot.glide import Glide, start_glide, stopping_point
from sitl.autopilot.scurve import Leg, joins
from sitl.autopilot.shaping import shape_yaw
from sitl.autopilot.trip import (
    Speeds,
    Stop,
    Trip,
    acceleration_of,
    climb,
    fly_home,
    yaw_limits,
)
from sitl.condition import Condition
from sitl.plans import MissionRun, PlanItem
from sitl.signals import Setpoint
from sitl.status import Home

__all__ = ["Auto", "begin_auto", "changed"]

_NEVER = 0
"""Of WP_YAW_BEHAVIOR: the nose is not turned along the way."""
_TWO_LEGS = (AutoItem.LOITER_TURNS, AutoItem.LOITER_TO_ALT)
_YAW_WITHIN_RAD = math.radians(2.0)
_SLACK_M = 5.0
"""A target that is so far ahead of its vehicle waits for it."""


@dataclass(frozen=True, slots=True)
class Auto:
    """A mission under way. `deed` is the item for camera or gimbal that came up just now.

    `trip` climbs, lands or returns; else `leg` is flown, `leg_s` into it, and `after`, `after_s` into that.
    `at_place` is what LOITER_TURNS and LOITER_TO_ALT do where they have come to; `todo` are the items to be done on the way; `heading_rad` is CONDITION_YAW's.
    """

    items: tuple[PlanItem, ...]
    home: Home
    anchor: tuple[float, float, float]
    run: MissionRun
    glide: Glide
    speeds: Speeds
    leg: AnyLeg | None = None
    leg_s: float = 0.0
    after: Leg | None = None
    after_s: float = -1.0
    trip: Trip | None = None
    at_place: bool = False
    paused: bool = False
    pace: float = 1.0
    arrived_at_us: int | None = None
    todo: tuple[int, ...] = ()
    doing_since_us: int | None = None
    heading_rad: float = math.nan
    heading_rate_radps: float = math.nan
    deed: PlanItem | None = None

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now."""
        return self.glide.setpoint() if self.trip is None else self.trip.setpoint

    @property
    def goal_ned_m(self) -> tuple[float, float, float] | None:
        """Where the leg under way ends."""
        if self.trip is not None or self.leg is None:
            return None if self.trip is None else self.trip.goal_ned_m
        end = self.leg.motion(self.leg.duration_s)
        return end.place_m.real, end.place_m.imag, end.down_m

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
            return replace(auto, trip=trip, glide=trip.glide)
        return auto._flown(condition, dt_s, parameters, bearing_rad)

    def _flown(
        self, condition: Condition, dt: float, parameters: Mapping[str, float], bearing_rad: float
    ) -> Auto:
        glide = self.glide
        if self.leg is None or dt <= 0.0:
            return self
        north_m, east_m, _ = condition.estimate.position_ned_m.tolist()
        ahead_m = abs(glide.position_m - complex(north_m, east_m))
        moving = dt * max(0.0, 1.0 - max(0.0, ahead_m - 1.0) / _SLACK_M)
        speed_mps = abs(glide.velocity_mps) or abs(glide.down_speed_mps)
        braking = dt * acceleration_of(parameters, "WPNAV_ACCEL") / max(1.0, speed_mps)
        pace = max(0.0, self.pace - braking) if self.paused else min(1.0, self.pace + braking)
        moving *= pace
        leg_s, after_s = min(self.leg_s + moving, self.leg.duration_s), self.after_s
        radius_m, corner_mps2 = 0.01 * parameters["WPNAV_RADIUS"], 0.01 * parameters["WPNAV_ACCEL_C"]
        corner_mps2 = corner_mps2 or 2.0 * acceleration_of(parameters, "WPNAV_ACCEL")
        motion = self.leg.motion(leg_s)
        if self.after is not None:
            if after_s >= 0.0:
                after_s += moving
            elif isinstance(self.leg, Leg) and joins(self.leg, leg_s, self.after, radius_m, corner_mps2):
                after_s = moving
            second = self.after.motion(max(0.0, after_s))
            begin_m, begin_down_m = self.after.begin_m, self.after.begin_down_m
            motion = motion._replace(
                place_m=motion.place_m + second.place_m - begin_m,
                velocity_mps=motion.velocity_mps + second.velocity_mps,
                acceleration_mps2=motion.acceleration_mps2 + second.acceleration_mps2,
                down_m=motion.down_m + second.down_m - begin_down_m,
                down_speed_mps=motion.down_speed_mps + second.down_speed_mps,
                down_acceleration_mps2=motion.down_acceleration_mps2 + second.down_acceleration_mps2,
            )
        if pace < 1.0:
            motion = motion._replace(
                velocity_mps=motion.velocity_mps * pace,
                acceleration_mps2=motion.acceleration_mps2 * pace**2,
                down_speed_mps=motion.down_speed_mps * pace,
                down_acceleration_mps2=motion.down_acceleration_mps2 * pace**2,
            )
        yaw, rate = self._turning(motion.velocity_mps, parameters, bearing_rad, dt)
        return replace(self, pace=pace, leg_s=leg_s, after_s=after_s, glide=Glide(*motion, yaw, rate))

    def _turning(
        self, velocity_mps: complex, parameters: Mapping[str, float], bearing_rad: float, dt: float
    ) -> tuple[float, float]:
        """Heading and yaw rate: to the region of interest, else CONDITION_YAW's, else WP_YAW_BEHAVIOR's."""
        yaw, rate = self.glide.yaw_ned_rad, self.glide.yaw_rate_ned_radps
        constant_s, acceleration, most = yaw_limits(parameters)
        wanted = yaw
        if math.isfinite(bearing_rad):
            wanted = bearing_rad
        elif isinstance(self.leg, CircleLeg):
            wanted = cmath.phase(self.leg.centre_m - self.glide.position_m)
        elif math.isfinite(self.heading_rad):
            wanted = self.heading_rad
            most = self.heading_rate_radps if self.heading_rate_radps > 0.0 else most
        elif int(parameters["WP_YAW_BEHAVIOR"]) != _NEVER:
            creeping = abs(velocity_mps) <= 0.05 * 0.01 * parameters["WPNAV_SPEED"]
            wanted = yaw if creeping else math.atan2(velocity_mps.imag, velocity_mps.real)
        limits = constant_s, acceleration, most
        rate = shape_yaw(math.remainder(wanted - yaw, math.tau), 0.0, rate, limits, dt)
        return math.remainder(yaw + rate * dt, math.tau), rate

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
        if self.leg is None or self.leg_s < self.leg.duration_s:
            return self.leg is None
        if self.after is not None or self.leg.end_mps > 0.0:
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
        if self._item.command != AutoItem.DELAY:
            if self.leg is None or self.leg_s < self.leg.duration_s:
                return self
            north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
            off_m = math.hypot(
                abs(complex(north_m, east_m) - self.glide.position_m), down_m - self.glide.down_m
            )
            if off_m > 0.01 * parameters["WPNAV_RADIUS"]:
                return self
        if self._item.command == AutoItem.LAND:
            ground_m = float(self.home.position_ned_m[2])
            down = Trip((Stop(self.glide.position_m, math.inf),), self.glide, ground_m)
            return replace(self, trip=down, arrived_at_us=condition.time_us)
        if self._item.command in _TWO_LEGS and not self.at_place:
            leg = self._route(parameters).second_leg(self.run.seq, self._here(parameters))
            return replace(self, leg=leg, leg_s=0.0, at_place=True)
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
        item, route = self._item, self._route(parameters)
        keeps = int(parameters["WP_YAW_BEHAVIOR"]) == _NEVER
        auto = replace(
            self,
            trip=None,
            arrived_at_us=None,
            doing_since_us=None,
            at_place=False,
            heading_rad=self.heading_rad if keeps else math.nan,
        )
        if item.command == AutoItem.TAKEOFF:
            here = Stop(self.glide.position_m, self.glide.down_m)
            return replace(
                auto, trip=climb(self.glide, route.place(self.run.seq, here).down_m), leg=None, after=None
            )
        if item.command == AutoItem.RETURN:
            return replace(auto, trip=fly_home(self.glide, self.home, parameters), leg=None, after=None)
        if item.command not in PLACES:
            return auto._resting(parameters)
        here = self._here(parameters)
        if self.after is not None and self.after_s >= 0.0:
            auto = replace(auto, leg=self.after, leg_s=self.after_s, after=None, after_s=-1.0)
        else:
            leg = route.leg(self.run.seq, self.run.jumps, here, self.leg)
            auto = replace(auto, leg=leg, leg_s=0.0, after=None, after_s=-1.0)
        return replace(auto, after=route.onward(self.run.seq, self.run.jumps, here))

    def _resting(self, parameters: Mapping[str, float]) -> Auto:
        here = self._here(parameters)
        leg = self._route(parameters).straight(here, here)
        return replace(self, leg=leg, leg_s=0.0, after=None, after_s=-1.0)

    def _route(self, parameters: Mapping[str, float]) -> Route:
        return Route(self.items, self.home, self.anchor, self.speeds, parameters)

    def _here(self, parameters: Mapping[str, float]) -> Stop:
        if self.leg is not None:
            end = self.leg.motion(self.leg.duration_s)
            return Stop(end.place_m, end.down_m)
        return Stop(*stopping_point(self.glide, acceleration_of(parameters, "WPNAV_ACCEL")))

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
                if self.leg is None:
                    return done
                left_m = abs(self._here(parameters).place_m - self.glide.position_m)
                return done if left_m <= item.params[0] else waiting
            case AutoItem.CONDITION_YAW:
                if self.doing_since_us is None:
                    return waiting._headed(item)
                off = math.remainder(self.heading_rad - self.glide.yaw_ned_rad, math.tau)
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
            heading = self.glide.yaw_ned_rad + math.copysign(1.0, sign or 1.0) * heading
        return replace(self, heading_rad=heading, heading_rate_radps=math.radians(rate))


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
    auto = Auto(items, home, anchor, fresh, start_glide(condition.estimate), speeds, todo=passed)
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
