"""What the senses, the battery and the motors show, as MAVLink messages."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sitl.clock import EPOCH_UNIX_US
from sitl.geo import GRAVITY_MPS2
from sitl.link.messages import Message, MessageType, message_type
from sitl.link.report import Report, heading_deg, whole
from sitl.link.telemetry import Builder
from sitl.status import Shot

__all__ = ["INSTRUMENTS", "image_captured", "inertial_thousandths"]

_HIGHRES_IMU = message_type("HIGHRES_IMU")
_SCALED_IMU = message_type("SCALED_IMU")
_SCALED_PRESSURE = message_type("SCALED_PRESSURE")
_GPS_RAW_INT = message_type("GPS_RAW_INT")
_VFR_HUD = message_type("VFR_HUD")
_BATTERY_STATUS = message_type("BATTERY_STATUS")
_SERVO_OUTPUT_RAW = message_type("SERVO_OUTPUT_RAW")
_SYSTEM_TIME = message_type("SYSTEM_TIME")
_VIBRATION = message_type("VIBRATION")
_DISTANCE_SENSOR = message_type("DISTANCE_SENSOR")
_CAMERA_IMAGE_CAPTURED = message_type("CAMERA_IMAGE_CAPTURED")

_U16, _I16, _I32 = (0, 2**16 - 1), (-(2**15), 2**15 - 1), (-(2**31), 2**31 - 1)
_UNKNOWN_U16 = 65535
_RANGE_MAX_M = 100.0
_DOWN = 25
_PWM_OFF, _PWM_MIN, _PWM_SPAN = 900, 1000, 1000


def _highres_imu(report: Report) -> Message:
    return _HIGHRES_IMU(
        report.time_us,
        *report.instruments.imu.specific_force_frd_mps2.tolist(),
        *report.instruments.imu.rate_frd_radps.tolist(),
        *report.instruments.mag.field_frd_gauss.tolist(),
        abs_pressure=report.instruments.baro.pressure_pa * 1e-2,
        diff_pressure=0.0,
        pressure_alt=report.instruments.baro.alt_amsl_m,
        temperature=report.instruments.baro.temperature_c,
        fields_updated=63,
        id=0,
    )


def inertial_thousandths(report: Report) -> tuple[int, ...]:
    """Specific force, rates and field about FRD axes, in thousandths of g, of rad/s and of gauss."""
    imu, mag = report.instruments.imu, report.instruments.mag
    force = (whole(value / GRAVITY_MPS2 * 1e3, _I16) for value in imu.specific_force_frd_mps2.tolist())
    rate = (whole(value * 1e3, _I16) for value in imu.rate_frd_radps.tolist())
    field = (whole(value * 1e3, _I16) for value in mag.field_frd_gauss.tolist())
    return *force, *rate, *field


def _scaled_imu(report: Report) -> Message:
    temperature = whole(report.instruments.baro.temperature_c * 1e2, _I16)
    return _SCALED_IMU(report.time_ms, *inertial_thousandths(report), temperature)


def _scaled_pressure(report: Report) -> Message:
    baro = report.instruments.baro
    return _SCALED_PRESSURE(
        report.time_ms, baro.pressure_pa * 1e-2, 0.0, whole(baro.temperature_c * 1e2, _I16), 0
    )


def _gps_raw_int(report: Report) -> Message | None:
    gps = report.instruments.gps
    if gps is None:
        return None
    north_mps, east_mps, _ = gps.velocity_ned_mps.tolist()
    alt_mm = whole(gps.position.alt_amsl_m * 1e3, _I32)
    return _GPS_RAW_INT(
        time_usec=gps.time_us,
        fix_type=gps.fix_type,
        lat=whole(gps.position.lat_deg * 1e7, _I32),
        lon=whole(gps.position.lon_deg * 1e7, _I32),
        alt=alt_mm,
        eph=70,
        epv=110,
        vel=whole(math.hypot(north_mps, east_mps) * 1e2, _U16),
        cog=whole(math.degrees(math.atan2(east_mps, north_mps)) % 360.0 * 1e2, (0, 35999)),
        satellites_visible=gps.satellites,
        alt_ellipsoid=alt_mm,
        h_acc=whole(gps.horizontal_sigma_m * 1e3, _I32),
        v_acc=whole(gps.vertical_sigma_m * 1e3, _I32),
        vel_acc=whole(gps.speed_sigma_mps * 1e3, _I32),
        hdg_acc=0,
        yaw=0,
    )


def _vfr_hud(report: Report) -> Message:
    north_mps, east_mps, down_mps = report.estimate.velocity_ned_mps.tolist()
    place = report.place
    return _VFR_HUD(
        airspeed=math.nan,
        groundspeed=math.hypot(north_mps, east_mps),
        heading=int(heading_deg(report.estimate.q_ned_frd)),
        throttle=whole(report.instruments.thrust * 1e2, (0, 100)),
        alt=math.nan if place is None else place[2],
        climb=-down_mps,
    )


def _battery_status(report: Report) -> Message:
    battery = report.instruments.battery
    return _BATTERY_STATUS(
        id=0, battery_function=1, type=1, temperature=32767,
        voltages=(whole(battery.voltage_v * 1e3, _U16), *(_UNKNOWN_U16,) * 9),
        current_battery=whole(battery.current_a * 1e2, _I16),
        current_consumed=whole(battery.used_ah * 1e3, _I32),
        energy_consumed=-1,
        battery_remaining=whole(battery.remaining * 1e2, (0, 100)),
        time_remaining=0, charge_state=1, voltages_ext=(0,) * 4, mode=0, fault_bitmask=0,
    )  # fmt: skip


def _servo_output_raw(report: Report) -> Message:
    pwm = [_PWM_OFF] * 16
    if report.flight.armed:
        pwm[: len(report.instruments.motors)] = [
            whole(_PWM_MIN + _PWM_SPAN * motor, _U16) for motor in report.instruments.motors.tolist()
        ]
    named = {f"servo{number}_raw": value for number, value in enumerate(pwm, start=1)}
    return _SERVO_OUTPUT_RAW(time_usec=report.time_us & 0xFFFFFFFF, port=0, **named)


def _system_time(report: Report) -> Message:
    return _SYSTEM_TIME(time_unix_usec=EPOCH_UNIX_US + report.time_us, time_boot_ms=report.time_ms)


def _vibration(report: Report) -> Message:
    """Not what MAVLink means by it: PX4's own use of the three fields."""
    coning, gyro, accel = report.instruments.vibration
    return _VIBRATION(report.time_us, coning, gyro, accel, clipping_0=0, clipping_1=0, clipping_2=0)


