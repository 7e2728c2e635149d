"""ArduCopter's answers to a lost ground station, a low battery, a filter that has lost its place, and a crash.

Source: ArduPilot 4.6, events.cpp, ekf_check.cpp, crash_check.cpp and AP_BattMonitor. Simpler: of the filter's
variances only two count, fixes that are refused in place and in speed, and fixes that are missing. FS_DR_ENABLE
waits for a filter that knows the body's drag, which the default EK3_DRAG_BCOEF_X of 0 does not give it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum
from operator import mul

from sitl.autopilot.copter_memory import CopterState, knows_place, stand_down
from sitl.autopilot.copter_modes import COPTER_MODES
from sitl.autopilot.copter_orders import switch
from sitl.autopilot.memory import notify
from sitl.condition import Condition
from sitl.orders import Mode, Verdict
from sitl.rotation import tilt_rad
from sitl.status import Severity

__all__ = ["LOOK_US", "act", "watch"]

LOOK_US = 100_000
"""The checks run at 10 Hz."""

_EKF_LOOKS = 10
_REFUSED_US = 250_000
"""Two fixes in a row that were not used."""
_ALT_HOLD, _EVEN_STABILIZE = 2, 3
_CRASH_LOOKS, _CRASH_LEAN_RAD, _CRASH_ERROR_RAD = 20, math.radians(15.0), math.radians(30.0)
_CRASH_MPS, _CRASH_MPS2, _CRASH_FILTER = 10.0, 3.0, 0.4
_MAY_GO_ON = {"auto": 1 << 1, "landing": 1 << 3, "pilot": 1 << 4}
"""Bits of FS_OPTIONS."""
_PILOTED = (Mode.STABILIZE, Mode.ALT_HOLD, Mode.LOITER, Mode.POSHOLD)


class _Action(IntEnum):
    """What BATT_FS_LOW_ACT, BATT_FS_CRT_ACT and FENCE_ACTION's kin choose from."""

    NONE = 0
    LAND = 1
    RTL = 2
    SMART_RTL = 3
    SMART_RTL_LAND = 4
    TERMINATE = 5
    DO_LAND_START = 6
    BRAKE_LAND = 7


_WAYS: Mapping[int, tuple[Mode, ...]] = {
    _Action.LAND: (Mode.LAND,),
    _Action.RTL: (Mode.RTL, Mode.LAND),
    _Action.SMART_RTL: (Mode.SMARTRTL, Mode.RTL, Mode.LAND),
    _Action.SMART_RTL_LAND: (Mode.SMARTRTL, Mode.LAND),
    _Action.DO_LAND_START: (Mode.RTL, Mode.LAND),
    _Action.BRAKE_LAND: (Mode.BRAKE, Mode.LAND),
}
"""The modes that an action tries one after another. Simpler than ArduPilot: no landing sequence is looked for in the mission."""
_AFTER_GCS_LOSS: Mapping[int, int] = {
    1: _Action.RTL,
    3: _Action.SMART_RTL,
    4: _Action.SMART_RTL_LAND,
    5: _Action.LAND,
    6: _Action.DO_LAND_START,
    7: _Action.BRAKE_LAND,
}


def watch(state: CopterState, condition: Condition, parameters: Mapping[str, float]) -> None:
    """Look at all that may call for a failsafe, armed."""
    _watch_ground_station(state, condition, parameters)
    _watch_battery(state, condition, parameters)
    _watch_estimate(state, condition, parameters)
    _watch_crash(state, condition, parameters)


def act(state: CopterState, modes: tuple[Mode, ...], condition: Condition) -> None:
    """Change to the first of these modes that can be flown."""
    for mode in modes:
        if switch(state, mode, condition) is Verdict.ACCEPTED:
            return


def _respond(
    state: CopterState, condition: Condition, parameters: Mapping[str, float], name: str, action: int
) -> None:
    """Announce a failsafe and do what its parameter says; on the ground it disarms, in a landing it may go on."""
    if condition.on_ground:
        notify(state, condition, Severity.WARNING, f"{name} Failsafe - Disarming")
        stand_down(state, condition)
        return
    landing = COPTER_MODES[state.mode].lands and int(parameters["FS_OPTIONS"]) & _MAY_GO_ON["landing"]
    if landing and action != _Action.NONE:
        notify(state, condition, Severity.WARNING, f"{name} Failsafe - Continuing Landing")
        return
    notify(state, condition, Severity.WARNING, f"{name} Failsafe")
    if action == _Action.TERMINATE:
        stand_down(state, condition)
    else:
        act(state, _WAYS.get(action, ()), condition)


def _watch_ground_station(state: CopterState, condition: Condition, parameters: Mapping[str, float]) -> None:
    """FS_GCS_ENABLE: only who has been heard can be missed."""
    enabled = _whole(parameters["FS_GCS_ENABLE"])
    if state.gcs_heard_us is None or enabled <= 0:
        return
    lost = condition.time_us - state.gcs_heard_us > 1e6 * parameters["FS_GCS_TIMEOUT"]
    if lost is state.alarms.ground_station:
        return
    state.alarms = state.alarms._replace(ground_station=lost)
    options = _whole(parameters["FS_OPTIONS"])
    if not lost:
        notify(state, condition, Severity.WARNING, "GCS Failsafe Cleared")
    elif not condition.on_ground and state.mode is Mode.AUTO and options & _MAY_GO_ON["auto"]:
        notify(state, condition, Severity.WARNING, "GCS Failsafe - Continuing Auto Mode")
    elif not condition.on_ground and state.mode in _PILOTED and options & _MAY_GO_ON["pilot"]:
        notify(state, condition, Severity.WARNING, "GCS Failsafe - Continuing Pilot Control")
    else:
        _respond(state, condition, parameters, "GCS", _AFTER_GCS_LOSS.get(enabled, _Action.RTL))


