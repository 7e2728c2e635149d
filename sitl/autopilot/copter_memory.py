"""All that ArduCopter's commander remembers, and the least of what it does with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from sitl.autopilot.angled import Angled
from sitl.autopilot.auto import Auto
from sitl.autopilot.circle import Circle
from sitl.autopilot.copter_modes import COPTER_MODES
from sitl.autopilot.guided import Guided
from sitl.autopilot.hands import Led
from sitl.autopilot.memory import NOTHING, PilotState, notify
from sitl.autopilot.radio import Radio
from sitl.autopilot.smart import Trail
from sitl.autopilot.trip import Speeds, Trip
from sitl.condition import Condition
from sitl.orders import Mode, Verdict
from sitl.signals import Sticks
from sitl.status import Severity

__all__ = [
    "PLACE_US",
    "PREARM_US",
    "Alarms",
    "CopterState",
    "FenceRun",
    "knows_place",
    "refuse",
    "stand_down",
    "sticks_of",
    "trusts_place",
]

PREARM_US = 23_000_000
"""From then on its own checks are content; it knows its place only later."""
PLACE_US = 41_000_000
"""When "EKF3 IMU0 is using GPS" was seen: arming in GUIDED failed until then."""


_LOST_US = 7_000_000
"""So long without a fix that the filter would use, and it has no place: EKF3's posRetryTimeNoVel."""


class Alarms(NamedTuple):
    """Which failsafes have begun, and how far the checks have come. `battery` is 1 low, 2 critical."""

    ground_station: bool = False
    battery: int = 0
    below_since_us: tuple[int | None, int | None] = (None, None)
    ekf_looks: int = 0
    ekf_bad: bool = False
    ekf: bool = False
    crash_looks: int = 0
    acceleration_mps2: float = 0.0

    @property
    def any(self) -> bool:
        """Whether the vehicle is in one of them."""
        return self.ground_station or self.battery > 0 or self.ekf


@dataclass(frozen=True, slots=True)
class FenceRun:
    """Which parts of the fence are breached, how often that began, and what began last."""

    breached: int = 0
    again: tuple[tuple[int, float], ...] = ()
    count: int = 0
    last: int = 0
    time_us: int = 0

    def again_m(self, part: int) -> float:
        """How far beyond that part counts as a breach anew."""
        return dict(self.again).get(part, 0.0) if self.breached & part else 0.0

    def seen(self, breached: int, new: int, again: Mapping[int, float], now_us: int) -> FenceRun:
        """After a look: these parts are breached, `new` of them newly."""
        kept = tuple(sorted({**dict(self.again), **again}.items()))
        if not new:
            return replace(self, breached=breached, again=kept)
        return FenceRun(breached, kept, self.count + 1, new & -new, now_us)


@dataclass(slots=True)
class CopterState(PilotState):
    """All that ArduCopter's commander remembers."""

    mode: Mode = Mode.STABILIZE
    going: Guided | Angled | Auto | Circle | Trip | Led | None = None
    auto_armed: bool = False
    """Whether AUTO may leave the ground: MISSION_START says so, where nobody raises a throttle."""
    alarms: Alarms = field(default_factory=Alarms)
    fence: FenceRun = FenceRun()
    low_fence: bool = False
    """Whether the least height is watched: since the flight first was above it."""
    blind: bool = False
    """Whether LAND goes down level, without a position."""
    touching_since_us: int | None = None
    outputs: tuple[tuple[int, int], ...] = ()
    trail: Trail = field(default_factory=Trail)
    gcs_heard_us: int | None = None
    told_place: bool = False
    speeds: Speeds = field(default_factory=Speeds)
    radio: Radio = field(default_factory=Radio)


def stand_down(state: CopterState, condition: Condition) -> None:
    """Stop the motors, and forget what was going on."""
    state.armed, state.going, state.auto_armed, state.blind = False, None, False, False
    state.alarms = Alarms(ground_station=state.alarms.ground_station, battery=state.alarms.battery)
    state.fence, state.low_fence, state.trail = FenceRun(count=state.fence.count), False, Trail()
    state.setpoint, state.speeds = NOTHING, Speeds()
    state.payload = state.payload.at_rest()
    notify(state, condition, Severity.INFO, "Disarming motors")


def sticks_of(state: CopterState, now_us: int, parameters: Mapping[str, float]) -> Sticks | None:
    """The sticks that lead it; None where nobody holds one, or in a mode that does not obey them."""
    return state.radio.sticks(now_us, parameters) if COPTER_MODES[state.mode].by_hand else None


def knows_place(condition: Condition) -> bool:
    """Whether it would fly by its position."""
    if condition.time_us < PLACE_US or condition.origin is None:
        return False
    return condition.fix_age_us <= _LOST_US


def trusts_place(state: CopterState, condition: Condition) -> bool:
    """Whether it flies by its position now: not while the EKF failsafe lasts, whatever the filter says (Copter::position_ok)."""
    return not state.alarms.ekf_bad and knows_place(condition)


def refuse(state: CopterState, condition: Condition, text: str) -> Verdict:
    """No, and why."""
    notify(state, condition, Severity.CRITICAL, text)
    return Verdict.NOT_NOW
