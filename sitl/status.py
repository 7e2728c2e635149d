"""What the commander tells of itself and its flight. Values only, no wire formats."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

from sitl.orders import Mode
from sitl.plans import MissionRun, Plans
from sitl.signals import FloatArray, GeoPoint, Setpoint

__all__ = [
    "FenceStatus",
    "FlightStatus",
    "Home",
    "Landed",
    "Notice",
    "OrbitRun",
    "PayloadStatus",
    "Severity",
    "Shot",
]


class Landed(Enum):
    """Where the vehicle believes to be."""

    ON_GROUND = auto()
    IN_AIR = auto()
    TAKING_OFF = auto()
    LANDING = auto()


class Severity(Enum):
    """How loud a notice is."""

    CRITICAL = auto()
    WARNING = auto()
    NOTICE = auto()
    INFO = auto()


@dataclass(frozen=True, slots=True)
class Notice:
    """A line of text for whoever listens."""

    time_us: int
    severity: Severity
    text: str


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A picture: when, where (as estimated) and how the camera was held."""

    time_us: int
    index: int
    point: GeoPoint
    height_home_m: float
    q_ned_camera: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Home:
    """Where the vehicle was armed, or stood when it first knew its place."""

    point: GeoPoint
    position_ned_m: FloatArray
    q_ned_frd: FloatArray


@dataclass(frozen=True, slots=True)
class OrbitRun:
    """An orbit that is flown: its centre (as high as the circle), its radius (positive clockwise), its yaw."""

    centre: GeoPoint
    radius_m: float
    yaw_behaviour: int


class PayloadStatus(NamedTuple):
    """What camera and gimbal are at. `controller` is the system and component that the gimbal listens to."""

    shots: int = 0
    interval_s: float = 0.0
    gimbal_pitch_rad: float = 0.0
    gimbal_yaw_rad: float = 0.0
    controller: tuple[int, int] = (0, 0)


_NO_PAYLOAD = PayloadStatus()


@dataclass(frozen=True, slots=True)
class FenceStatus:
    """Parts of the fence as bits: max height 1, circle 2, areas 4, min height 8. `last` began to be breached at `time_us`."""

    watched: int = 0
    breached: int = 0
    count: int = 0
    last: int = 0
    time_us: int = 0


class FlightStatus(NamedTuple):
    """What the commander says of itself."""

    armed: bool
    mode: Mode
    landed: Landed
    ready: bool
    failsafe: bool
    home: Home | None
    setpoint: Setpoint
    plans: Plans
    run: MissionRun
    mission_ok: bool
    orbit: OrbitRun | None = None
    payload: PayloadStatus = _NO_PAYLOAD
    knows_place: bool = True
    """Whether it would fly by its position now."""
    fence: FenceStatus = FenceStatus()
    outputs: tuple[tuple[int, int], ...] = ()
    """What has been put on servo outputs: number and pulse in microseconds."""
    channels: tuple[tuple[int, int], ...] = ()
    """What a ground station puts on a radio's channels: number and pulse in microseconds."""
    goal_ned_m: tuple[float, float, float] | None = None
    """The place that is flown to; None where there is none, as while a velocity is followed."""
