"""PX4's answers to lost setpoints, a lost position and a low battery, for a vehicle without a pilot's sticks.

Source: PX4 v1.17, src/modules/commander/failsafe/failsafe.cpp and framework.cpp, and FlightTaskDescend. A mode
that cannot run without a position falls back as far as Descend, which is told as AUTO_LAND: down at
MPC_LAND_SPEED, level, adrift with the wind, until there is a position again. A battery warning worse than
that at arming acts by COM_LOW_BAT_ACT after COM_FAIL_ACT_T in Hold. Simpler than PX4: its quieter warnings
(low position accuracy, remaining flight time, wind, motors) are not told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from sitl.autopilot.charge import Charge, answer_to, charge_of
from sitl.autopilot.memory import CommanderState
from sitl.autopilot.offboard import mode_after_loss
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.signals import Setpoint
from sitl.status import Severity

__all__ = ["Remark", "call_for", "change_conduct", "descent", "watch_charge"]

Remark = tuple[Severity, str]
_NAN: Final = math.nan
_GRAVITY: Final = (Mode.HOLD, Mode.RETURN, Mode.LAND)


def watch_charge(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float]
) -> list[Remark]:
    """Decide what follows from a battery that has run low; what there is to say of it."""
    charge = charge_of(condition.charge_left, parameters)
    if charge <= state.charge:
        return []
    state.charge = charge
    told = [(Severity.WARNING if charge is Charge.LOW else Severity.CRITICAL, charge.advice)]
    action = answer_to(charge, parameters)
    if action is None or condition.on_ground:
        return told
    delay_s = parameters["COM_FAIL_ACT_T"]
    state.for_need, state.for_need_at_us = action, condition.time_us + round(1e6 * delay_s)
    if delay_s > 0.0 and state.failsafe is None:
        told.append((Severity.CRITICAL, f"Failsafe activated: entering Hold for {delay_s:.0f} seconds"))
    return told


def call_for(state: CommanderState, mode: Mode, now_us: int) -> None:
    """Ask for that mode at once, unless a graver one is asked for."""
    if state.for_need is None or _GRAVITY.index(mode) > _GRAVITY.index(state.for_need):
        state.for_need, state.for_need_at_us = mode, now_us


def change_conduct(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float], *, streamed: bool
) -> list[Remark]:
    """Enter the gravest failsafe that there is reason for, leave it when all are gone; what to say of it."""
    wanted, text = _gravest(state, condition, parameters, streamed=streamed)
    if wanted is state.failsafe:
        return []
    before, state.failsafe = state.conduct, wanted
    if state.conduct is not before:
        state.steering = state.course = None
    return [(Severity.CRITICAL, text)] if text else []


def _gravest(
    state: CommanderState, condition: Condition, parameters: Mapping[str, float], *, streamed: bool
) -> tuple[Mode | None, str]:
    sinking = state.failsafe is Mode.LAND
    if (sinking or not condition.on_ground) and not condition.knows_position:
        return Mode.LAND, "Failsafe activated: Autopilot disengaged, switching to Descend"
    if streamed and state.for_need is None:
        return None, ""
    wanted: list[tuple[Mode, str]] = []
    if not streamed:
        wanted.append((mode_after_loss(state.mode, parameters), "Failsafe activated"))
    if state.for_need is not None:
        waits = condition.time_us < state.for_need_at_us
        wanted.append((Mode.HOLD, "") if waits else (state.for_need, "Failsafe activated"))
    return max(wanted, key=lambda one: _GRAVITY.index(one[0]), default=(None, ""))


def descent(parameters: Mapping[str, float]) -> Setpoint:
    """Down, level, wherever the wind takes it: what can be flown without a position."""
    return Setpoint(
        (_NAN, _NAN, _NAN),
        (_NAN, _NAN, parameters["MPC_LAND_SPEED"]),
        (0.0, 0.0, _NAN),
        _NAN,
        0.0,
    )
