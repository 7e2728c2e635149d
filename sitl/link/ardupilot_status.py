"""What ArduCopter says of its own state: mode, health, filter, senses in its own units, version."""

from __future__ import annotations

import math
from collections.abc import Mapping

from pymavlink.dialects.v20 import ardupilotmega, common

from sitl.geo import geodetic_of_ned
from sitl.link.instruments import INSTRUMENTS, inertial_thousandths
from sitl.link.messages import Message, MessageType, layout_of, message_type
from sitl.link.mode_list import ListedMode
from sitl.link.px4_status import STATUS
from sitl.link.report import Report, whole
from sitl.link.telemetry import TELEMETRY, Builder
from sitl.orders import Mode
from sitl.rotation import euler_rad
from sitl.status import Shot

__all__ = [
    "BOOT_US",
    "COPTER_LISTED_MODES",
    "COPTER_STATUS",
    "MODES_NOT_FLOWN",
    "MODE_OF_NUMBER",
    "camera_feedback",
]

BOOT_US = 2_900_000
"""So long the HEARTBEAT says BOOT, and streams cannot be asked for."""

_HEARTBEAT = message_type("HEARTBEAT")
_SYS_STATUS = message_type("SYS_STATUS")
_AUTOPILOT_VERSION = message_type("AUTOPILOT_VERSION")
_RAW_IMU = message_type("RAW_IMU")
_RC_CHANNELS = message_type("RC_CHANNELS")
_NAV_CONTROLLER_OUTPUT = message_type("NAV_CONTROLLER_OUTPUT")
_FENCE_STATUS = message_type("FENCE_STATUS")
_CURRENT_MODE = message_type("CURRENT_MODE")
_SERVO_OUTPUT_RAW = message_type("SERVO_OUTPUT_RAW")
_POSITION_TARGET_GLOBAL_INT = message_type("POSITION_TARGET_GLOBAL_INT")
_VFR_HUD = message_type("VFR_HUD")
_VIBRATION = message_type("VIBRATION")


def _own(name: str) -> MessageType:
    """A message of ArduPilot's own dialect."""
    message_id = getattr(ardupilotmega, f"MAVLINK_MSG_ID_{name}")
    return layout_of(message_id, ardupilotmega.mavlink_map[message_id]).type


_EKF_STATUS_REPORT = _own("EKF_STATUS_REPORT")
_AHRS2 = _own("AHRS2")
_CAMERA_FEEDBACK = _own("CAMERA_FEEDBACK")

_NUMBERS: Mapping[Mode, int] = {
    Mode.STABILIZE: 0,
    Mode.ALT_HOLD: 2,
    Mode.AUTO: 3,
    Mode.GUIDED: 4,
    Mode.LOITER: 5,
    Mode.RTL: 6,
    Mode.CIRCLE: 7,
    Mode.LAND: 9,
    Mode.POSHOLD: 16,
    Mode.BRAKE: 17,
    Mode.SMARTRTL: 21,
}
MODE_OF_NUMBER: Mapping[int, Mode] = {number: mode for mode, number in _NUMBERS.items()}

MODES_NOT_FLOWN: Mapping[int, str] = {
    1: "ACRO",
    11: "DRIFT",
    13: "SPORT",
    14: "FLIP",
    15: "AUTOTUNE",
    18: "THROW",
    19: "AVOID_ADSB",
    20: "GUIDED_NOGPS",
    22: "FLOWHOLD",
    23: "FOLLOW",
    24: "ZIGZAG",
    25: "SYSTEMID",
    27: "AUTO RTL",
    28: "TURTLE",
}
"""What an ArduCopter has and this one does not."""

_STANDARD_MODES = {Mode.AUTO: 6, Mode.LOITER: 1, Mode.RTL: 5, Mode.LAND: 7, Mode.ALT_HOLD: 4}
"""MAVLink's MAV_STANDARD_MODE."""
COPTER_LISTED_MODES = tuple(
    ListedMode(mode.name, number, _STANDARD_MODES.get(mode, 0)) for mode, number in _NUMBERS.items()
)
"""For AVAILABLE_MODES."""

_ARMED, _MANUAL_INPUT, _STABILIZED, _GUIDED, _CUSTOM = 128, 64, 16, 8, 1
_STICKS_ALONE = (Mode.STABILIZE, Mode.ALT_HOLD, Mode.LAND)
_CAPABILITIES = 64495
_VERSION_4_6_3 = 0x040603FF
_EKF_READY, _EKF_WAITING = 831, 421
_I16, _I32, _U16 = (-(2**15), 2**15 - 1), (-(2**31), 2**31 - 1), (0, 2**16 - 1)
_STICK_MIDDLE, _STICK_LOW, _CHANNELS = 1500, 1000, 18
_UNKNOWN_RSSI = 255
_PLACE_ALONE = 0xFFF8
"""Type mask: nothing but the place counts."""
_GEOFENCE = common.MAV_SYS_STATUS_GEOFENCE
_BREACHES = {
    1: common.FENCE_BREACH_MAXALT,
    2: common.FENCE_BREACH_BOUNDARY,
    4: common.FENCE_BREACH_BOUNDARY,
    8: common.FENCE_BREACH_MINALT,
}


