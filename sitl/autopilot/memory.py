"""What a commander remembers, and all that PX4's does."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from sitl.autopilot.charge import Charge
from sitl.autopilot.course import Course
from sitl.autopilot.mission import MissionCourse
from sitl.autopilot.modes import Waypoint
from sitl.autopilot.orbit import OrbitCourse
from sitl.autopilot.payload import Payload
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.plans import MissionRun, PlanItem, Plans
from sitl.signals import Setpoint, Sticks
from sitl.status import Home, Notice, Severity, Shot

__all__ = ["NOTHING", "CommanderState", "PilotState", "notify"]

CENTRED = Sticks(0.0, 0.0, 0.0, 0.0)
"""Nobody's hand is on the sticks."""
_NAN3 = (math.nan, math.nan, math.nan)
NOTHING = Setpoint(_NAN3, _NAN3, _NAN3, math.nan, math.nan)
"""A setpoint that commands no axis."""


@dataclass(slots=True)
class PilotState:
    """What a commander of either dialect remembers. Its parts are values, so that a copy is a snapshot."""

    armed: bool = False
    armed_at_us: int = 0
    flown: bool = False
    standing_since_us: int | None = None
    setpoint: Setpoint = NOTHING
    home: Home | None = None
    home_locked: bool = False
    """Whether it was set by hand: arming does not move it then."""
    plans: Plans = field(default_factory=Plans)
    run: MissionRun = field(default_factory=MissionRun)
    payload: Payload = field(default_factory=Payload)
    shots: tuple[Shot, ...] = ()
    notices: tuple[Notice, ...] = ()


@dataclass(slots=True)
class CommanderState(PilotState):
    """All that PX4's commander remembers."""

    mode: Mode = Mode.HOLD
    failsafe: Mode | None = None
    """What is done instead of `mode`: setpoints are missing, or the position, or charge."""
    leaning_since_us: int | None = None
    upset: bool = False
    """Whether it leans further than PX4's failure detector allows, armed."""
    charge: Charge = Charge.FINE
    for_need: Mode | None = None
    """What the battery's last warning or the geofence asks for, from `for_need_at_us` on; Hold before."""
    for_need_at_us: int = 0
    fence: tuple[PlanItem, ...] = ()
    """The uploaded areas that hold: those that home was in."""
    outside: bool = False
    """Whether it has left its geofence."""
    left_at: Waypoint | None = None
    """Where it has just left it: where it is to hold, once."""
    takeoff_alt_amsl_m: float = math.nan
    speed_mps: float = math.nan
    """What DO_CHANGE_SPEED asked for, until the mode changes; NaN is the usual speed."""
    steering: Setpoint | None = None
    steered_at_us: int | None = None
    sticks: Sticks = CENTRED
    sticks_at_us: int | None = None
    """When the sticks were told of last; None before the first time."""
    ground_heard_us: int | None = None
    """When the ground station's heartbeat came last; None before the first, and once it has been told of as lost."""
    course: Course | MissionCourse | OrbitCourse | None = None
    mission_fault: str | None = None
    """What speaks against flying the mission, as PX4 says it."""

    @property
    def mission_ok(self) -> bool:
        """Whether there is a mission that can be flown."""
        return bool(self.plans.mission) and self.mission_fault is None and self.home is not None

    @property
    def conduct(self) -> Mode:
        """What is really done now."""
        return self.failsafe or self.mode


def notify(state: PilotState, condition: Condition, severity: Severity, text: str) -> None:
    """Keep a line of text to be told."""
    state.notices = (*state.notices, Notice(condition.time_us, severity, text))
