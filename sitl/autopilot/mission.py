"""AUTO: the uploaded mission, item by item, by the rules of PX4's navigator.

Sources: PX4 v1.17, mission_base.cpp, mission.cpp, mission_block.cpp. An item without a place takes a frame.
Simpler than PX4: a place of latitude and longitude zero is here, and gates and conditions never wait.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sitl.autopilot.course import Course, landing, lifting
from sitl.autopilot.glide import GlideLimits, stopping_point
from sitl.autopilot.itinerary import NAV, Station, next_seq, station_after, stations_of
from sitl.autopilot.modes import Briefing, Waypoint
from sitl.autopilot.passage import Leg, Passage, step_passage
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.plans import MissionRun, PlanItem
from sitl.rotation import to_yaw
from sitl.signals import Setpoint

__all__ = ["MissionCourse", "begin_mission"]


@dataclass(frozen=True, slots=True)
class MissionCourse:
    """A mission under way. `inner` climbs or lands; `deed` is the item that was carried out just now."""

    items: tuple[PlanItem, ...]
    stations: tuple[Station | None, ...]
    home_m: complex
    run: MissionRun
    leg: Leg
    passage: Passage
    yaw_ned_rad: float
    inner: Course | None = None
    arrived_at_us: int | None = None
    faced_at_us: int | None = None
    deed: PlanItem | None = None
    returns: bool = False

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now."""
        return self.passage.glide.setpoint() if self.inner is None else self.inner.setpoint

    def follows(self, _condition: Condition, _parameters: Mapping[str, float]) -> Mode | None:
        """The mode that comes after this one, once it is over."""
        if self.returns:
            return Mode.RETURN
        return Mode.HOLD if self.run.finished else None

    def ending(self) -> Course:
        """Holding where the mission ends; on the ground when it ends there."""
        if self.inner is not None:
            return self.inner
        return Course(Mode.HOLD, 0, math.nan, (self.leg.end,), self.passage.glide)

    def step(
        self,
        condition: Condition,
        dt_s: float,
        parameters: Mapping[str, float],
        bearing_rad: float = math.nan,
    ) -> MissionCourse:
        """The mission `dt_s` later. `bearing_rad` is where the region of interest lies, if there is one."""
        course = replace(self, deed=None) if self.deed is not None else self
        course = course._judged(condition, parameters)
        if course.inner is not None:
            return replace(course, inner=course.inner.step(condition, dt_s, parameters))
        yaw = course._yaw_wanted(condition, parameters, bearing_rad)
        glide = course.passage.glide
        north_m, east_m, _ = condition.estimate.position_ned_m.tolist()
        passage = step_passage(
            course.passage,
            course.leg,
            yaw,
            _limits(course.run.speed_mps, parameters),
            parameters,
            glide.position_m - complex(north_m, east_m),
            dt_s,
        )
        return replace(course, passage=passage, yaw_ned_rad=yaw)

    def _judged(self, condition: Condition, parameters: Mapping[str, float]) -> MissionCourse:
        """The mission after a look at whether its item is done."""
        item, station = self.items[self.run.seq], self.stations[self.run.seq]
        if self.run.finished or self.returns:
            return self
        if station is None:
            if item.command == NAV.DELAY:
                begun_us = condition.time_us if self.arrived_at_us is None else self.arrived_at_us
                waits = condition.time_us - begun_us < 1e6 * item.params[0]
                return replace(self, arrived_at_us=begun_us) if waits else self._advanced(parameters)
            return replace(self._advanced(parameters), deed=item)
        if self.inner is not None and not station.lands:
            return self._climbed(condition, parameters)
        if station.lands:
            return self._landed(station, condition, parameters)
        return self._arrived(station, condition, parameters)

    def _climbed(self, condition: Condition, parameters: Mapping[str, float]) -> MissionCourse:
        """On to the item's own place, when the climb over the place of take-off is done."""
        assert self.inner is not None
        top, station = self.inner.route[0], self.stations[self.run.seq]
        assert station is not None
        height_m = abs(top.down_m - float(condition.estimate.position_ned_m[2]))
        if height_m > parameters["NAV_MC_ALT_RAD"]:
            return self
        leg = _leg(self.items, self.stations, self.run, top, parameters)
        return replace(self, inner=None, leg=leg, passage=Passage(self.inner.glide))

    def _landed(
        self, station: Station, condition: Condition, parameters: Mapping[str, float]
    ) -> MissionCourse:
        if self.inner is None:
            north_m, east_m, _ = condition.estimate.position_ned_m.tolist()
            if abs(complex(north_m, east_m) - self.leg.end.place_m) > self.leg.radius_m:
                return self
            ground_m = station.waypoint.down_m
            return replace(self, inner=landing(self.leg.end.place_m, ground_m, self.passage.glide))
        return self._advanced(parameters) if condition.on_ground else self

    def _arrived(
        self, station: Station, condition: Condition, parameters: Mapping[str, float]
    ) -> MissionCourse:
        """Near enough, turned far enough, and waited long enough."""
        now_us, course = condition.time_us, self
        if course.arrived_at_us is None:
            north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
            near = abs(complex(north_m, east_m) - course.leg.end.place_m) <= course.leg.radius_m
            if not near or abs(down_m - course.leg.end.down_m) > parameters["NAV_MC_ALT_RAD"]:
                return course
            course = replace(course, arrived_at_us=now_us)
        assert course.arrived_at_us is not None
        if course.faced_at_us is None:
            patience_s = parameters["MIS_YAW_TMT"]
            waited = patience_s > 0.0
            wanted = station.waypoint.yaw_ned_rad
            if math.isfinite(wanted) and not waited and not station.takes_off:
                error = math.remainder(wanted - to_yaw(condition.estimate.q_ned_frd), math.tau)
                if abs(error) >= math.radians(parameters["MIS_YAW_ERR"]):
                    return course
            course = replace(course, faced_at_us=now_us)
        assert course.faced_at_us is not None
        if now_us - course.faced_at_us < 1e6 * station.hold_s:
            return course
        return course._advanced(parameters)

    def _advanced(self, parameters: Mapping[str, float]) -> MissionCourse:
        """On with the next item; the leg changes only when that has a place."""
        run = replace(self.run, reached=self.run.seq)
        item = self.items[run.seq]
        if item.command == NAV.RETURN:
            return replace(self, run=replace(run, finished=True), returns=True)
        if item.command == NAV.CHANGE_SPEED:
            run = replace(run, speed_mps=item.params[1] if item.params[1] > 0.0 else math.nan)
        seq, jumps = next_seq(self.items, run.seq, run.jumps)
        if seq is None:
            return replace(self, run=replace(run, finished=True))
        run = replace(run, seq=seq, jumps=jumps)
        before = self.stations[self.run.seq]
        inner = None if before is not None and before.lands else self.inner
        course = replace(self, run=run, inner=inner, arrived_at_us=None, faced_at_us=None)
        if self.stations[seq] is None:
            return course
        leg = _leg(self.items, self.stations, run, self.leg.end, parameters)
        return replace(course, leg=leg)

    def _yaw_wanted(self, condition: Condition, parameters: Mapping[str, float], bearing_rad: float) -> float:
        """The heading: to the region of interest, else the item's, else MPC_YAW_MODE's."""
        if math.isfinite(bearing_rad) and not parameters["MIS_MNT_YAW_CTL"]:
            return bearing_rad
        if math.isfinite(self.leg.end.yaw_ned_rad):
            return self.leg.end.yaw_ned_rad
        north_m, east_m, _ = condition.estimate.position_ned_m.tolist()
        here_m = complex(north_m, east_m)
        match int(parameters["MPC_YAW_MODE"]):
            case 1:
                way = self.home_m - here_m
            case 2:
                way = here_m - self.home_m
            case 3:
                return _heading(self.passage.glide.velocity_mps, 0.5, self.yaw_ned_rad)
            case 5:
                return self.yaw_ned_rad
            case _:
                way = self.leg.end.place_m - here_m
        return _heading(way, self.leg.radius_m, self.yaw_ned_rad)


