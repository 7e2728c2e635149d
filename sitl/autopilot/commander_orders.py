"""What PX4's commander makes of an order: it changes the state, or says no."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from sitl.autopilot.arming import UNWELL, home_of, why_not_arm
from sitl.autopilot.charge import charge_of
from sitl.autopilot.errands import change_speed, circle, reposition, set_home
from sitl.autopilot.geofence import breaches, whereabouts
from sitl.autopilot.memory import NOTHING, CommanderState, notify
from sitl.autopilot.modes import MODES, climbs
from sitl.autopilot.planning import judge_mission, leave_mission, stand_down_mission, take_plan
from sitl.autopilot.shooting import use_payload
from sitl.autopilot.upset import leaning_axis
from sitl.condition import Condition
from sitl.orders import (
    Arm,
    ChangeSpeed,
    Disarm,
    GoToItem,
    Mode,
    Orbit,
    Order,
    Pause,
    Reposition,
    SetHome,
    SetOutput,
    StartMission,
    SwitchMode,
    TakeOff,
    TakePlan,
    TurnTo,
    UsePayload,
    Verdict,
    WishMode,
)
from sitl.status import Severity

__all__ = ["carry_out", "may_fly", "remark", "stand_down"]


def carry_out(
    state: CommanderState,
    order: Order,
    condition: Condition,
    parameters: Mapping[str, float],
    *,
    lost_us: Callable[[Mode], float],
) -> Verdict:
    """Carry out the order, or not. What a mode follows counts as streamed until `lost_us(mode)`, if no more comes."""
    match order:
        case Arm(force):
            return _arm(state, condition, parameters, lost_us, force=force)
        case Disarm(force):
            return _disarm(state, condition, force=force)
        case TakeOff(alt_amsl_m):
            state.takeoff_alt_amsl_m = alt_amsl_m
            return _switch(state, Mode.TAKEOFF, condition, lost_us)
        case SwitchMode(mode):
            state.takeoff_alt_amsl_m = math.nan
            if mode is Mode.MISSION:
                remark(state, condition, judge_mission(state, condition, parameters))
            return _switch(state, mode, condition, lost_us)
        case WishMode(name):
            return _refuse_mode(state, name, condition)
        case Reposition():
            flies = may_fly(state, condition, parameters)
            return reposition(state, order, condition, parameters, flies=flies)
        case Orbit():
            flies = may_fly(state, condition, parameters)
            verdict = circle(state, order, condition, parameters, flies=flies)
            if verdict is not Verdict.ACCEPTED:
                notify(state, condition, Severity.CRITICAL, "Orbit command rejected")
            return verdict
        case ChangeSpeed():
            return change_speed(state, order)
        case TakePlan():
            remark(state, condition, take_plan(state, order, condition, parameters))
            return Verdict.ACCEPTED
        case GoToItem(seq):
            return _go_to(state, seq)
        case StartMission():
            return _start_mission(state, condition, parameters, lost_us)
        case UsePayload(item):
            return use_payload(state, item)
        case SetHome(point):
            return set_home(state, point, condition)
        case TurnTo() | SetOutput() | Pause():
            return Verdict.DENIED


def _arm(
    state: CommanderState,
    condition: Condition,
    parameters: Mapping[str, float],
    lost_us: Callable[[Mode], float],
    *,
    force: bool,
) -> Verdict:
    if state.armed:
        return Verdict.ACCEPTED
    if not force:
        axis = leaning_axis(condition, parameters)
        if axis:
            notify(state, condition, Severity.CRITICAL, f"Preflight Fail: Attitude failure ({axis})")
            return Verdict.NOT_NOW
        if state.mode is Mode.MISSION:
            remark(state, condition, judge_mission(state, condition, parameters))
        told = (
            breaches(state, condition, parameters, whereabouts(condition)) if parameters["GF_ACTION"] else []
        )
        remark(state, condition, told)
        streamed = condition.time_us <= lost_us(state.mode)
        reason = why_not_arm(condition, state.mode, streamed=streamed, mission_ok=state.mission_ok)
        if reason is None and told:
            reason = UNWELL
        if reason is not None:
            notify(state, condition, Severity.CRITICAL, f"Arming denied: {reason}")
            return Verdict.NOT_NOW
    state.armed, state.armed_at_us = True, condition.time_us
    state.flown, state.standing_since_us, state.failsafe = False, None, None
    state.charge, state.for_need = charge_of(condition.charge_left, parameters), None
    state.course = None
    if not state.home_locked:
        state.home = home_of(condition) or state.home
    notify(state, condition, Severity.INFO, "Armed by external command")
    return Verdict.ACCEPTED


def _disarm(state: CommanderState, condition: Condition, *, force: bool) -> Verdict:
    if not state.armed:
        return Verdict.ACCEPTED
    if not (condition.on_ground or force):
        notify(state, condition, Severity.CRITICAL, "Disarming denied: not landed")
        return Verdict.NOT_NOW
    stand_down(state, condition, "Disarmed by external command")
    return Verdict.ACCEPTED


def stand_down(state: CommanderState, condition: Condition, text: str) -> None:
    """Stop the motors, forget what was going on, and say `text`."""
    state.armed, state.failsafe, state.for_need, state.steering = False, None, None, None
    state.outside = False
    state.course, state.leaning_since_us, state.upset = None, None, False
    state.setpoint = NOTHING
    stand_down_mission(state)
    state.mode = MODES[state.mode].after_disarm or state.mode
    notify(state, condition, Severity.INFO, text)


def _switch(
    state: CommanderState, mode: Mode, condition: Condition, lost_us: Callable[[Mode], float]
) -> Verdict:
    row = MODES[mode]
    lost = condition.time_us > lost_us(mode)
    homeless = row.needs_home and state.home is None
    # Disarmed, PX4 takes any mode, and then will not arm.
    if state.armed and (lost or homeless or (row.needs_mission and not state.mission_ok)):
        return _refuse_mode(state, mode.name.capitalize(), condition)
    if mode is not Mode.MISSION:
        leave_mission(state)
    if state.conduct is not mode or mode is Mode.TAKEOFF:
        state.steering = state.course = None
    state.mode, state.failsafe, state.for_need, state.speed_mps = mode, None, None, math.nan
    return Verdict.ACCEPTED


def _refuse_mode(state: CommanderState, name: str, condition: Condition) -> Verdict:
    text = f"Switching to mode '{name}' is currently not available"
    notify(state, condition, Severity.CRITICAL, text)
    return Verdict.NOT_NOW


def _start_mission(
    state: CommanderState,
    condition: Condition,
    parameters: Mapping[str, float],
    lost_us: Callable[[Mode], float],
) -> Verdict:
    remark(state, condition, judge_mission(state, condition, parameters))
    if not state.mission_ok:
        notify(state, condition, Severity.CRITICAL, "Mission start denied! No valid mission")
        return Verdict.DENIED
    verdict = _switch(state, Mode.MISSION, condition, lost_us)
    if verdict is not Verdict.ACCEPTED:
        return verdict
    return _arm(state, condition, parameters, lost_us, force=False)


def _go_to(state: CommanderState, seq: int) -> Verdict:
    if not 0 <= seq < len(state.plans.mission):
        return Verdict.DENIED
    state.run = replace(state.run, seq=seq, finished=False)
    if state.conduct is Mode.MISSION:
        state.course = None
    return Verdict.ACCEPTED


def may_fly(state: CommanderState, condition: Condition, parameters: Mapping[str, float]) -> bool:
    """Whether the motors may do more than idle."""
    if not condition.on_ground:
        return True
    if state.conduct is Mode.POSITION and not state.sticks.up > parameters["MAN_DEADZONE"]:
        return False
    if not MODES[state.conduct].leaves_ground:
        return False
    if state.conduct is Mode.TAKEOFF and not climbs(condition, state.takeoff_alt_amsl_m):
        return False
    spooled_us = state.armed_at_us + 1e6 * parameters["COM_SPOOLUP_TIME"]
    return state.flown or condition.time_us >= spooled_us


def remark(state: CommanderState, condition: Condition, remarks: Iterable[tuple[Severity, str]]) -> None:
    """Keep several lines of text to be told."""
    for severity, text in remarks:
        notify(state, condition, severity, text)