def _watch_battery(state: CopterState, condition: Condition, parameters: Mapping[str, float]) -> None:
    """BATT_LOW_ and BATT_CRT_: volts for longer than BATT_LOW_TIMER, or milliampere-hours that are left."""
    alarms, battery, now_us = state.alarms, condition.battery, condition.time_us
    left_mah = parameters["BATT_CAPACITY"] - 1e3 * battery.used_ah
    level, below_since_us = 0, []
    for rank, prefix, since_us in zip((1, 2), ("BATT_LOW", "BATT_CRT"), alarms.below_since_us, strict=True):
        begun_us = now_us if since_us is None else since_us
        below = battery.voltage_v < parameters[f"{prefix}_VOLT"]
        below_since_us.append(begun_us if below else None)
        tired = below and now_us - begun_us > 1e6 * parameters["BATT_LOW_TIMER"]
        if tired or left_mah < parameters[f"{prefix}_MAH"]:
            level = rank
    low_since_us, critical_since_us = below_since_us
    state.alarms = alarms._replace(
        below_since_us=(low_since_us, critical_since_us), battery=max(level, alarms.battery)
    )
    if level <= alarms.battery:
        return
    word = "critical" if level == 2 else "low"
    text = f"Battery 1 is {word} {battery.voltage_v:.2f}V used {1e3 * battery.used_ah:.0f} mAh"
    notify(state, condition, Severity.WARNING, text)
    action = _whole(parameters["BATT_FS_CRT_ACT" if level == 2 else "BATT_FS_LOW_ACT"])
    _respond(state, condition, parameters, "Battery", action)


def _watch_estimate(state: CopterState, condition: Condition, parameters: Mapping[str, float]) -> None:
    """FS_EKF_ACTION: after a second without a place, or with variances over FS_EKF_THRESH."""
    if not parameters["FS_EKF_THRESH"] > 0.0:
        state.alarms = state.alarms._replace(ekf_looks=0, ekf=False)
        return
    alarms = state.alarms
    refused = condition.fix_age_us > _REFUSED_US and condition.gps is not None
    fine = not refused and knows_place(condition)
    looks = max(0, alarms.ekf_looks - 1) if fine else min(_EKF_LOOKS, alarms.ekf_looks + 1)
    state.alarms = alarms._replace(ekf_looks=looks)
    if looks == _EKF_LOOKS and not alarms.ekf_bad:
        state.alarms = state.alarms._replace(ekf_bad=True)
        notify(state, condition, Severity.CRITICAL, "EKF variance")
        _lose_place(state, condition, _whole(parameters["FS_EKF_ACTION"]))
    elif looks == 0 and alarms.ekf_bad:
        if alarms.ekf:
            notify(state, condition, Severity.CRITICAL, "EKF Failsafe Cleared")
        state.alarms = state.alarms._replace(ekf_bad=False, ekf=False)


def _lose_place(state: CopterState, condition: Condition, action: int) -> None:
    if state.mode is Mode.LAND:
        state.blind = True
        return
    if action <= 0 or not (COPTER_MODES[state.mode].needs_place or action == _EVEN_STABILIZE):
        return
    state.alarms = state.alarms._replace(ekf=True)
    mode = Mode.ALT_HOLD if action == _ALT_HOLD else Mode.LAND
    switch(state, mode, condition)
    state.blind = mode is Mode.LAND
    notify(state, condition, Severity.CRITICAL, f"EKF Failsafe: changed to {mode.name} Mode")


def _watch_crash(state: CopterState, condition: Condition, parameters: Mapping[str, float]) -> None:
    """FS_CRASH_CHECK: two seconds far off the attitude that is wanted, without speed or acceleration."""
    if condition.on_ground or not parameters["FS_CRASH_CHECK"]:
        state.alarms = state.alarms._replace(crash_looks=0)
        return
    estimate, smooth = condition.estimate, state.alarms.acceleration_mps2
    smooth += _CRASH_FILTER * (math.hypot(*estimate.acceleration_ned_mps2.tolist()) - smooth)
    error = 0.0
    if tilt_rad(estimate.q_ned_frd) > _CRASH_LEAN_RAD:
        error = _apart_rad(condition.attitude_wanted.tolist(), estimate.q_ned_frd.tolist())
    slow = math.hypot(*estimate.velocity_ned_mps.tolist()) < _CRASH_MPS and smooth < _CRASH_MPS2
    looks = state.alarms.crash_looks + 1 if error > _CRASH_ERROR_RAD and slow else 0
    state.alarms = state.alarms._replace(crash_looks=looks, acceleration_mps2=smooth)
    if looks >= _CRASH_LOOKS:
        text = f"Crash: Disarming: AngErr={math.degrees(error):.0f}>30, Accel={smooth:.1f}<3.0"
        notify(state, condition, Severity.CRITICAL, text)
        stand_down(state, condition)


def _apart_rad(wanted: list[float], q: list[float]) -> float:
    """The angle between two attitudes."""
    return 2.0 * math.acos(min(1.0, abs(sum(map(mul, wanted, q)))))


def _whole(value: float) -> int:
    return int(value) if math.isfinite(value) else 0
