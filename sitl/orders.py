"""What a link may ask of the commander, and what the commander tells. Values only, no wire formats."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import Protocol

from sitl.signals import Estimate, FloatArray, GeoPoint, Setpoint

__all__ = [
    "Arm",
    "Condition",
    "Disarm",
    "FlightStatus",
    "Home",
    "Landed",
    "Mode",
    "Notice",
    "Order",
    "Reposition",
    "Severity",
    "SwitchMode",
    "TakeOff",
    "Verdict",
]


class Mode(Enum):
    """What the vehicle is doing."""

    POSITION = auto()
    HOLD = auto()
    TAKEOFF = auto()
    RETURN = auto()
    LAND = auto()
    OFFBOARD = auto()


class Landed(Enum):
    """Where the vehicle believes to be."""

    ON_GROUND = auto()
    IN_AIR = auto()
    TAKING_OFF = auto()
    LANDING = auto()


class Verdict(Enum):
    """How an order was received."""

    ACCEPTED = auto()
    NOT_NOW = auto()
    DENIED = auto()


class Severity(Enum):
    """How loud a notice is."""

    CRITICAL = auto()
    WARNING = auto()
    INFO = auto()


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
class Reposition:
    """Go there and hold. NaN keeps what is: place, height, heading, or the usual speed."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float
    yaw_ned_rad: float
    speed_mps: float


Order = Arm | Disarm | TakeOff | SwitchMode | Reposition


@dataclass(frozen=True, slots=True)
class Notice:
    """A line of text for whoever listens."""

    time_us: int
    severity: Severity
    text: str


@dataclass(frozen=True, slots=True, eq=False)
class Home:
    """Where the vehicle was armed, or stood when it first knew its place."""

    point: GeoPoint
    position_ned_m: FloatArray
    q_ned_frd: FloatArray


class Condition(Protocol):
    """What the commander sees of its vehicle now. Each look costs something: it looks when it must."""

    @property
    def time_us(self) -> int:
        """Since the start."""

    @property
    def estimate(self) -> Estimate:
        """What the vehicle believes."""

    @property
    def origin(self) -> GeoPoint | None:
        """Where the estimate's frame is anchored, once that is known."""

    @property
    def on_ground(self) -> bool:
        """The land detector's verdict."""


@dataclass(frozen=True, slots=True, eq=False)
class FlightStatus:
    """What the commander says of itself."""

    armed: bool
    mode: Mode
    landed: Landed
    ready: bool
    failsafe: bool
    home: Home | None
    setpoint: Setpoint
