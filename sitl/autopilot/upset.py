"""PX4's failure detector, as far as it looks at the attitude: who has tipped over is told of, and early in a flight stopped.

Source: PX4 v1.17, FailureDetector.cpp and failsafe.cpp. Within COM_LKDOWN_TKO of the motors' start it disarms; later it only
warns, unless CBRK_FLIGHTTERM lets it end the flight, which disarms here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from sitl.autopilot.memory import CommanderState
from sitl.condition import Condition
from sitl.rotation import euler_rad

__all__ = ["ends_flight", "leaning_axis", "watch_attitude"]

_BROKEN_CIRCUIT = 121212


def leaning_axis(condition: Condition, parameters: Mapping[str, float]) -> str:
    """The axis about which it leans further than FD_FAIL_R or FD_FAIL_P; none is an empty text. Zero looks at none."""
    roll_rad, pitch_rad, _ = euler_rad(condition.estimate.q_ned_frd)
    for axis, name, angle_rad in (("roll", "FD_FAIL_R", roll_rad), ("pitch", "FD_FAIL_P", pitch_rad)):
        if 0.0 < parameters[name] < math.degrees(abs(angle_rad)):
            return axis
    return ""


def watch_attitude(state: CommanderState, condition: Condition, parameters: Mapping[str, float]) -> str:
    """Note since when it leans too far, in `state.upset` whether for too long; what there is to say of it."""
    axis = leaning_axis(condition, parameters)
    if not axis:
        state.leaning_since_us, state.upset = None, False
        return ""
    if state.leaning_since_us is None:
        state.leaning_since_us = condition.time_us
    limit_s = parameters["FD_FAIL_R_TTRI" if axis == "roll" else "FD_FAIL_P_TTRI"]
    if state.upset or condition.time_us - state.leaning_since_us < 1e6 * limit_s:
        return ""
    state.upset = True
    return f"Preflight Fail: Attitude failure ({axis})"


def ends_flight(state: CommanderState, condition: Condition, parameters: Mapping[str, float]) -> bool:
    """Whether the motors of an upset vehicle are stopped."""
    early_s = parameters["COM_LKDOWN_TKO"] + parameters["COM_SPOOLUP_TIME"]
    early = condition.time_us < state.armed_at_us + 1e6 * early_s
    return state.upset and (early or parameters["CBRK_FLIGHTTERM"] != _BROKEN_CIRCUIT)