def _heartbeat(report: Report) -> Message:
    flight = report.flight
    if flight.failsafe:
        system_status = common.MAV_STATE_CRITICAL
    elif report.time_us < BOOT_US:
        system_status = common.MAV_STATE_BOOT
    else:
        standing = not flight.armed or flight.landed.name == "ON_GROUND"
        system_status = common.MAV_STATE_STANDBY if standing else common.MAV_STATE_ACTIVE
    base_mode = _MANUAL_INPUT | _STABILIZED | _CUSTOM | _GUIDED * (flight.mode not in _STICKS_ALONE)
    return _HEARTBEAT(
        custom_mode=_NUMBERS[flight.mode],
        type=common.MAV_TYPE_QUADROTOR,
        autopilot=common.MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode=base_mode | _ARMED * flight.armed,
        system_status=system_status,
        mavlink_version=3,
    )


def _sys_status(report: Report) -> Message | None:
    """As PX4's, whose prearm bit is ArduPilot's too: it says less than the answer to arming. And how the fence is."""
    told, fence = STATUS[_SYS_STATUS](report), report.flight.fence
    if told is None:
        return None
    status: Message = told._replace(
        onboard_control_sensors_present=told.onboard_control_sensors_present | _GEOFENCE,
        onboard_control_sensors_enabled=told.onboard_control_sensors_enabled
        | _GEOFENCE * bool(fence.watched),
        onboard_control_sensors_health=told.onboard_control_sensors_health | _GEOFENCE * (not fence.breached),
    )
    return status


def _fence_status(report: Report) -> Message | None:
    """Nothing while no fence is watched."""
    fence = report.flight.fence
    if not fence.watched:
        return None
    return _FENCE_STATUS(
        breach_status=int(fence.breached != 0),
        breach_count=fence.count & 0xFFFF,
        breach_type=_BREACHES.get(fence.last, 0),
        breach_time=fence.time_us // 1000 & 0xFFFFFFFF,
        breach_mitigation=0,
    )


def _current_mode(report: Report) -> Message:
    number = _NUMBERS[report.flight.mode]
    return _CURRENT_MODE(number, number, _STANDARD_MODES.get(report.flight.mode, 0))


def _servo_output_raw(report: Report) -> Message | None:
    """The motors, and what DO_SET_SERVO has put on other outputs."""
    told = INSTRUMENTS[_SERVO_OUTPUT_RAW](report)
    if told is None or not report.flight.outputs:
        return told
    put: Message = told._replace(**{f"servo{number}_raw": pwm for number, pwm in report.flight.outputs})
    return put


def _autopilot_version(report: Report) -> Message | None:
    version = STATUS[_AUTOPILOT_VERSION](report)
    assert version is not None
    told: Message = version._replace(
        capabilities=_CAPABILITIES,
        flight_sw_version=_VERSION_4_6_3,
        middleware_sw_version=0,
        flight_custom_version=tuple(b"mavspira"),
    )
    return told


def _ekf_status(report: Report) -> Message:
    knows = report.flight.knows_place
    estimate = report.estimate
    spread = math.sqrt(max(0.0, float(estimate.position_variance_m2[0])))
    speed = math.sqrt(max(0.0, float(estimate.velocity_variance_m2ps2[0])))
    return _EKF_STATUS_REPORT(
        velocity_variance=speed,
        pos_horiz_variance=spread,
        pos_vert_variance=math.sqrt(max(0.0, float(estimate.position_variance_m2[2]))),
        compass_variance=0.0,
        terrain_alt_variance=0.0,
        flags=_EKF_READY if knows else _EKF_WAITING,
        airspeed_variance=0.0,
    )


def _raw_imu(report: Report) -> Message:
    """Thousandths of g, of rad/s and of gauss."""
    return _RAW_IMU(report.time_us, *inertial_thousandths(report), 0, 0)


def _ahrs2(report: Report) -> Message:
    roll, pitch, yaw = euler_rad(report.estimate.q_ned_frd)
    lat_deg, lon_deg, alt_m = report.place or (0.0, 0.0, 0.0)
    return _AHRS2(roll, pitch, yaw, alt_m, whole(lat_deg * 1e7, _I32), whole(lon_deg * 1e7, _I32))


def _rc_channels(report: Report) -> Message:
    """The sticks of nobody, but for those that a ground station holds."""
    sticks = (_STICK_MIDDLE, _STICK_MIDDLE, _STICK_LOW, _STICK_MIDDLE)
    channels = [*sticks, *(_STICK_LOW,) * 4, *(0,) * (_CHANNELS - 8)]
    for number, pulse_us in report.flight.channels:
        channels[number - 1] = pulse_us
    return _RC_CHANNELS(report.time_ms, *channels, chancount=16, rssi=_UNKNOWN_RSSI)


