"""Orders that send a flying vehicle somewhere: to a place, round a circle, on at another speed, or home to another place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from sitl.autopilot.arming import home_at
from sitl.autopilot.course import Course, begin_course
from sitl.autopilot.geofence import allows
from sitl.autopilot.glide import stopping_point
from sitl.autopilot.memory import CommanderState, notify
from sitl.autopilot.mission import MissionCourse
from sitl.autopilot.modes import repositioned
from sitl.autopilot.orbit import OrbitCourse, begin_orbit
from sitl.autopilot.planning import leave_mission
from sitl.autopilot.progress import briefing_of
from sitl.condition import Condition
from sitl.orders import ChangeSpeed, Mode, Orbit, Reposition, Verdict
from sitl.signals import GeoPoint
from sitl.status import OrbitRun, Severity

__all__ = ["change_speed", "circle", "orbit_run", "reposition", "set_home"]

_SPEED_TYPES = (0, 1)
"""MAVLink's SPEED_TYPE: a multicopter of PX4's takes airspeed for ground speed."""


def reposition(
    state: CommanderState,
    order: Reposition,
    condition: Condition,
    parameters: Mapping[str, float],
    *,
    flies: bool,
) -> Verdict:
    """Go there and hold; on the ground only the mode changes, and so it does where the fence does not let it go there."""
    origin = condition.origin
    if origin is None or not condition.estimate.position_ok:
        return Verdict.NOT_NOW
    leave_mission(state)
    held, state.mode, state.failsafe, state.for_need = state.conduct is Mode.HOLD, Mode.HOLD, None, None
    if not flies:
        return Verdict.ACCEPTED
    if not order.speed_mps > 0.0:
        order = replace(order, speed_mps=state.speed_mps)
    course = begin_course(Mode.HOLD, briefing_of(state, condition, parameters))
    goal = repositioned(order, origin, course.route[-1])
    if allows(state, condition, parameters, goal):
        state.course = course._replace(route=(goal,))
    else:
        notify(state, condition, Severity.CRITICAL, "Reposition is outside geofence")
        state.course = state.course if held else None
    return Verdict.ACCEPTED


def circle(
    state: CommanderState,
    order: Orbit,
    condition: Condition,
    parameters: Mapping[str, float],
    *,
    flies: bool,
) -> Verdict:
    """Go round; what the order leaves out is taken from the orbit under way. Only who flies can."""
    origin = condition.origin
    if origin is None or not condition.estimate.position_ok or not flies or not state.armed:
        return Verdict.NOT_NOW
    leave_mission(state)
    before = state.course if isinstance(state.course, OrbitCourse) else None
    glide = briefing_of(state, condition, parameters).glide
    _, stop_down_m = stopping_point(glide, parameters["MPC_ACC_HOR"])
    state.course = begin_orbit(order, before, origin, glide, stop_down_m)
    state.mode, state.failsafe, state.for_need, state.steering = Mode.ORBIT, None, None, None
    return Verdict.ACCEPTED


def change_speed(state: CommanderState, order: ChangeSpeed) -> Verdict:
    """Mission and reposition go on at that speed; zero or less is the usual one again."""
    if order.axis not in _SPEED_TYPES or not math.isfinite(order.speed_mps):
        return Verdict.DENIED
    speed_mps = order.speed_mps if order.speed_mps > 0.0 else math.nan
    state.speed_mps, course = speed_mps, state.course
    if isinstance(course, MissionCourse):
        state.run = replace(state.run, speed_mps=speed_mps)
        state.course = replace(course, run=replace(course.run, speed_mps=speed_mps))
    elif isinstance(course, Course) and course.mode is Mode.HOLD:
        state.course = course._replace(route=tuple(replace(w, speed_mps=speed_mps) for w in course.route))
    return Verdict.ACCEPTED


def set_home(state: CommanderState, point: GeoPoint | None, condition: Condition) -> Verdict:
    """Home is there, or here; arming does not move it any more."""
    home = home_at(point, condition)
    if home is None or not condition.knows_position:
        return Verdict.NOT_NOW
    state.home, state.home_locked = home, True
    return Verdict.ACCEPTED


def orbit_run(state: CommanderState, condition: Condition) -> OrbitRun | None:
    """The orbit that is being flown, if any."""
    course, origin = state.course, condition.origin
    return course.run(origin) if isinstance(course, OrbitCourse) and origin is not None else None
