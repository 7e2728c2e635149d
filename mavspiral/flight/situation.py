"""All that is known while a flight goes on: what the rows of the course read, and what they settle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from mavspiral.arrays import FloatArray
from mavspiral.flight.flight_log import Event
from mavspiral.flight.follower import Follower
from mavspiral.flight.link import Link
from mavspiral.flight.messages import Command, Origin, Result, Triple
from mavspiral.flight.outcome import SessionConfig
from mavspiral.flight.profile import Profile
from mavspiral.flight.reference import Reference
from mavspiral.flight.telemetry import TelemetryRequest
from mavspiral.flight.vehicle import Vehicle
from mavspiral.flight.vehicle_clock import VehicleClock
from mavspiral.frames import LocalFrame, RigidMap
from mavspiral.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from mavspiral.flight.alignment import Alignment

__all__ = ["Route", "Situation", "WayHome"]

_SAGS_M = 0.5
"""What a Return loses of its height on the way: the bundled ArduCopter 0.1 m, an estimate that wanders more."""

Route = Callable[[FloatArray], Trajectory]
"""The trajectory for a home at `(3,)` in the plan's ENU, or a refusal."""

WayHome = Callable[[FloatArray, FloatArray, float], Trajectory]
"""The trajectory from one place to another, `(3,)` in the plan's ENU, with a yaw_enu_rad to keep, or a refusal."""


@dataclass(slots=True)
class Situation:
    """The session's blackboard.

    Args:
        now_us: the clock that drives us.
        entered_us: when the present state began.
        heard_us: when the vehicle last said anything.
        local_us: when it last told its position.
        parameter_us: when it last told a parameter that it had not told before.
        awaited: the autopilots that it may be, in words.
        overheard: MAV_AUTOPILOT of others that were heard instead.
        other_systems: who was heard that is not the system which is to be flown.
        no_copters: MAV_TYPE of what was heard with such an autopilot and is no multicopter.
        origin: the origin that `to_vehicle` was made from.
        begins_enu_m: where the trajectory does, above home.
        follower: what is being flown, from pre-stream on.
        consented: whether the config's question was answered with yes.
        alignment: where the vehicle is said to stand, and what came of it; None where the plan lies as it is.
        borrowed: of each parameter that is set for this flight the vehicle's own value, and the one that it is given.
    """

    route: Route
    way_home: WayHome | None
    frame: LocalFrame
    config: SessionConfig
    profile: Profile
    link: Link
    telemetry: TelemetryRequest
    now_us: int = 0
    entered_us: int = 0
    heard_us: int = 0
    local_us: int = 0
    parameter_us: int = 0
    vehicle: Vehicle = field(default_factory=Vehicle)
    clock: VehicleClock = field(default_factory=VehicleClock)
    events: list[Event] = field(default_factory=list)
    origin: Origin | None = None
    to_vehicle: RigidMap | None = None
    trajectory: Trajectory | None = None
    begins_enu_m: Triple = (math.nan, math.nan, math.nan)
    leg_begins_s: tuple[float, ...] = ()
    inspection_ends_s: float = math.nan
    awaited: str = ""
    overheard: set[int] = field(default_factory=set)
    other_systems: set[int] = field(default_factory=set)
    no_copters: set[int] = field(default_factory=set)
    reference: Reference | None = None
    follower: Follower | None = None
    consented: bool = False
    alignment: Alignment | None = None
    borrowed: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def elapsed_s(self) -> float:
        """Time in the present state."""
        return (self.now_us - self.entered_us) * 1e-6

    @property
    def path_t_s(self) -> float:
        """Path time on the trajectory; NaN while not on it."""
        on_it = self.follower is not None and self.follower.reference is self.reference
        return self.follower.pace.path_t_s if on_it and self.follower else math.nan

    @property
    def safe_return_m(self) -> float:
        """How high over its home, where it stands now, its own Return must fly: a little more, for no Return is level."""
        assert self.to_vehicle is not None
        home_enu_m = self.to_vehicle.position_enu_m(self.vehicle.position_ned_m)
        return self.config.safe_height_enu_m + _SAGS_M - float(home_enu_m[2])

    def tell(self, severity: str, text: str) -> None:
        """Add to the events."""
        self.events.append(Event(self.now_us, severity, text))

    def tell_once(self, severity: str, text: str) -> None:
        """Add to the events what is not among them yet."""
        if all((event.severity, event.text) != (severity, text) for event in self.events):
            self.tell(severity, text)

    def answer(self, command: Command) -> str:
        """How the vehicle last answered `command`, in words."""
        result = self.vehicle.results.get(command)
        if result is None:
            return "no answer"
        return f"its answer: {Result(result).name}" if result in set(Result) else f"its answer: {result}"
