"""What ArduCopter's commander makes of an order: it changes the state, or says no."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from sitl.autopilot.angled import angled
from sitl.autopilot.arming import home_at, home_of, is_ready
from sitl.autopilot.auto import Auto, changed
from sitl.autopilot.auto_items import navigates, takes_off_first
from sitl.autopilot.copter_memory import (
    CopterState,
    knows_place,
    refuse,
    stand_down,
    sticks_of,
    trusts_place,
)
from sitl.autopilot.copter_modes import COPTER_MODES
from sitl.autopilot.fence import beyond
from sitl.autopilot.guided import Guided, begin_guided
from sitl.autopilot.memory import NOTHING, notify
from sitl.autopilot.shooting import use_payload
from sitl.condition import Condition
from sitl.geo import ned_of_geodetic
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
from sitl.plans import MissionRun, PlanKind
from sitl.rotation import tilt_rad
from sitl.signals import GeoPoint, Setpoint
from sitl.status import Severity

__all__ = ["carry_out", "steer", "switch"]

_MOTORS_N, _OUTPUTS_N = 4, 16
_BOTTOM = -0.99
"""A throttle in its lowest place: where it is by hand, nothing else is armed with."""


def carry_out(
    state: CopterState, order: Order, condition: Condition, parameters: Mapping[str, float]
) -> Verdict:
    """Carry out the order, or not."""
    match order:
        case Arm(force):
            return _arm(state, condition, parameters, force=force)
        case Disarm(force):
            return _disarm(state, condition, force=force)
        case TakeOff(alt_amsl_m):
            return _take_off(state, alt_amsl_m, condition)
        case SwitchMode(mode):
            return switch(state, mode, condition)
        case Reposition():
            return _reposition(state, order, condition, parameters)
        case TakePlan():
            return _take_plan(state, order)
        case GoToItem(seq):
            return _go_to(state, seq, condition)
        case StartMission():
            verdict = switch(state, Mode.AUTO, condition)
            state.auto_armed |= verdict is Verdict.ACCEPTED
            return verdict
        case UsePayload(item):
            return use_payload(state, item)
        case SetHome(point):
            return _set_home(state, point, condition)
        case ChangeSpeed(axis, speed_mps):
            state.speeds = changed(state.speeds, axis, speed_mps)
            if isinstance(state.going, Auto):
                state.going = replace(state.going, speeds=state.speeds)
            return Verdict.ACCEPTED if speed_mps > 0.0 else Verdict.DENIED
        case TurnTo():
            return _turn(state, order)
        case SetOutput(number, pwm_us):
            return _put(state, number, pwm_us)
        case Pause(go_on):
            return _pause(state, go_on=go_on)
        case Orbit() | WishMode():
            return Verdict.DENIED


def steer(
    state: CopterState, setpoint: Setpoint, condition: Condition, parameters: Mapping[str, float]
) -> None:
    """Take a target: obeyed in GUIDED only, when armed, and not to a place beyond the fence. It ends a take-off."""
    if state.mode is not Mode.GUIDED or not state.armed:
        return
    if setpoint.attitude is not None:
        state.going = angled(state.going, setpoint.attitude, condition)
    elif not _fenced_off(state, setpoint, condition, parameters):
        going = state.going if isinstance(state.going, Guided) else begin_guided(condition)
        state.going = going.told(setpoint, condition.time_us)


def _fenced_off(
    state: CopterState, setpoint: Setpoint, condition: Condition, parameters: Mapping[str, float]
) -> bool:
    """Whether it is a place to go to, without a velocity, that lies beyond the fence."""
    north_m, east_m, down_m = setpoint.position_ned_m
    if not (math.isfinite(north_m) and math.isnan(setpoint.velocity_ned_mps[0])):
        return False
    beyond_m = beyond(state, condition, parameters, complex(north_m, east_m), down_m)
    return any(metres >= 0.0 for metres in beyond_m.values())


def _leans(condition: Condition, parameters: Mapping[str, float]) -> bool:
    """Further than ANGLE_MAX, which is in hundredths of a degree."""
    return tilt_rad(condition.estimate.q_ned_frd) > math.radians(0.01 * parameters["ANGLE_MAX"])


def _arm(
    state: CopterState, condition: Condition, parameters: Mapping[str, float], *, force: bool
) -> Verdict:
    if state.armed:
        return Verdict.ACCEPTED
    row = COPTER_MODES[state.mode]
    if not row.arms:
        return refuse(state, condition, f"Arm: {state.mode.name} mode not armable")
    lost = not is_ready(condition) or (row.needs_place and not knows_place(condition))
    if lost and not force:
        return refuse(state, condition, "Arm: Need Position Estimate")
    if not force and _leans(condition, parameters):
        return refuse(state, condition, "Arm: Leaning")
    sticks = sticks_of(state, condition.time_us, parameters)
    if sticks is not None and not force and sticks.up > (_BOTTOM if state.mode is Mode.STABILIZE else 0.0):
        return refuse(state, condition, "Arm: Throttle too high")
    state.armed, state.armed_at_us = True, condition.time_us
    state.flown, state.standing_since_us = False, None
    state.going, state.auto_armed = None, False
    if knows_place(condition) and not state.home_locked:
        state.home = home_of(condition) or state.home
    notify(state, condition, Severity.INFO, "Arming motors")
    return Verdict.ACCEPTED


def _disarm(state: CopterState, condition: Condition, *, force: bool) -> Verdict:
    if not state.armed:
        return Verdict.ACCEPTED
    if not (condition.on_ground or force):
        return Verdict.NOT_NOW
    stand_down(state, condition)
    return Verdict.ACCEPTED


def _take_off(state: CopterState, alt_amsl_m: float, condition: Condition) -> Verdict:
    """Only in GUIDED, armed and on the ground, and upwards."""
    origin = condition.origin
    if state.mode is not Mode.GUIDED or not state.armed or not condition.on_ground or origin is None:
        return Verdict.NOT_NOW
    down_m = origin.alt_amsl_m - alt_amsl_m
    if not down_m < float(condition.estimate.position_ned_m[2]):
        return Verdict.NOT_NOW
    state.going = begin_guided(condition).lifted(down_m)
    state.auto_armed = True
    return Verdict.ACCEPTED


def switch(state: CopterState, mode: Mode, condition: Condition) -> Verdict:
    """Change the mode; refused where it cannot be flown."""
    name = mode.name
    if mode is state.mode:
        return Verdict.ACCEPTED
    if state.armed and COPTER_MODES[mode].needs_place and not trusts_place(state, condition):
        return refuse(state, condition, f"Mode change to {name} failed: requires position")
    if mode is Mode.AUTO:
        if not navigates(state.plans.mission):
            return refuse(state, condition, f"Mode change to {name} failed: init failed")
        standing = state.armed and condition.on_ground
        if standing and not takes_off_first(state.plans.mission, state.run.seq):
            notify(state, condition, Severity.CRITICAL, "Auto: Missing Takeoff Cmd")
            return refuse(state, condition, f"Mode change to {name} failed: init failed")
    if mode is Mode.SMARTRTL and not state.trail.leads_home:
        return refuse(state, condition, f"Mode change to {name} failed: init failed")
    if state.mode is Mode.AUTO:
        state.payload = replace(state.payload, paused=True)
    state.mode, state.going = mode, None
    state.blind = mode is Mode.LAND and not trusts_place(state, condition)
    return Verdict.ACCEPTED


def _reposition(
    state: CopterState, order: Reposition, condition: Condition, parameters: Mapping[str, float]
) -> Verdict:
    """Only in GUIDED, which it may change to; NaN keeps what is."""
    origin = condition.origin
    if origin is None or not trusts_place(state, condition):
        return Verdict.NOT_NOW
    if switch(state, Mode.GUIDED, condition) is not Verdict.ACCEPTED:
        return Verdict.NOT_NOW
    here_north_m, here_east_m, here_down_m = condition.estimate.position_ned_m.tolist()
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    north_m, east_m, _ = ned_of_geodetic(anchor, (order.lat_deg, order.lon_deg, origin.alt_amsl_m))
    down_m = origin.alt_amsl_m - order.alt_amsl_m
    placed = math.isfinite(north_m + east_m)
    place_m = (
        north_m if placed else here_north_m,
        east_m if placed else here_east_m,
        down_m if math.isfinite(down_m) else here_down_m,
    )
    target = NOTHING._replace(position_ned_m=place_m, yaw_ned_rad=order.yaw_ned_rad)
    if _fenced_off(state, target, condition, parameters):
        return Verdict.NOT_NOW
    if order.speed_mps > 0.0:
        state.speeds = changed(state.speeds, 1.0, order.speed_mps)
    steer(state, target, condition, parameters)
    return Verdict.ACCEPTED


def _take_plan(state: CopterState, order: TakePlan) -> Verdict:
    state.plans = state.plans.with_items(order.kind, order.items)
    if order.kind is PlanKind.MISSION:
        if isinstance(state.going, Auto):
            state.going = None
        if order.restart or state.run.finished:
            state.run = MissionRun()
        if state.mode is Mode.AUTO and not navigates(order.items):
            state.mode = Mode.LOITER
    return Verdict.ACCEPTED


def _go_to(state: CopterState, seq: int, condition: Condition) -> Verdict:
    if not 0 <= seq < len(state.plans.mission):
        return Verdict.NOT_NOW
    state.run = replace(state.run, seq=seq, finished=False)
    if isinstance(state.going, Auto) and not condition.on_ground:
        state.going = None
    return Verdict.ACCEPTED


def _set_home(state: CopterState, point: GeoPoint | None, condition: Condition) -> Verdict:
    """Home moves; the local frame does not."""
    home = home_at(point, condition)
    if home is None or not knows_place(condition):
        return Verdict.NOT_NOW
    state.home, state.home_locked = home, True
    return Verdict.ACCEPTED


def _put(state: CopterState, number: int, pwm_us: int) -> Verdict:
    """Not on the outputs of the motors."""
    if not _MOTORS_N < number <= _OUTPUTS_N:
        return Verdict.NOT_NOW
    state.outputs = tuple(sorted({**dict(state.outputs), number: pwm_us}.items()))
    return Verdict.ACCEPTED


def _pause(state: CopterState, *, go_on: bool) -> Verdict:
    """A mission alone can be paused; GUIDED has nothing to go on with here."""
    if not isinstance(state.going, Auto):
        return Verdict.DENIED
    state.going = state.going.held(paused=not go_on)
    return Verdict.ACCEPTED


def _turn(state: CopterState, turn: TurnTo) -> Verdict:
    match state.going:
        case Guided() | Auto():
            state.going = state.going.turned(turn)
        case _:
            pass  # ArduPilot says yes in any mode
    return Verdict.ACCEPTED
