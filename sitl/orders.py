"""What a link may ask of the commander, and what the commander tells. Values only, no wire formats."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple, Protocol

from sitl.plans import MissionRun, PlanItem, PlanKind, Plans
from sitl.signals import Estimate, FloatArray, GeoPoint, GpsSample, Setpoint

__all__ = [
    "Arm",
    "Battery",
    "ChangeSpeed",
    "Condition",
    "Disarm",
    "FenceStatus",
    "FlightStatus",
    "GoToItem",
    "Home",
    "Landed",
    "Mode",
    "Notice",
    "Orbit",
    "OrbitRun",
    "Order",
    "Pause",
    "PayloadStatus",
    "Reposition",
    "SetHome",
    "SetOutput",
    "Severity",
    "Shot",
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
    NOTICE = auto()
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


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A picture: when, where (as estimated) and how the camera was held."""

    time_us: int
    index: int
    point: GeoPoint
    height_home_m: float
    q_ned_camera: FloatArray


@dataclass(frozen=True, slots=True)
class Notice:
    """A line of text for whoever listens."""

    time_us: int
    severity: Severity
    text: str


@dataclass(frozen=True, slots=True)
class OrbitRun:
    """An orbit that is flown: its centre (as high as the circle), its radius (positive clockwise), its yaw."""

    centre: GeoPoint
    radius_m: float
    yaw_behaviour: int


@dataclass(frozen=True, slots=True, eq=False)
class Home:
    """Where the vehicle was armed, or stood when it first knew its place."""

    point: GeoPoint
    position_ned_m: FloatArray
    q_ned_frd: FloatArray


class Battery(Protocol):
    """The pack as its monitor sees it."""

    @property
    def voltage_v(self) -> float:
        """At the terminals."""

    @property
    def current_a(self) -> float:
        """Drawn now."""

    @property
    def used_ah(self) -> float:
        """Drawn since the start."""

    @property
    def remaining(self) -> float:
        """What is left, 0…1."""


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
    def knows_position(self) -> bool:
        """Whether a position may be flown to: the estimate's `position_ok`."""

    @property
    def charge_left(self) -> float:
        """What is left in the battery, 0…1."""

    @property
    def on_ground(self) -> bool:
        """The land detector's verdict."""

    @property
    def battery(self) -> Battery:
        """The pack."""

    @property
    def gps(self) -> GpsSample | None:
        """The fix that came last; None while there are none."""

    @property
    def fix_age_us(self) -> int:
        """How long ago the filter used a fix."""

    @property
    def attitude_wanted(self) -> FloatArray:
        """What the cascade steers to, `q_ned_frd`."""


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
