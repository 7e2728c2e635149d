"""A mode's route, laid and followed frame by frame, and what comes after it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from sitl.autopilot.course import Course, begin_course
from sitl.autopilot.glide import start_glide
from sitl.autopilot.memory import CommanderState
from sitl.autopilot.mission import MissionCourse, begin_mission
from sitl.autopilot.modes import MODES, Briefing
from sitl.autopilot.orbit import OrbitCourse
from sitl.autopilot.planning import end_mission
from sitl.autopilot.sticks import led
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.signals import Setpoint

__all__ = ["briefing_of", "proceed"]


def proceed(
    state: CommanderState, condition: Condition, dt_s: float, parameters: Mapping[str, float]
) -> Setpoint:
    """The setpoint a frame further along the mode's route; the mode changes where the route ends."""
    course = _begin(state, condition, parameters) if state.course is None else state.course
    if isinstance(course, Course) and course.mode is Mode.POSITION:
        glide = led(course.glide, state.sticks, condition.estimate, parameters, dt_s)
        state.course = course._replace(glide=glide)
        return state.course.setpoint
    if isinstance(course, MissionCourse):
        course = course.step(condition, dt_s, parameters, state.payload.bearing_rad(condition))
        state.run = course.run
        if course.deed is not None:
            state.payload = state.payload.told(course.deed, state.home)
    else:
        course = course.step(condition, dt_s, parameters)
    state.course = course
    if MODES[state.mode].then is not None and state.failsafe is None:
        then = course.follows(condition, parameters)
        if then is not None and state.mode is Mode.MISSION:
            end_mission(state, then)
        elif then is not None:
            state.mode = then
    return course.setpoint


def briefing_of(state: CommanderState, condition: Condition, parameters: Mapping[str, float]) -> Briefing:
    """What a mode that begins now may know."""
    glide = start_glide(condition.estimate)
    return Briefing(condition, glide, state.home, state.takeoff_alt_amsl_m, parameters)


def _begin(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float]
) -> Course | MissionCourse | OrbitCourse:
    """The mode's route, laid from here."""
    briefing = briefing_of(state, condition, parameters)
    if state.conduct is Mode.MISSION:
        state.payload = replace(state.payload, paused=False)
        return begin_mission(state.plans.mission, state.run, briefing)
    course = begin_course(state.conduct, briefing)
    if state.left_at is not None and state.failsafe is Mode.HOLD:
        course = course._replace(route=(state.left_at,))
    state.left_at = None
    return course
