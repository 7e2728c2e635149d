"""ArduCopter's answer when it leaves its fence.

Source: ArduPilot 4.6, ArduCopter/fence.cpp. A breach counts once, and again each 20 m further out. Simpler: FENCE_AUTOENABLE and
FENCE_OPTIONS are not obeyed, and nothing slows down before a fence.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from sitl.autopilot.copter_failsafe import act
from sitl.autopilot.copter_memory import CopterState, knows_place, stand_down
from sitl.autopilot.fence import CIRCLE, HIGH, LOW, POLYGON, beyond, fence_parts
from sitl.autopilot.memory import notify
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.status import Severity

__all__ = ["watch_fence"]

_NAMES = {HIGH: "Max Alt", CIRCLE: "Circle", POLYGON: "Polygon", LOW: "Min Alt"}
_AGAIN_M, _GIVE_UP_M = 20.0, 100.0
_WAYS: Mapping[int, tuple[Mode, ...]] = {
    1: (Mode.RTL, Mode.LAND),
    2: (Mode.LAND,),
    3: (Mode.SMARTRTL, Mode.RTL, Mode.LAND),
    4: (Mode.BRAKE, Mode.LAND),
    5: (Mode.SMARTRTL, Mode.LAND),
}


def watch_fence(state: CopterState, condition: Condition, parameters: Mapping[str, float]) -> None:
    """Look whether a part has been left since the last time, and do what FENCE_ACTION says."""
    fence, parts = state.fence, fence_parts(state, parameters)
    if not parts or not knows_place(condition):
        if fence.breached:
            state.fence = replace(fence, breached=0)
        return
    here = condition.estimate.position_ned_m.tolist()
    beyond_m = beyond(state, condition, parameters, complex(here[0], here[1]), here[2])
    height_m = 0.0 if state.home is None else float(state.home.position_ned_m[2]) - here[2]
    state.low_fence |= height_m > parameters["FENCE_ALT_MIN"] + parameters["FENCE_MARGIN"]
    breached = sum(part for part, metres in beyond_m.items() if metres >= 0.0)
    farther = {part: m for part, m in beyond_m.items() if breached & part and m >= fence.again_m(part)}
    new = sum(part for part in farther if part != POLYGON or not fence.breached & part)
    again = {part: m + _AGAIN_M for part, m in farther.items()}
    state.fence = fence.seen(breached, new, again, condition.time_us)
    if not new:
        if fence.breached and not breached and not condition.on_ground:
            notify(state, condition, Severity.NOTICE, "Fence breach cleared")
        return
    if condition.on_ground:
        if int(parameters["FENCE_ACTION"]):
            stand_down(state, condition)
        return
    notify(state, condition, Severity.NOTICE, f"{_named(new)} breached")
    action = int(parameters["FENCE_ACTION"])
    if action <= 0:
        return
    far = max(metres for part, metres in beyond_m.items() if new & part) > _GIVE_UP_M
    act(state, (Mode.LAND,) if far else _WAYS.get(action, _WAYS[1]), condition)


def _named(parts: int) -> str:
    """As "Max Alt and Circle fences"."""
    names = [name for part, name in _NAMES.items() if parts & part]
    listed = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
    return f"{listed} fence{'s' * (len(names) > 1)}"
