"""What PX4 says of its own state: mode, health, landing, version."""

from __future__ import annotations

from collections.abc import Mapping

from pymavlink.dialects.v20 import common

from sitl.link.messages import Message, MessageType, message_type
from sitl.link.mode_list import ListedMode
from sitl.link.report import Report, whole
from sitl.link.telemetry import Builder
from sitl.orders import Mode
from sitl.status import Landed, Notice, Severity

__all__ = ["MODES_NOT_FLOWN", "MODE_OF_CODE", "PX4_MODES", "STATUS", "status_texts"]

_HEARTBEAT = message_type("HEARTBEAT")
_SYS_STATUS = message_type("SYS_STATUS")
_EXTENDED_SYS_STATE = message_type("EXTENDED_SYS_STATE")
_AUTOPILOT_VERSION = message_type("AUTOPILOT_VERSION")
_CURRENT_MODE = message_type("CURRENT_MODE")
_PROTOCOL_VERSION = message_type("PROTOCOL_VERSION")
_ORBIT_EXECUTION_STATUS = message_type("ORBIT_EXECUTION_STATUS")
_POSITION_TARGET_LOCAL_NED = message_type("POSITION_TARGET_LOCAL_NED")
_STATUSTEXT = message_type("STATUSTEXT")

_MODE_CODES: Mapping[Mode, tuple[int, int]] = {
    Mode.POSITION: (3, 0),
    Mode.TAKEOFF: (4, 2),
    Mode.HOLD: (4, 3),
    Mode.MISSION: (4, 4),
    Mode.RETURN: (4, 5),
    Mode.LAND: (4, 6),
    Mode.OFFBOARD: (6, 0),
    Mode.ORBIT: (3, 1),
}
"""PX4's main and sub mode of each mode."""
MODE_OF_CODE: Mapping[tuple[int, int], Mode] = {
    code: mode for mode, code in _MODE_CODES.items() if mode is not Mode.ORBIT
}
"""An orbit is ordered by its command alone."""
MODES_NOT_FLOWN: Mapping[tuple[int, int], str] = {
    (1, 0): "Manual",
    (2, 0): "Altitude",
    (3, 2): "Position Slow",
    (4, 8): "Follow Target",
    (4, 9): "Precision Landing",
    (5, 0): "Acro",
    (7, 0): "Stabilized",
}
"""PX4's other modes, which want a stick, a target or a marker: none of them is ever there."""

_ARMED, _MANUAL, _STABILIZE, _GUIDED, _AUTO, _CUSTOM = 128, 64, 16, 8, 4, 1
_BASE_MODES = {
    Mode.OFFBOARD: _STABILIZE | _CUSTOM,
    Mode.ORBIT: _STABILIZE | _CUSTOM,
    Mode.POSITION: _MANUAL | _STABILIZE | _CUSTOM,
}
_AUTO_BASE_MODE = _STABILIZE | _GUIDED | _AUTO | _CUSTOM

_LANDED_STATES = {
    Landed.ON_GROUND: common.MAV_LANDED_STATE_ON_GROUND,
    Landed.IN_AIR: common.MAV_LANDED_STATE_IN_AIR,
    Landed.TAKING_OFF: common.MAV_LANDED_STATE_TAKEOFF,
    Landed.LANDING: common.MAV_LANDED_STATE_LANDING,
}

_SEVERITIES = {
    Severity.CRITICAL: common.MAV_SEVERITY_CRITICAL,
    Severity.WARNING: common.MAV_SEVERITY_WARNING,
    Severity.NOTICE: common.MAV_SEVERITY_NOTICE,
    Severity.INFO: common.MAV_SEVERITY_INFO,
}
_TEXT_LENGTH = 50
_I32 = (-(2**31), 2**31 - 1)
# MAVLink's MAV_STANDARD_MODE; 0 is none of them.
_STANDARD_MODES = {
    Mode.POSITION: 1,
    Mode.ORBIT: 2,
    Mode.MISSION: 6,
    Mode.RETURN: 5,
    Mode.LAND: 7,
    Mode.TAKEOFF: 8,
}

PX4_MODES = tuple(
    ListedMode(
        mode.name.capitalize(),
        main << 16 | sub << 24,
        _STANDARD_MODES.get(mode, 0),
        selectable=mode is not Mode.ORBIT,
    )
    for mode, (main, sub) in _MODE_CODES.items()
)
"""For AVAILABLE_MODES."""

_SENSES = (
    common.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | common.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | common.MAV_SYS_STATUS_SENSOR_3D_MAG
    | common.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
    | common.MAV_SYS_STATUS_SENSOR_BATTERY
)
_EVERYTHING = (
    _SENSES
    | common.MAV_SYS_STATUS_SENSOR_GPS
    | common.MAV_SYS_STATUS_AHRS
    | common.MAV_SYS_STATUS_PREARM_CHECK
)
_CAPABILITIES = 0xE8FF
_VERSION_1_17_0 = 0x011100FF


