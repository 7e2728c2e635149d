"""SET_POSITION_TARGET_LOCAL_NED and SET_ATTITUDE_TARGET to setpoints, by PX4's rules.

Source: PX4 v1.17, mavlink_receiver.cpp, handle_message_set_position_target_local_ned and handle_message_set_attitude_target.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from sitl.link.messages import Message
from sitl.rotation import euler_rad
from sitl.signals import AttitudeSetpoint, FloatArray, Setpoint, vector

__all__ = ["attitude_setpoint_of", "setpoint_of"]

_LOCAL_NED, _BODY_NED = 1, 8
_VELOCITY_BITS, _ACCELERATION_BITS = 0o070, 0o700
_FORCE_BIT = 1 << 9
_ROLL_RATE_BIT, _PITCH_RATE_BIT, _YAW_RATE_BIT, _THRUST_BIT, _ATTITUDE_BIT = 1, 2, 4, 64, 128
_SHORTEST = 1e-3
_NAN3 = (math.nan, math.nan, math.nan)


def setpoint_of(message: Message, attitude: Callable[[], FloatArray]) -> Setpoint | None:
    """What the message commands of a vehicle whose q_ned_frd is `attitude()`; None when PX4 refuses it.

    Refused are other frames than LOCAL_NED and BODY_NED, a force, and whatever has no finite position, speed
    or acceleration. In BODY_NED a position is ignored, and a vector with one ignored axis is ignored whole.
    """
    mask = message.type_mask
    if not mask and message.coordinate_frame == _LOCAL_NED and math.isfinite(sum(message[1:12])):
        return Setpoint(message[1:4], message[4:7], message[7:10], message.yaw, message.yaw_rate)
    told: tuple[float, ...] = message[1:10]  # position, velocity, acceleration
    if message.coordinate_frame == _LOCAL_NED:
        told = _masked(told, mask)
    elif message.coordinate_frame == _BODY_NED:
        yaw_ned_rad = euler_rad(attitude())[2]
        velocity = _NAN3 if mask & _VELOCITY_BITS else _turned(_masked(told[3:6], 0), yaw_ned_rad)
        acceleration = _NAN3 if mask & _ACCELERATION_BITS else _turned(_masked(told[6:9], 0), yaw_ned_rad)
        told = (*_NAN3, *velocity, *acceleration)
    else:
        return None
    is_force = mask & _FORCE_BIT and any(map(math.isfinite, told[6:9]))
    if is_force or not any(map(math.isfinite, told)):
        return None
    yaw_rad, yaw_rate_radps = _masked((message.yaw, message.yaw_rate), mask >> 10)
    x, y, z, vx, vy, vz, ax, ay, az = told
    return Setpoint((x, y, z), (vx, vy, vz), (ax, ay, az), yaw_rad, yaw_rate_radps)


def attitude_setpoint_of(message: Message) -> Setpoint | None:
    """The attitude, or the body rates, and the thrust that the message commands; None when it lacks one of them.

    Where an attitude is given the body rates do not count, but for the yaw rate. Stricter than PX4: what is not
    finite, or a quaternion of no length, is no setpoint.
    """
    mask = message.type_mask
    ignores_rates = mask & (_ROLL_RATE_BIT | _PITCH_RATE_BIT)
    if mask & _THRUST_BIT or not math.isfinite(message.thrust):
        return None
    yaw_rate_radps = 0.0 if mask & _YAW_RATE_BIT else message.body_yaw_rate
    rates = message.body_roll_rate, message.body_pitch_rate, yaw_rate_radps
    q: FloatArray | None = None
    if not mask & _ATTITUDE_BIT:
        norm = math.hypot(*message.q)
        if not _SHORTEST < norm < math.inf:
            return None
        q = vector([value / norm for value in message.q], 4)
        rates = 0.0, 0.0, yaw_rate_radps
    elif ignores_rates:
        return None
    if not all(map(math.isfinite, rates)):
        return None
    attitude = AttitudeSetpoint(q, vector(rates), message.thrust)
    return Setpoint(_NAN3, _NAN3, _NAN3, math.nan, math.nan, attitude)


def _masked(values: tuple[float, ...], mask: int) -> tuple[float, ...]:
    """NaN for what the mask's low bits ignore, the lowest for the first, and for what is not finite."""
    if not mask & ((1 << len(values)) - 1) and math.isfinite(sum(values)):
        return values
    return tuple(
        math.nan if mask >> i & 1 or not math.isfinite(value) else value for i, value in enumerate(values)
    )


def _turned(values: tuple[float, ...], yaw_ned_rad: float) -> tuple[float, float, float]:
    forward, right, down = values
    cos, sin = math.cos(yaw_ned_rad), math.sin(yaw_ned_rad)
    return cos * forward - sin * right, sin * forward + cos * right, down
