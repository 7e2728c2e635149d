"""The senses: truth made worse. Each has a random stream of its own, drawn ahead in blocks.

An IMU sample is the mean over its interval, plus white noise, plus a bias that walks. A fix has a white
error and one that wanders as a first-order Gauss–Markov process; it is true at its time and arrives 110 ms
later.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.airframe import Receiver, Senses
from sitl.geo import geodetic_of_ned
from sitl.kernels import kernel
from sitl.rotation import unrotate
from sitl.signals import FloatArray, GeoPoint

__all__ = [
    "BARO_NORMALS",
    "GPS_DELAY_FRAMES",
    "GPS_NORMALS",
    "IMU_NORMALS",
    "MAG_NORMALS",
    "SENSED",
    "measure_baro",
    "measure_fix",
    "measure_imu",
    "measure_mag",
    "new_sensed",
]

IMU_S = 0.005
BARO_S = 0.04
GPS_S = 0.1
GPS_DELAY_FRAMES = 11
"""A fix arrives this many 10 ms frames after it was true: PX4's old default of EKF2_GPS_DELAY, 110 ms."""

IMU_NORMALS, GPS_NORMALS, BARO_NORMALS, MAG_NORMALS = 12, 9, 2, 3
_BARO_DRIFT_TIME_S = 300.0

SENSED = np.dtype(
    [
        ("imu", "f8", (2, 6)),  # a frame's two samples: specific force, rate
        ("imu_bias", "f8", 6),
        ("imu_white", "f8", 2),  # 1 σ of a sample: accelerometer, gyro
        ("imu_walk", "f8", 2),  # 1 σ of a sample's bias step
        ("baro_alt_m", "f8"),
        ("baro_drift_m", "f8"),
        ("baro_noise_m", "f8"),
        ("baro_drift_sigma_m", "f8"),
        ("mag_frd_gauss", "f8", 3),
        ("mag_noise_gauss", "f8"),
        ("field_ned_gauss", "f8", 3),
        ("home", "f8", 3),  # lat_deg, lon_deg, alt_m
        ("fix", "f8", (16, 6)),  # lat, lon, alt, velocity, by frame number modulo 16, until they arrive
        ("fix_valid", "i8", 16),
        ("fix_wander_m", "f8", 3),
        ("fix_errors", "f8", 6),
    ]
)


def new_sensed(
    senses: Senses,
    receiver: Receiver,
    home: GeoPoint,
    field_ned_gauss: tuple[float, float, float],
    normals: FloatArray,
    noise: bool,
) -> np.ndarray:
    """One SENSED at power-on; ten `normals` set the IMU's biases, the baro's drift and the fix's wander."""
    sensed = np.zeros(1, SENSED)
    s = sensed[0]
    s["home"] = home.lat_deg, home.lon_deg, home.alt_amsl_m
    s["field_ned_gauss"] = field_ned_gauss
    if not noise:
        return sensed
    rate_hz = 1.0 / IMU_S
    s["imu_white"] = senses.accel_noise_mps2_rthz * rate_hz**0.5, senses.gyro_noise_radps_rthz * rate_hz**0.5
    s["imu_walk"] = senses.accel_walk_mps3_rthz * IMU_S**0.5, senses.gyro_walk_radps2_rthz * IMU_S**0.5
    s["imu_bias"][:3] = senses.accel_bias_mps2 * normals[:3]
    s["imu_bias"][3:] = senses.gyro_bias_radps * normals[3:6]
    s["baro_noise_m"], s["baro_drift_sigma_m"] = senses.baro_noise_m, senses.baro_drift_m
    s["baro_drift_m"] = senses.baro_drift_m * normals[6]
    s["mag_noise_gauss"] = senses.mag_noise_gauss
    s["fix_errors"] = receiver[:6]
    s["fix_wander_m"][:2] = receiver.wander_h_m * normals[7:9]
    s["fix_wander_m"][2] = receiver.wander_v_m * normals[9]
    return sensed


@kernel
def measure_imu(
    sensed: np.record, slot: int, force: FloatArray, rate: FloatArray, normals: FloatArray
) -> None:
    """Put the sample whose true means are `force` and `rate` into `slot`, and let the biases walk."""
    for i in range(3):
        sensed.imu[slot, i] = force[i] + sensed.imu_bias[i] + sensed.imu_white[0] * normals[i]
        sensed.imu[slot, 3 + i] = rate[i] + sensed.imu_bias[3 + i] + sensed.imu_white[1] * normals[3 + i]
        sensed.imu_bias[i] += sensed.imu_walk[0] * normals[6 + i]
        sensed.imu_bias[3 + i] += sensed.imu_walk[1] * normals[9 + i]


@kernel
def measure_baro(sensed: np.record, down_m: float, normals: FloatArray) -> None:
    """Take a pressure height."""
    decay = math.exp(-BARO_S / _BARO_DRIFT_TIME_S)
    fresh = sensed.baro_drift_sigma_m * math.sqrt(1.0 - decay * decay)
    sensed.baro_drift_m = decay * sensed.baro_drift_m + fresh * normals[1]
    sensed.baro_alt_m = sensed.home[2] - down_m + sensed.baro_drift_m + sensed.baro_noise_m * normals[0]


@kernel
def measure_mag(sensed: np.record, q_ned_frd: FloatArray, normals: FloatArray) -> None:
    """Take the field along the body axes."""
    field = unrotate(q_ned_frd, sensed.field_ned_gauss)
    for i in range(3):
        sensed.mag_frd_gauss[i] = field[i] + sensed.mag_noise_gauss * normals[i]


@kernel
def measure_fix(
    sensed: np.record,
    frame: int,
    position_ned_m: FloatArray,
    velocity_ned_mps: FloatArray,
    normals: FloatArray,
    received: bool,
) -> None:
    """Take a fix at this frame; without reception the error still wanders."""
    white_h, white_v, wander_h, wander_v, wander_time, speed = (
        sensed.fix_errors[0], sensed.fix_errors[1], sensed.fix_errors[2],
        sensed.fix_errors[3], sensed.fix_errors[4], sensed.fix_errors[5],
    )  # fmt: skip
    decay = math.exp(-GPS_S / wander_time) if wander_time > 0.0 else 0.0
    fresh = math.sqrt(1.0 - decay * decay)
    e = sensed.fix_wander_m
    e[0] = decay * e[0] + fresh * wander_h * normals[0]
    e[1] = decay * e[1] + fresh * wander_h * normals[1]
    e[2] = decay * e[2] + fresh * wander_v * normals[2]
    slot = frame % 16
    sensed.fix_valid[slot] = received
    place = geodetic_of_ned(
        (sensed.home[0], sensed.home[1], sensed.home[2]),
        (
            position_ned_m[0] + e[0] + white_h * normals[3],
            position_ned_m[1] + e[1] + white_h * normals[4],
            position_ned_m[2] + e[2] + white_v * normals[5],
        ),
    )
    for i in range(3):
        sensed.fix[slot, i] = place[i]
        sensed.fix[slot, 3 + i] = velocity_ned_mps[i] + speed * normals[6 + i]
