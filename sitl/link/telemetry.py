"""What the estimator believes and the commander aims at, as MAVLink messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from sitl.link.messages import Message, MessageType, message_type
from sitl.link.report import Report, heading_deg, whole
from sitl.rotation import euler_rad

__all__ = ["TELEMETRY", "Builder"]

Builder = Callable[[Report], Message | None]
"""Makes a message of a report; None while there is nothing to tell."""

_ATTITUDE = message_type("ATTITUDE")
_ATTITUDE_QUATERNION = message_type("ATTITUDE_QUATERNION")
_LOCAL_POSITION_NED = message_type("LOCAL_POSITION_NED")
_GLOBAL_POSITION_INT = message_type("GLOBAL_POSITION_INT")
_ODOMETRY = message_type("ODOMETRY")
_ATTITUDE_TARGET = message_type("ATTITUDE_TARGET")
_ALTITUDE = message_type("ALTITUDE")
_ESTIMATOR_STATUS = message_type("ESTIMATOR_STATUS")
_HOME_POSITION = message_type("HOME_POSITION")
_GPS_GLOBAL_ORIGIN = message_type("GPS_GLOBAL_ORIGIN")

_NO_COVARIANCE = (math.nan,) * 21
_I16, _I32 = (-(2**15), 2**15 - 1), (-(2**31), 2**31 - 1)


def _attitude(report: Report) -> Message:
    roll, pitch, yaw = euler_rad(report.estimate.q_ned_frd)
    return _ATTITUDE(report.time_ms, roll, pitch, yaw, *report.estimate.rate_frd_radps.tolist())


def _attitude_quaternion(report: Report) -> Message:
    estimate = report.estimate
    return _ATTITUDE_QUATERNION(
        report.time_ms, *estimate.q_ned_frd.tolist(), *estimate.rate_frd_radps.tolist(), (0.0,) * 4
    )


def _local_position_ned(report: Report) -> Message | None:
    estimate = report.estimate
    if not estimate.position_ok:
        return None
    return _LOCAL_POSITION_NED(report.time_ms, *estimate.motion_ned.tolist())


def _global_position_int(report: Report) -> Message | None:
    place = report.place
    if place is None or not report.estimate.position_ok:
        return None
    north_mps, east_mps, down_mps = report.estimate.velocity_ned_mps.tolist()
    return _GLOBAL_POSITION_INT(
        time_boot_ms=report.time_ms,
        lat=whole(place[0] * 1e7, _I32),
        lon=whole(place[1] * 1e7, _I32),
        alt=whole(place[2] * 1e3, _I32),
        relative_alt=whole(report.height_home_m * 1e3, _I32),
        vx=whole(north_mps * 1e2, _I16),
        vy=whole(east_mps * 1e2, _I16),
        vz=whole(down_mps * 1e2, _I16),
        hdg=whole(heading_deg(report.estimate.q_ned_frd) * 1e2, (0, 35999)),
    )


def _odometry(report: Report) -> Message | None:
    estimate = report.estimate
    if not estimate.position_ok:
        return None
    pose, twist = list(_NO_COVARIANCE), list(_NO_COVARIANCE)
    # The upper triangle, row by row: its diagonal entries are these.
    pose[0], pose[6], pose[11] = estimate.position_variance_m2.tolist()
    pose[15], pose[18], pose[20] = estimate.attitude_variance_rad2.tolist()
    twist[0], twist[6], twist[11] = estimate.velocity_variance_m2ps2.tolist()
    north_m, east_m, down_m = estimate.position_ned_m.tolist()
    north_mps, east_mps, down_mps = estimate.velocity_ned_mps.tolist()
    roll_rate, pitch_rate, yaw_rate = estimate.rate_frd_radps.tolist()
    return _ODOMETRY(
        time_usec=report.time_us,
        x=north_m, y=east_m, z=down_m,
        q=tuple(estimate.q_ned_frd.tolist()),
        vx=north_mps, vy=east_mps, vz=down_mps,
        rollspeed=roll_rate, pitchspeed=pitch_rate, yawspeed=yaw_rate,
        pose_covariance=tuple(pose), velocity_covariance=tuple(twist),
        frame_id=1, child_frame_id=1, reset_counter=0, estimator_type=8, quality=0,
    )  # fmt: skip


def _attitude_target(report: Report) -> Message | None:
    if not report.flight.armed:
        return None
    instruments = report.instruments
    return _ATTITUDE_TARGET(
        report.time_ms,
        tuple(instruments.attitude_wanted.tolist()),
        *instruments.rate_wanted.tolist(),
        thrust=instruments.thrust,
        type_mask=0,
    )


def _altitude(report: Report) -> Message:
    place, height_local_m = report.place, -float(report.estimate.position_ned_m[2])
    return _ALTITUDE(
        time_usec=report.time_us,
        altitude_monotonic=report.instruments.baro.alt_amsl_m,
        altitude_amsl=math.nan if place is None else place[2],
        altitude_local=height_local_m,
        altitude_relative=report.height_home_m,
        altitude_terrain=math.nan,
        bottom_clearance=math.nan,
    )


def _estimator_status(report: Report) -> Message:
    estimate = report.estimate
    north_m2, east_m2, down_m2 = estimate.position_variance_m2.tolist()
    flags = (
        1 * estimate.attitude_ok
        | (2 | 4) * estimate.velocity_ok
        | (8 | 16 | 256 | 512) * estimate.position_ok
        | 32 * estimate.height_ok
    )
    return _ESTIMATOR_STATUS(
        time_usec=report.time_us, flags=flags, vel_ratio=0.0, pos_horiz_ratio=0.0, pos_vert_ratio=0.0,
        mag_ratio=0.0, hagl_ratio=math.nan, tas_ratio=math.nan,
        pos_horiz_accuracy=math.sqrt(max(0.0, north_m2 + east_m2)),
        pos_vert_accuracy=math.sqrt(max(0.0, down_m2)),
    )  # fmt: skip


def _home_position(report: Report) -> Message | None:
    home = report.flight.home
    if home is None:
        return None
    return _HOME_POSITION(
        whole(home.point.lat_deg * 1e7, _I32),
        whole(home.point.lon_deg * 1e7, _I32),
        whole(home.point.alt_amsl_m * 1e3, _I32),
        *home.position_ned_m.tolist(),
        q=tuple(home.q_ned_frd.tolist()),
        approach_x=0.0,
        approach_y=0.0,
        approach_z=0.0,
        time_usec=report.time_us,
    )


def _gps_global_origin(report: Report) -> Message | None:
    origin = report.origin
    if origin is None:
        return None
    return _GPS_GLOBAL_ORIGIN(
        latitude=whole(origin.lat_deg * 1e7, _I32),
        longitude=whole(origin.lon_deg * 1e7, _I32),
        altitude=whole(origin.alt_amsl_m * 1e3, _I32),
        time_usec=report.time_us,
    )


TELEMETRY: Mapping[MessageType, Builder] = {
    _ATTITUDE: _attitude,
    _ATTITUDE_QUATERNION: _attitude_quaternion,
    _LOCAL_POSITION_NED: _local_position_ned,
    _GLOBAL_POSITION_INT: _global_position_int,
    _ODOMETRY: _odometry,
    _ATTITUDE_TARGET: _attitude_target,
    _ALTITUDE: _altitude,
    _ESTIMATOR_STATUS: _estimator_status,
    _HOME_POSITION: _home_position,
    _GPS_GLOBAL_ORIGIN: _gps_global_origin,
}
