"""What the commander does with plans: takes them, judges them, begins and ends their mission."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from sitl.autopilot.geofence import enforce, waypoint_outside
from sitl.autopilot.itinerary import remarks, why_not_fly
from sitl.autopilot.memory import CommanderState
from sitl.autopilot.mission import MissionCourse
from sitl.condition import Condition
from sitl.orders import Mode, TakePlan
from sitl.plans import MissionRun, PlanKind
from sitl.status import Severity

__all__ = ["end_mission", "judge_mission", "leave_mission", "stand_down_mission", "take_plan"]

Remarks = list[tuple[Severity, str]]


def take_plan(
    state: CommanderState, order: TakePlan, condition: Condition, parameters: Mapping[str, float]
) -> Remarks:
    """Keep the plan, and say what there is to say of it. The same mission again changes nothing.

    A fence is held against the mission that is there.
    """
    before = state.plans.of(order.kind)
    if order.kind is PlanKind.MISSION and order.items and repr(before) == repr(order.items):
        return []
    state.plans = state.plans.with_items(order.kind, order.items)
    if order.kind is PlanKind.RALLY:
        return []
    if order.kind is PlanKind.FENCE:
        return [*enforce(state, condition, parameters), *judge_mission(state, condition, parameters)]
    state.run, state.mission_fault = MissionRun(seq=max(0, order.current)), None
    if state.mode is Mode.MISSION:
        state.course = None
    told = judge_mission(state, condition, parameters)
    if told or state.home is None or condition.origin is None:
        return told
    warnings = remarks(order.items, condition.origin, state.home, parameters)
    return [(Severity.WARNING, text) for text in warnings]


def judge_mission(state: CommanderState, condition: Condition, parameters: Mapping[str, float]) -> Remarks:
    """Whether the mission can be flown, inside the fence as it is now; what to say where that has changed.

    One that is being flown and cannot be flown any more is left.
    """
    items, before = state.plans.mission, state.mission_fault
    unflyable = why_not_fly(items, parameters) if items else None
    state.mission_fault = (
        waypoint_outside(state, condition, parameters)
        if unflyable is None
        else f"Mission rejected: {unflyable}"
    )
    if state.armed and state.mode is Mode.MISSION and not state.mission_ok:
        leave_mission(state)
        state.mode = Mode.HOLD
    if state.mission_fault in (None, before):
        return []
    return [(Severity.CRITICAL, state.mission_fault)]


def leave_mission(state: CommanderState) -> None:
    """Pause the mission if it is being flown: its camera waits."""
    if state.mode is Mode.MISSION:
        state.payload, state.course = replace(state.payload, paused=True), None


def end_mission(state: CommanderState, then: Mode) -> None:
    """Go over to what follows the mission. The camera stops."""
    course = state.course
    state.payload = state.payload.at_rest()
    state.course = course.ending() if isinstance(course, MissionCourse) and then is Mode.HOLD else None
    state.mode = then


def stand_down_mission(state: CommanderState) -> None:
    """Disarmed: a mission that had come to its last item begins anew next time."""
    if state.run.seq + 1 >= len(state.plans.mission):
        state.run = MissionRun()
        state.payload = state.payload.at_rest()