def _heartbeat(report: Report) -> Message:
    flight = report.flight
    main, sub = _MODE_CODES[flight.mode]
    if flight.failsafe:
        system_status = common.MAV_STATE_CRITICAL
    else:
        system_status = common.MAV_STATE_ACTIVE if flight.armed else common.MAV_STATE_STANDBY
    return _HEARTBEAT(
        custom_mode=main << 16 | sub << 24,
        type=common.MAV_TYPE_QUADROTOR,
        autopilot=common.MAV_AUTOPILOT_PX4,
        base_mode=_BASE_MODES.get(flight.mode, _AUTO_BASE_MODE) | _ARMED * flight.armed,
        system_status=system_status,
        mavlink_version=3,
    )


def _sys_status(report: Report) -> Message:
    battery, gps, health = report.instruments.battery, report.instruments.gps, _SENSES
    if gps is not None and gps.fix_type >= common.GPS_FIX_TYPE_3D_FIX:
        health |= common.MAV_SYS_STATUS_SENSOR_GPS
    if report.estimate.attitude_ok:
        health |= common.MAV_SYS_STATUS_AHRS
    if report.flight.ready:
        health |= common.MAV_SYS_STATUS_PREARM_CHECK
    return _SYS_STATUS(
        onboard_control_sensors_present=_EVERYTHING,
        onboard_control_sensors_enabled=_EVERYTHING,
        onboard_control_sensors_health=health,
        load=100,
        voltage_battery=whole(battery.voltage_v * 1e3, (0, 65535)),
        current_battery=whole(battery.current_a * 1e2, (-1, 32767)),
        drop_rate_comm=0,
        errors_comm=0,
        errors_count1=0,
        errors_count2=0,
        errors_count3=0,
        errors_count4=0,
        battery_remaining=whole(battery.remaining * 1e2, (0, 100)),
        onboard_control_sensors_present_extended=0,
        onboard_control_sensors_enabled_extended=0,
        onboard_control_sensors_health_extended=0,
    )


def _extended_sys_state(report: Report) -> Message:
    return _EXTENDED_SYS_STATE(vtol_state=0, landed_state=_LANDED_STATES[report.flight.landed])


def _current_mode(report: Report) -> Message:
    main, sub = _MODE_CODES[report.flight.mode]
    custom_mode = main << 16 | sub << 24
    return _CURRENT_MODE(
        custom_mode=custom_mode,
        intended_custom_mode=custom_mode,
        standard_mode=_STANDARD_MODES.get(report.flight.mode, 0),
    )


def _orbit_execution_status(report: Report) -> Message | None:
    orbit = report.flight.orbit
    if orbit is None:
        return None
    return _ORBIT_EXECUTION_STATUS(
        time_usec=report.time_us,
        radius=orbit.radius_m,
        x=whole(orbit.centre.lat_deg * 1e7, _I32),
        y=whole(orbit.centre.lon_deg * 1e7, _I32),
        z=orbit.centre.alt_amsl_m,
        frame=common.MAV_FRAME_GLOBAL,
    )


def _position_target(report: Report) -> Message | None:
    """No echo: the speed and acceleration that PX4's cascade makes of the setpoint, its corrections included."""
    flight, instruments = report.flight, report.instruments
    setpoint = flight.setpoint
    if not flight.armed or setpoint.attitude is not None:
        return None
    return _POSITION_TARGET_LOCAL_NED(
        report.time_ms,
        *setpoint.position_ned_m,
        *instruments.velocity_wanted.tolist(),
        *instruments.acceleration_wanted.tolist(),
        setpoint.yaw_ned_rad,
        setpoint.yaw_rate_ned_radps,
        type_mask=0,
        coordinate_frame=1,
    )


def _autopilot_version(_: Report) -> Message:
    return _AUTOPILOT_VERSION(
        capabilities=_CAPABILITIES,
        uid=0x6D617673706972,
        flight_sw_version=_VERSION_1_17_0,
        middleware_sw_version=_VERSION_1_17_0,
        os_sw_version=0,
        board_version=0,
        vendor_id=0,
        product_id=0,
        flight_custom_version=(0,) * 8,
        middleware_custom_version=(0,) * 8,
        os_custom_version=(0,) * 8,
        uid2=(0,) * 18,
    )


def _protocol_version(_: Report) -> Message:
    return _PROTOCOL_VERSION(200, 100, 200, spec_version_hash=bytes(8), library_version_hash=bytes(8))


def status_texts(notice: Notice, number: int) -> tuple[list[Message], int]:
    """The notice as text, in numbered parts when it is long; and the number that was used last."""
    text = notice.text.encode("ascii", "replace")
    parts = [text[begin : begin + _TEXT_LENGTH] for begin in range(0, len(text), _TEXT_LENGTH)]
    mine = 0
    if len(parts) > 1:
        mine = number = number % 0xFFFF + 1
    severity = _SEVERITIES[notice.severity]
    return [_STATUSTEXT(severity, part, mine, chunk) for chunk, part in enumerate(parts)], number


STATUS: Mapping[MessageType, Builder] = {
    _HEARTBEAT: _heartbeat,
    _SYS_STATUS: _sys_status,
    _EXTENDED_SYS_STATE: _extended_sys_state,
    _AUTOPILOT_VERSION: _autopilot_version,
    _POSITION_TARGET_LOCAL_NED: _position_target,
    _CURRENT_MODE: _current_mode,
    _PROTOCOL_VERSION: _protocol_version,
    _ORBIT_EXECUTION_STATUS: _orbit_execution_status,
}