def _distance_sensor(report: Report) -> Message:
    """The range finder of PX4's SIH: 100 m at most, no error, looking down."""
    range_m = report.instruments.range_m
    return _DISTANCE_SENSOR(
        time_boot_ms=report.time_ms,
        min_distance=0,
        max_distance=whole(_RANGE_MAX_M * 1e2, _U16),
        current_distance=whole(range_m * 1e2, _U16) if range_m <= _RANGE_MAX_M else _UNKNOWN_U16,
        type=0,
        id=0,
        orientation=_DOWN,
        covariance=0,
        horizontal_fov=0.0,
        vertical_fov=0.0,
        quaternion=(0.0,) * 4,
        signal_quality=0,
    )


def image_captured(shot: Shot) -> Message:
    """Where the camera was, and how it was held, when it took the picture."""
    point = shot.point
    return _CAMERA_IMAGE_CAPTURED(
        time_utc=EPOCH_UNIX_US + shot.time_us,
        time_boot_ms=shot.time_us // 1000 & 0xFFFFFFFF,
        lat=whole(point.lat_deg * 1e7, _I32),
        lon=whole(point.lon_deg * 1e7, _I32),
        alt=whole(point.alt_amsl_m * 1e3, _I32),
        relative_alt=whole(shot.height_home_m * 1e3, _I32),
        q=tuple(shot.q_ned_camera.tolist()),
        image_index=shot.index,
        camera_id=0,
        capture_result=1,
        file_url=b"",
    )


INSTRUMENTS: Mapping[MessageType, Builder] = {
    _HIGHRES_IMU: _highres_imu,
    _SCALED_IMU: _scaled_imu,
    _SCALED_PRESSURE: _scaled_pressure,
    _GPS_RAW_INT: _gps_raw_int,
    _VFR_HUD: _vfr_hud,
    _BATTERY_STATUS: _battery_status,
    _SERVO_OUTPUT_RAW: _servo_output_raw,
    _SYSTEM_TIME: _system_time,
    _VIBRATION: _vibration,
    _DISTANCE_SENSOR: _distance_sensor,
}
