"""What crosses the link, as small values in SI units; the numbers of MAVLink's common dialect that we use.

Only `link` turns these into bytes and back. Local positions are north, east, down from the vehicle's EKF
origin. The enumerations carry MAVLink's own names and are tested against pymavlink's dialect.
"""

from __future__ import annotations

import struct
from enum import IntEnum, IntFlag
from typing import NamedTuple

from mavspiral.flight.mission_messages import MissionAck, MissionCount, MissionItem, MissionRequest

__all__ = [
    "Attitude",
    "AutopilotVersion",
    "Command",
    "CommandAck",
    "ExtendedSysState",
    "GlobalPosition",
    "GpsFix",
    "Heartbeat",
    "Home",
    "ImageCaptured",
    "LandedState",
    "LocalPosition",
    "Message",
    "MessageId",
    "Origin",
    "ParamValue",
    "Result",
    "Setpoint",
    "StatusText",
    "SysStatus",
    "SystemStatus",
    "Target",
    "TypeMask",
    "displaced",
    "raw_of",
]

Triple = tuple[float, float, float]
Setpoint = tuple[float, float, float, float, float, float, float, float, float, float, float]
"""A `Target` in its order on the wire: position, velocity and acceleration (north, east, down), yaw, yaw rate."""


def displaced(setpoint: Setpoint, by_ned_m: Triple) -> Setpoint:
    """The same motion elsewhere."""
    (north_m, east_m, down_m, *motion), (n, e, d) = setpoint, by_ned_m
    vn, ve, vd, an, ae, ad, yaw, yaw_rate = motion
    return north_m + n, east_m + e, down_m + d, vn, ve, vd, an, ae, ad, yaw, yaw_rate


class MessageId(IntEnum):
    """MAVLINK_MSG_ID_*."""

    HEARTBEAT = 0
    SYS_STATUS = 1
    PARAM_VALUE = 22
    GPS_RAW_INT = 24
    ATTITUDE = 30
    LOCAL_POSITION_NED = 32
    GLOBAL_POSITION_INT = 33
    MISSION_CURRENT = 42
    GPS_GLOBAL_ORIGIN = 49
    COMMAND_ACK = 77
    ATTITUDE_TARGET = 83
    SET_POSITION_TARGET_LOCAL_NED = 84
    POSITION_TARGET_LOCAL_NED = 85
    POSITION_TARGET_GLOBAL_INT = 87
    TIMESYNC = 111
    AUTOPILOT_VERSION = 148
    HOME_POSITION = 242
    EXTENDED_SYS_STATE = 245
    STATUSTEXT = 253
    CAMERA_IMAGE_CAPTURED = 263


class Command(IntEnum):
    """MAV_CMD_*."""

    NAV_TAKEOFF = 22
    DO_SET_MODE = 176
    DO_DIGICAM_CONTROL = 203
    DO_MOUNT_CONTROL = 205
    DO_SET_CAM_TRIGG_DIST = 206
    MISSION_START = 300
    COMPONENT_ARM_DISARM = 400
    SET_MESSAGE_INTERVAL = 511
    REQUEST_MESSAGE = 512
    DO_GIMBAL_MANAGER_PITCHYAW = 1000
    IMAGE_START_CAPTURE = 2000


class Result(IntEnum):
    """MAV_RESULT_*."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5


class SystemStatus(IntEnum):
    """MAV_STATE_*."""

    BOOT = 1
    CALIBRATING = 2
    STANDBY = 3
    ACTIVE = 4
    CRITICAL = 5
    EMERGENCY = 6


class LandedState(IntEnum):
    """MAV_LANDED_STATE_*."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKEOFF = 3
    LANDING = 4


class TypeMask(IntFlag):
    """POSITION_TARGET_TYPEMASK_*: a set bit means "ignore this"; none set commands all of a `Target`."""

    X_IGNORE = 1
    Y_IGNORE = 2
    Z_IGNORE = 4
    VX_IGNORE = 8
    VY_IGNORE = 16
    VZ_IGNORE = 32
    AX_IGNORE = 64
    AY_IGNORE = 128
    AZ_IGNORE = 256
    FORCE_SET = 512
    YAW_IGNORE = 1024
    YAW_RATE_IGNORE = 2048


class Target(NamedTuple):
    """One setpoint, in the vehicle's NED frame."""

    position_ned_m: Triple
    velocity_ned_mps: Triple
    acceleration_ned_mps2: Triple
    yaw_ned_rad: float
    yaw_rate_ned_radps: float

    @classmethod
    def of(cls, setpoint: Setpoint) -> Target:
        """The same by name."""
        return cls(setpoint[0:3], setpoint[3:6], setpoint[6:9], setpoint[9], setpoint[10])