def _nav_controller_output(report: Report) -> Message:
    roll, pitch, _ = euler_rad(report.instruments.attitude_wanted)
    here, flight = report.estimate.position_ned_m.tolist(), report.flight
    north_m, east_m, down_m = (
        goal - own
        for goal, own in zip(flight.goal_ned_m or flight.setpoint.position_ned_m, here, strict=True)
    )
    if not (flight.armed and math.isfinite(north_m + east_m + down_m)):
        north_m = east_m = down_m = 0.0
    bearing = whole(math.degrees(math.atan2(east_m, north_m)), _I16)
    return _NAV_CONTROLLER_OUTPUT(
        nav_roll=math.degrees(roll),
        nav_pitch=math.degrees(pitch),
        alt_error=-down_m,
        aspd_error=0.0,
        xtrack_error=0.0,
        nav_bearing=bearing,
        target_bearing=bearing,
        wp_dist=whole(math.hypot(north_m, east_m), _U16),
    )


def _position_target_global_int(report: Report) -> Message | None:
    """Where it flies to; nothing while that is no place."""
    origin, goal_ned_m = report.origin, report.flight.goal_ned_m
    if origin is None or goal_ned_m is None or not report.flight.armed:
        return None
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    lat_deg, lon_deg, alt_m = geodetic_of_ned(anchor, goal_ned_m)
    return _POSITION_TARGET_GLOBAL_INT(
        time_boot_ms=report.time_ms,
        lat_int=whole(lat_deg * 1e7, _I32),
        lon_int=whole(lon_deg * 1e7, _I32),
        alt=alt_m,
        vx=0.0, vy=0.0, vz=0.0, afx=0.0, afy=0.0, afz=0.0, yaw=0.0, yaw_rate=0.0,
        type_mask=_PLACE_ALONE,
        coordinate_frame=common.MAV_FRAME_GLOBAL,
    )  # fmt: skip


def _vfr_hud(report: Report) -> Message | None:
    """Without an airspeed sensor ArduPilot takes the air for still."""
    told = INSTRUMENTS[_VFR_HUD](report)
    assert told is not None
    speed_mps = math.hypot(*report.estimate.velocity_ned_mps.tolist())
    hud: Message = told._replace(airspeed=speed_mps, alt=told.alt if math.isfinite(told.alt) else 0.0)
    return hud


def _vibration(report: Report) -> Message:
    """m/s² on each axis: what the accelerometer's metric, which knows no axes, comes to on one."""
    axis_mps2 = report.instruments.vibration[2] / math.sqrt(3.0)
    return _VIBRATION(
        report.time_us, axis_mps2, axis_mps2, axis_mps2, clipping_0=0, clipping_1=0, clipping_2=0
    )


def camera_feedback(shot: Shot) -> Message:
    """Where the camera was, and how it was held, when it took the picture."""
    point = shot.point
    roll, pitch, yaw = euler_rad(shot.q_ned_camera)
    return _CAMERA_FEEDBACK(
        time_usec=shot.time_us,
        lat=whole(point.lat_deg * 1e7, _I32),
        lng=whole(point.lon_deg * 1e7, _I32),
        alt_msl=point.alt_amsl_m,
        alt_rel=shot.height_home_m,
        roll=math.degrees(roll),
        pitch=math.degrees(pitch),
        yaw=math.degrees(yaw) % 360.0,
        foc_len=0.0,
        img_idx=shot.index & 0xFFFF,
        target_system=0,
        cam_idx=0,
        flags=0,
        completed_captures=shot.index + 1 & 0xFFFF,
    )


_SHARED_NAMES = (
    *("ATTITUDE", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "HOME_POSITION"),
    *("GPS_GLOBAL_ORIGIN", "POSITION_TARGET_LOCAL_NED", "SCALED_PRESSURE", "GPS_RAW_INT"),
    *("BATTERY_STATUS", "SERVO_OUTPUT_RAW", "SYSTEM_TIME", "EXTENDED_SYS_STATE", "ATTITUDE_TARGET"),
)
_SHARED = tuple(map(message_type, _SHARED_NAMES))

COPTER_STATUS: Mapping[MessageType, Builder] = {
    **{kind: {**TELEMETRY, **INSTRUMENTS, **STATUS}[kind] for kind in _SHARED},
    _HEARTBEAT: _heartbeat,
    _SYS_STATUS: _sys_status,
    _AUTOPILOT_VERSION: _autopilot_version,
    _EKF_STATUS_REPORT: _ekf_status,
    _RAW_IMU: _raw_imu,
    _AHRS2: _ahrs2,
    _RC_CHANNELS: _rc_channels,
    _NAV_CONTROLLER_OUTPUT: _nav_controller_output,
    _FENCE_STATUS: _fence_status,
    _CURRENT_MODE: _current_mode,
    _SERVO_OUTPUT_RAW: _servo_output_raw,
    _POSITION_TARGET_GLOBAL_INT: _position_target_global_int,
    _VFR_HUD: _vfr_hud,
    _VIBRATION: _vibration,
}
"""All that can be told."""
