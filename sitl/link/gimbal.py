"""The gimbal manager that PX4 is for a gimbal beside it: what it says of gimbal and control.

Simpler than PX4: whoever orders an angle is obeyed, in control or not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from pymavlink.dialects.v20 import common

from sitl.link.codec import Received
from sitl.link.commands import Command
from sitl.link.messages import Message, message_type
from sitl.link.report import Report
from sitl.link.telemetry import Builder
from sitl.rotation import from_euler

__all__ = ["GIMBAL", "GIMBAL_RATES_HZ", "claimed"]

_INFORMATION = message_type("GIMBAL_MANAGER_INFORMATION")
_DEVICE_INFORMATION = message_type("GIMBAL_DEVICE_INFORMATION")
_STATUS = message_type("GIMBAL_MANAGER_STATUS")
_ATTITUDE = message_type("GIMBAL_DEVICE_ATTITUDE_STATUS")

_DEVICE = 1
"""Below 7: a gimbal that speaks no MAVLink itself."""
_CAN = (
    common.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS
    | common.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK
    | common.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS
    | common.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW
)
_HORIZON = common.GIMBAL_DEVICE_FLAGS_ROLL_LOCK | common.GIMBAL_DEVICE_FLAGS_PITCH_LOCK
_SENDER = -2.0


def _information(report: Report) -> Message:
    quarter, half = 0.5 * math.pi, math.pi
    return _INFORMATION(
        time_boot_ms=report.time_ms, cap_flags=_CAN, roll_min=0.0, roll_max=0.0, pitch_min=-quarter,
        pitch_max=quarter, yaw_min=-half, yaw_max=half, gimbal_device_id=_DEVICE,
    )  # fmt: skip


def _device_information(report: Report) -> Message:
    """PX4 answers for a gimbal that speaks no MAVLink itself."""
    quarter, half = 0.5 * math.pi, math.pi
    named = {"vendor_name": b"mavspiral", "model_name": b"sitl", "custom_name": b""}
    return _DEVICE_INFORMATION(
        uid=0, time_boot_ms=report.time_ms, firmware_version=1, hardware_version=1, roll_min=0.0, roll_max=0.0,
        pitch_min=-quarter, pitch_max=quarter, yaw_min=-half, yaw_max=half, cap_flags=_CAN,
        custom_cap_flags=0, gimbal_device_id=_DEVICE, cap_flags2=0, **named,
    )  # fmt: skip


def _status(report: Report) -> Message:
    system, component = report.flight.payload.controller
    return _STATUS(
        time_boot_ms=report.time_ms, flags=_HORIZON, gimbal_device_id=_DEVICE,
        primary_control_sysid=system, primary_control_compid=component,
        secondary_control_sysid=0, secondary_control_compid=0,
    )  # fmt: skip


def _attitude(report: Report) -> Message:
    """Level with the horizon, and turned from the nose."""
    payload = report.flight.payload
    return _ATTITUDE(
        time_boot_ms=report.time_ms,
        q=tuple(from_euler(0.0, payload.gimbal_pitch_rad, payload.gimbal_yaw_rad)),
        angular_velocity_x=0.0, angular_velocity_y=0.0, angular_velocity_z=0.0, failure_flags=0,
        flags=_HORIZON | common.GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME, target_system=0, target_component=0,
        delta_yaw=math.nan, delta_yaw_velocity=math.nan, gimbal_device_id=_DEVICE,
    )  # fmt: skip


def claimed(command: Command, received: Received) -> Command:
    """A DO_GIMBAL_MANAGER_CONFIGURE in which the sender has its own numbers instead of -2."""
    system = received.system if command.param1 == _SENDER else command.param1
    component = received.component if command.param2 == _SENDER else command.param2
    return command._replace(param1=system, param2=component)


GIMBAL_RATES_HZ: Mapping[str, float] = {"GIMBAL_DEVICE_ATTITUDE_STATUS": 1.0, "GIMBAL_MANAGER_STATUS": 0.5}
"""What PX4 sends of a gimbal unasked, on either link (mavlink_main.cpp, "normal" and "onboard")."""
GIMBAL: Mapping[int, Builder] = {
    _INFORMATION.ID: _information,
    _DEVICE_INFORMATION.ID: _device_information,
    _STATUS.ID: _status,
    _ATTITUDE.ID: _attitude,
}