# MAV_TYPE; 0 is an ArduPilot whose frame nobody has set.
_COPTERS = frozenset({0, 2, 3, 4, 13, 14, 15, 29, 35, 43})
_BESIDE = frozenset({6, 18, 26, 27, 30})


class Heartbeat(NamedTuple):
    """Who speaks, what it is (MAV_TYPE), in which mode."""

    system_id: int
    component_id: int
    autopilot: int
    armed: bool
    custom_mode: int
    system_status: int
    vehicle_type: int

    @property
    def is_copter(self) -> bool:
        """Whether it can hover where it is told to: no gimbal, rover or aeroplane with such an autopilot."""
        return self.vehicle_type in _COPTERS

    @property
    def is_vehicle(self) -> bool:
        """Whether it is one that moves; no ground station, companion, gimbal, ADS-B receiver or camera."""
        return self.vehicle_type not in _BESIDE


class LocalPosition(NamedTuple):
    """LOCAL_POSITION_NED: the estimate, in its order on the wire."""

    time_boot_ms: int
    north_m: float
    east_m: float
    down_m: float
    north_mps: float
    east_mps: float
    down_mps: float


class Attitude(NamedTuple):
    """ATTITUDE, in its order on the wire."""

    time_boot_ms: int
    roll_rad: float
    pitch_rad: float
    yaw_ned_rad: float
    roll_rate_radps: float
    pitch_rate_radps: float
    yaw_rate_radps: float


class GlobalPosition(NamedTuple):
    """GLOBAL_POSITION_INT."""

    time_boot_ms: int
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


class GpsFix(NamedTuple):
    """GPS_RAW_INT: what the receiver says; `fix_type` 3 and more are fixes in space."""

    fix_type: int
    lat_deg: float
    lon_deg: float


class Origin(NamedTuple):
    """GPS_GLOBAL_ORIGIN: where the vehicle's local frame begins."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


class Home(NamedTuple):
    """HOME_POSITION: where the vehicle's own heights above home begin."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


class SysStatus(NamedTuple):
    """SYS_STATUS; `battery_pct` is None where the vehicle does not know."""

    battery_pct: int | None


class ExtendedSysState(NamedTuple):
    """EXTENDED_SYS_STATE."""

    landed_state: int


class CommandAck(NamedTuple):
    """COMMAND_ACK."""

    command: int
    result: int


class ImageCaptured(NamedTuple):
    """CAMERA_IMAGE_CAPTURED: the picture's number, and whether there is one."""

    time_boot_ms: int
    image_index: int
    taken: bool


class AutopilotVersion(NamedTuple):
    """AUTOPILOT_VERSION."""

    version: str
    capabilities: int


class StatusText(NamedTuple):
    """STATUSTEXT; `severity` as in syslog, 0 emergency to 7 debug."""

    severity: int
    text: str


class ParamValue(NamedTuple):
    """PARAM_VALUE; `raw` is the float on the wire."""

    name: str
    raw: float
    param_type: int

    def number(self, *, bytewise: bool) -> float:
        """The parameter's value; `bytewise` where integers are carried in the float's bytes, as PX4 does."""
        code = _INTEGER_CODES.get(self.param_type)
        if code is None or not bytewise:
            return self.raw
        return float(struct.unpack_from(code, struct.pack("<f", self.raw))[0])


Message = (
    Heartbeat
    | LocalPosition
    | Attitude
    | GlobalPosition
    | GpsFix
    | Origin
    | Home
    | SysStatus
    | ExtendedSysState
    | CommandAck
    | ImageCaptured
    | AutopilotVersion
    | StatusText
    | ParamValue
    | MissionItem
    | MissionCount
    | MissionRequest
    | MissionAck
)


def raw_of(number: float, param_type: int, *, bytewise: bool) -> float:
    """What PARAM_SET must carry for `number`: the way back from `ParamValue.number`."""
    code = _INTEGER_CODES.get(param_type)
    if code is None or not bytewise:
        return number
    raw: float = struct.unpack("<f", struct.pack(code, int(number)).ljust(4, b"\0"))[0]
    return raw


_INTEGER_CODES = {1: "<B", 2: "<b", 3: "<H", 4: "<h", 5: "<I", 6: "<i"}  # MAV_PARAM_TYPE_*
