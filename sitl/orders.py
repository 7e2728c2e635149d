"""What a link may ask of the commander, and how that was received. Values only, no wire formats."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from sitl.plans import PlanItem, PlanKind
from sitl.signals import GeoPoint

__all__ = [
    "Arm",
    "ChangeSpeed",
    "Disarm",
    "GoToItem",
    "Mode",
    "Orbit",
    "Order",
    "Pause",
    "Reposition",
    "SetHome",
    "SetOutput",
    "StartMission",
    "SwitchMode",
    "TakeOff",
    "TakePlan",
    "TurnTo",
    "UsePayload",
    "Verdict",
    "WishMode",
]


class Mode(Enum):
    """What the vehicle is doing: PX4's modes, then ArduCopter's. Both have LAND."""

    POSITION = auto()
    HOLD = auto()
    TAKEOFF = auto()
    MISSION = auto()
    RETURN = auto()
    LAND = auto()
    OFFBOARD = auto()
    ORBIT = auto()

    STABILIZE = auto()
    ALT_HOLD = auto()
    AUTO = auto()
    GUIDED = auto()
    LOITER = auto()
    RTL = auto()
    POSHOLD = auto()
    BRAKE = auto()
    SMARTRTL = auto()
    CIRCLE = auto()


class Verdict(Enum):
    """How an order was received."""

    ACCEPTED = auto()
    NOT_NOW = auto()
    DENIED = auto()


@dataclass(frozen=True, slots=True)
class Arm:
    """Let the motors turn; `force` skips the checks."""

    force: bool = False


@dataclass(frozen=True, slots=True)
class Disarm:
    """Stop the motors; `force` does so in the air."""

    force: bool = False


@dataclass(frozen=True, slots=True)
class TakeOff:
    """Climb over the place where the vehicle stands; NaN asks for the usual height."""

    alt_amsl_m: float


@dataclass(frozen=True, slots=True)
class SwitchMode:
    """Change what the vehicle is doing."""

    mode: Mode


@dataclass(frozen=True, slots=True)
class WishMode:
    """Change to a mode of that name, which the autopilot knows and cannot enter."""

    name: str


@dataclass(frozen=True, slots=True)
class Reposition:
    """Go there and hold. NaN keeps what is: place, height, heading, or the usual speed."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float
    yaw_ned_rad: float
    speed_mps: float


@dataclass(frozen=True, slots=True)
class TakePlan:
    """Keep these items instead of those of the same kind; a mission's current item is `current`.

    Without `restart`, which ArduCopter alone knows, they are the old ones but for one, and a mission that runs goes on.
    """

    kind: PlanKind
    items: tuple[PlanItem, ...]
    current: int = 0
    restart: bool = True


@dataclass(frozen=True, slots=True)
class GoToItem:
    """Go on with that item of the mission."""

    seq: int


@dataclass(frozen=True, slots=True)
class StartMission:
    """Fly the mission, and arm for it."""


@dataclass(frozen=True, slots=True)
class UsePayload:
    """Do with camera or gimbal what that item of a mission would do."""

    item: PlanItem


@dataclass(frozen=True, slots=True)
class SetHome:
    """Home is there; without a point, here."""

    point: GeoPoint | None


@dataclass(frozen=True, slots=True)
class ChangeSpeed:
    """Fly by itself so fast from now on; `axis` is MAVLink's SPEED_TYPE: 1 ground speed, 2 climb, 3 descent."""

    axis: int
    speed_mps: float


@dataclass(frozen=True, slots=True)
class Orbit:
    """Circle round a place, clockwise for a positive radius. NaN leaves it as it is, or to the autopilot.

    `yaw_behaviour` is MAVLink's ORBIT_YAW_BEHAVIOUR.
    """

    radius_m: float
    speed_mps: float
    yaw_behaviour: float
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


@dataclass(frozen=True, slots=True)
class TurnTo:
    """Turn the nose: to a heading, or by an angle; `sign` is 1 clockwise, -1 the other way, 0 the shorter."""

    yaw_rad: float
    rate_radps: float
    sign: int
    relative: bool


@dataclass(frozen=True, slots=True)
class SetOutput:
    """Put a pulse of so many microseconds on that servo output, counted from 1."""

    number: int
    pwm_us: int


@dataclass(frozen=True, slots=True)
class Pause:
    """Come to rest on the way, or with `go_on` fly on."""

    go_on: bool


Order = (
    ChangeSpeed
    | Orbit
    | Arm
    | Disarm
    | TakeOff
    | SwitchMode
    | WishMode
    | Reposition
    | TakePlan
    | GoToItem
    | StartMission
    | UsePayload
    | SetHome
    | SetOutput
    | Pause
    | TurnTo
)
