"""SET_POSITION_TARGET_LOCAL_NED, _GLOBAL_INT and SET_ATTITUDE_TARGET to targets, by ArduCopter's rules.

Source: ArduPilot 4.6, GCS_MAVLink_Copter.cpp, as it was seen to behave. A group of three axes counts as ignored when
any of its bits is set.
"""

from __future__ import annotations

import math

from sitl.geo import ned_of_geodetic
from sitl.link.messages import Message
from sitl.link.report import Report
from sitl.rotation import euler_rad
from sitl.signals import AttitudeSetpoint, Setpoint, vector

__all__ = ["STOP", "attitude_target", "global_target", "local_target"]

_LOCAL_NED, _LOCAL_OFFSET, _BODY_NED, _BODY_OFFSET = 1, 7, 8, 9
_AMSL_FRAMES, _RELATIVE_FRAMES = (0, 5), (3, 6)
_POSITION, _VELOCITY, _ACCELERATION = 0o007, 0o070, 0o700
_FORCE, _YAW, _YAW_RATE = 1 << 9, 1 << 10, 1 << 11
_BODY_RATES, _NO_THRUST, _NO_ATTITUDE = 0b111, 64, 128
_NAN3 = (math.nan,) * 3
_FASTEST = 1000.0
_UNIT_WITHIN = 1e-3

STOP = Setpoint(_NAN3, _NAN3, _NAN3, math.nan, math.nan)
"""What ArduPilot makes of a message that it cannot follow: brake and stay."""


def local_target(message: Message, report: Report) -> Setpoint:
    """What a SET_POSITION_TARGET_LOCAL_NED commands. Offset frames begin where the vehicle is now."""
    frame = message.coordinate_frame
    if frame == _LOCAL_NED and not message.type_mask and _is_flyable(message):
        return Setpoint(message[1:4], message[4:7], message[7:10], message.yaw, message.yaw_rate)
    if frame not in (_LOCAL_NED, _LOCAL_OFFSET, _BODY_NED, _BODY_OFFSET):
        return STOP
    nose_rad = euler_rad(report.estimate.q_ned_frd)[2] if frame in (_BODY_NED, _BODY_OFFSET) else 0.0
    position = _group(message.type_mask, _POSITION, (message.x, message.y, message.z), nose_rad)
    if frame != _LOCAL_NED:
        here = report.estimate.position_ned_m.tolist()
        position = (position[0] + here[0], position[1] + here[1], position[2] + here[2])
    return _target(message, position, nose_rad)


def global_target(message: Message, report: Report) -> Setpoint:
    """What a SET_POSITION_TARGET_GLOBAL_INT commands."""
    origin, home = report.origin, report.flight.home
    frame = message.coordinate_frame
    if origin is None or home is None or frame not in (*_AMSL_FRAMES, *_RELATIVE_FRAMES):
        return STOP
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    point = message.lat_int * 1e-7, message.lon_int * 1e-7, origin.alt_amsl_m
    north_m, east_m, _ = ned_of_geodetic(anchor, point)
    down_m = origin.alt_amsl_m - message.alt
    if frame in _RELATIVE_FRAMES:
        down_m = float(home.position_ned_m[2]) - message.alt
    position = (north_m, east_m, down_m) if not message.type_mask & _POSITION else _NAN3
    return _target(message, position, 0.0)


def attitude_target(message: Message) -> Setpoint | None:
    """What a SET_ATTITUDE_TARGET commands; None when it counts for nothing. Of the three rates all count, or none."""
    mask, q = message.type_mask, None
    if mask & _NO_THRUST or not math.isfinite(message.thrust):
        return None
    if not mask & _NO_ATTITUDE:
        if not abs(math.hypot(*message.q) - 1.0) <= _UNIT_WITHIN:
            return None
        q = vector(message.q, 4)
    rates = message.body_roll_rate, message.body_pitch_rate, message.body_yaw_rate
    ignored = mask & _BODY_RATES
    if ignored == _BODY_RATES:
        rates = 0.0, 0.0, 0.0
    if ignored not in (0, _BODY_RATES) or not all(map(math.isfinite, rates)):
        return STOP
    thrust = min(max(message.thrust, 0.0), 1.0)
    return STOP._replace(attitude=AttitudeSetpoint(q, vector(rates), thrust))


def _target(message: Message, position: tuple[float, float, float], nose_rad: float) -> Setpoint:
    mask = message.type_mask
    velocity = _group(mask, _VELOCITY, (message.vx, message.vy, message.vz), nose_rad)
    acceleration = _group(mask, _ACCELERATION, (message.afx, message.afy, message.afz), nose_rad)
    told = [
        group
        for group, bits in ((position, _POSITION), (velocity, _VELOCITY), (acceleration, _ACCELERATION))
        if not mask & bits
    ]
    if not all(
        math.isfinite(value) and abs(value) <= _limit(group, position) for group in told for value in group
    ):
        return STOP
    if mask & _FORCE and not mask & _ACCELERATION:
        return STOP
    yaw = math.nan if mask & _YAW else message.yaw + nose_rad
    yaw_rate = math.nan if mask & _YAW_RATE else message.yaw_rate
    return Setpoint(position, velocity, acceleration, yaw, yaw_rate)


def _is_flyable(message: Message) -> bool:
    """Whether all of a target that is commanded whole can be followed."""
    return math.isfinite(sum(message[1:4])) and all(abs(value) <= _FASTEST for value in message[4:10])


def _limit(group: tuple[float, float, float], position: tuple[float, float, float]) -> float:
    return math.inf if group is position else _FASTEST


def _group(
    mask: int, bits: int, values: tuple[float, float, float], nose_rad: float
) -> tuple[float, float, float]:
    """The group in NED; NaN where it is ignored."""
    if mask & bits:
        return _NAN3
    forward, right, down = values
    cos, sin = math.cos(nose_rad), math.sin(nose_rad)
    return cos * forward - sin * right, sin * forward + cos * right, down
