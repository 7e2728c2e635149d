"""All that ArduCopter's commander remembers, and the least of what it does with it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from sitl.autopilot.arming import is_ready
from sitl.autopilot.auto import Auto
from sitl.autopilot.guided import Guided
from sitl.autopilot.memory import NOTHING
from sitl.autopilot.payload import Payload
from sitl.autopilot.trip import Speeds, Trip
from sitl.orders import Condition, Home, Mode, Notice, Severity, Shot, Verdict
from sitl.plans import MissionRun, Plans
from sitl.signals import Setpoint

__all__ = ["PREARM_US", "CopterState", "knows_place", "notify", "refuse", "stand_down"]

PREARM_US = 23_000_000
"""From then on its own checks are content; it knows its place only later."""
_PLACE_US = 41_000_000
"""When "EKF3 IMU0 is using GPS" was seen: arming in GUIDED failed until then."""


@dataclass(slots=True)
class CopterState:
    """All that the commander remembers. Its parts are values, so that a copy is a snapshot."""

    time_us: int = 0
    armed: bool = False
    armed_at_us: int = 0
    flown: bool = False
    standing_since_us: int | None = None
    mode: Mode = Mode.STABILIZE
    going: Guided | Auto | Trip | None = None
    auto_armed: bool = False
    """Whether AUTO may leave the ground: MISSION_START says so, where nobody raises a throttle."""
    failsafe: bool = False
    gcs_heard_us: int | None = None
    told_place: bool = False
    setpoint: Setpoint = NOTHING
    home: Home | None = None
    home_locked: bool = False
    """Whether somebody has said where home is: arming does not move it then."""
    speeds: Speeds = field(default_factory=Speeds)
    plans: Plans = field(default_factory=Plans)
    run: MissionRun = field(default_factory=MissionRun)
    payload: Payload = field(default_factory=Payload)
    shots: tuple[Shot, ...] = ()
    notices: tuple[Notice, ...] = ()


def stand_down(state: CopterState, condition: Condition) -> None:
    """Stop the motors, and forget what was going on."""
    state.armed, state.failsafe, state.going, state.auto_armed = False, False, None, False
    state.setpoint, state.speeds = NOTHING, Speeds()
    state.payload = replace(state.payload, distance_m=0.0, interval_s=0.0, shots_left=0, interest=None)
    notify(state, condition, Severity.INFO, "Disarming motors")


def knows_place(condition: Condition) -> bool:
    """Whether it would fly by its position."""
    return condition.time_us >= _PLACE_US and is_ready(condition)


def refuse(state: CopterState, condition: Condition, text: str) -> Verdict:
    """No, and why."""
    notify(state, condition, Severity.CRITICAL, text)
    return Verdict.NOT_NOW


def notify(state: CopterState, condition: Condition, severity: Severity, text: str) -> None:
    """Keep a line of text to be told."""
    state.notices = (*state.notices, Notice(condition.time_us, severity, text))
