"""What the commander of either dialect does with its payload: it hands on orders, and takes the pictures that are due."""

from __future__ import annotations

from dataclasses import replace

from sitl.autopilot.memory import PilotState
from sitl.condition import Condition
from sitl.orders import Verdict
from sitl.plans import PlanItem

__all__ = ["shoot", "use_payload"]


def use_payload(state: PilotState, item: PlanItem) -> Verdict:
    """Carry out a command for camera or gimbal at once; triggers that waited for the mission go on."""
    if state.payload.is_busy_for(item):
        return Verdict.NOT_NOW
    state.payload = replace(state.payload.told(item, state.home), paused=False)
    return Verdict.ACCEPTED


def shoot(state: PilotState, condition: Condition) -> None:
    """Take the picture that is due now, if any."""
    before = state.payload.shots
    state.payload = state.payload.look(condition)
    if state.payload.shots > before:
        state.shots = (*state.shots, state.payload.shot(condition, state.home))