def begin_mission(items: tuple[PlanItem, ...], run: MissionRun, briefing: Briefing) -> MissionCourse:
    """The mission from its current item on. Standing on the ground it climbs first, wherever it goes then."""
    parameters, glide = briefing.parameters, briefing.glide
    seq, jumps = next_seq(items, run.seq - 1, run.jumps)
    run = replace(run, seq=seq or 0, jumps=jumps, finished=seq is None)
    place_m, down_m = stopping_point(glide, parameters["MPC_ACC_HOR"])
    here = Waypoint(place_m, down_m)
    stations = stations_of(items, briefing.condition.origin, briefing.home, place_m)
    leg = _leg(items, stations, run, Waypoint(glide.position_m, glide.down_m), parameters, here)
    inner = None
    home_m = 0j if briefing.home is None else complex(*briefing.home.position_ned_m[:2].tolist())
    if briefing.condition.on_ground:
        first = station_after(items, stations, run.seq - 1, run.jumps)
        top_m = glide.down_m - parameters["MIS_TAKEOFF_ALT"]
        top_m = top_m if first is None else min(top_m, first.waypoint.down_m)
        inner = lifting(Waypoint(glide.position_m, top_m), briefing)
    return MissionCourse(
        items=items,
        stations=stations,
        home_m=home_m,
        run=run,
        leg=leg,
        passage=Passage(glide),
        yaw_ned_rad=glide.yaw_ned_rad,
        inner=inner,
    )


def _leg(
    items: tuple[PlanItem, ...],
    stations: tuple[Station | None, ...],
    run: MissionRun,
    begin: Waypoint,
    parameters: Mapping[str, float],
    otherwise: Waypoint | None = None,
) -> Leg:
    """The leg to the current item's place; to `otherwise` while it has none."""
    station = stations[run.seq]
    radius_m = parameters["NAV_ACC_RAD"]
    if station is None:
        return Leg(begin, otherwise or begin, None, radius_m)
    end = station.waypoint
    if station.lands:
        end = replace(end, down_m=begin.down_m)
    after = None
    if not (station.lands or station.stays or station.hold_s > 0.0):
        following = station_after(items, stations, run.seq, run.jumps)
        after = None if following is None else following.waypoint
    return Leg(begin, end, after, station.radius_m if station.radius_m > 0.0 else radius_m)


def _limits(speed_mps: float, parameters: Mapping[str, float]) -> GlideLimits:
    return GlideLimits(
        speed_mps=min(speed_mps, parameters["MPC_XY_VEL_MAX"])
        if speed_mps > 0.0
        else parameters["MPC_XY_CRUISE"],
        up_mps=parameters["MPC_Z_V_AUTO_UP"],
        down_mps=parameters["MPC_Z_V_AUTO_DN"],
        acceleration_mps2=parameters["MPC_ACC_HOR"],
        jerk_mps3=parameters["MPC_JERK_AUTO"],
        yaw_rate_radps=math.radians(parameters["MPC_YAWRAUTO_MAX"]),
    )


def _heading(way: complex, least: float, otherwise_rad: float) -> float:
    """Where `way` points; it says nothing when it is short."""
    return math.atan2(way.imag, way.real) if abs(way) > least else otherwise_rad
