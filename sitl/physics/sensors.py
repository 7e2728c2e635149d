"""The senses: truth made worse. Each has a random stream of its own, drawn ahead in blocks.

An IMU sample is the mean over its interval with an error of scale, plus white noise, plus a bias that walks.
The barometer drifts, reads higher in the propellers' suction and in the airstream. A fix has a white error
and one that wanders as a first-order Gauss–Markov process; it is true at its time and arrives 110 ms later.
The vehicle knows no walls: multipath is a second, quicker wander that a fault brings.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.airframe import Receiver, Senses
from sitl.geo import GRAVITY_MPS2, geodetic_of_ned
from sitl.kernels import kernel
from sitl.rotation import unrotate
from sitl.signals import FloatArray, GeoPoint

__all__ = [
    "BARO_NORMALS",
    "BOOT_NORMALS",
    "GPS_DELAY_FRAMES",
    "GPS_NORMALS",
    "IMU_NORMALS",
    "MAG_NORMALS",
    "SENSED",
    "STUCK_BITS",
    "measure_baro",
    "measure_fix",
    "measure_imu",
    "measure_mag",
    "measure_range",
    "new_sensed",
]

IMU_S = 0.005
BARO_S = 0.04
GPS_S = 0.1
GPS_DELAY_FRAMES = 11
"""A fix arrives this many 10 ms frames after it was true: PX4's old default of EKF2_GPS_DELAY, 110 ms."""

IMU_NORMALS, GPS_NORMALS, BARO_NORMALS, MAG_NORMALS, BOOT_NORMALS = 12, 12, 2, 3, 16
_BARO_DRIFT_TIME_S = 300.0
_MULTIPATH_TIME_S = 20.0  # seconds to a minute as the vehicle moves past the reflecting wall: chosen
_ACCEL_STUCK, _GYRO_STUCK, _BARO_STUCK, _MAG_STUCK, _FIX_STUCK = 1, 2, 4, 8, 16
STUCK_BITS = {
    "accel": _ACCEL_STUCK,
    "gyro": _GYRO_STUCK,
    "baro": _BARO_STUCK,
    "mag": _MAG_STUCK,
    "gps": _FIX_STUCK,
}
"""The bit in SENSED's `stuck` of each sense that can stick."""

SENSED = np.dtype(
    [
        ("imu", "f8", (2, 6)),  # a frame's two samples: specific force, rate
        ("stuck", "i8"),  # bits of the senses that repeat themselves
        ("imu_bias", "f8", 6),
        ("imu_scale", "f8", 6),  # 1 is right
        ("imu_white", "f8", 2),  # 1 σ of a sample: accelerometer, gyro
        ("imu_walk", "f8", 2),  # 1 σ of a sample's bias step
        ("baro_alt_m", "f8"),
        ("baro_drift_m", "f8"),
        ("baro_noise_m", "f8"),
        ("baro_drift_sigma_m", "f8"),
        ("baro_wash_m", "f8"),
        ("baro_speed_share", "f8"),
        ("baro_offset_m", "f8"),
        ("mag_frd_gauss", "f8", 3),
        ("mag_noise_gauss", "f8"),
        ("field_ned_gauss", "f8", 3),
        ("disturbance_ned_gauss", "f8", 3),
        ("home", "f8", 3),  # lat_deg, lon_deg, alt_m
        ("fix", "f8", (16, 6)),  # lat, lon, alt, velocity, by frame number modulo 16, until they arrive
        ("fix_valid", "i8", 16),
        ("fix_wander_m", "f8", 3),
        ("fix_offset_m", "f8"),  # north
        ("fix_drift_m", "f8"),  # north
        ("fix_drift_mps", "f8"),
        ("multipath", "f8", 3),  # of unit variance
        ("multipath_sigma_m", "f8"),
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
    """One SENSED at power-on; `normals` set the IMU's biases and scales, the baro's drift, the fix's wander."""
    sensed = np.zeros(1, SENSED)
    s = sensed[0]
    s["home"] = home.lat_deg, home.lon_deg, home.alt_amsl_m
    s["field_ned_gauss"], s["imu_scale"] = field_ned_gauss, 1.0
    if not noise:
        return sensed
    rate_hz = 1.0 / IMU_S
    s["imu_white"] = senses.accel_noise_mps2_rthz * rate_hz**0.5, senses.gyro_noise_radps_rthz * rate_hz**0.5
    s["imu_walk"] = senses.accel_walk_mps3_rthz * IMU_S**0.5, senses.gyro_walk_radps2_rthz * IMU_S**0.5
    s["imu_bias"][:3] = senses.accel_bias_mps2 * normals[:3]
    s["imu_bias"][3:] = senses.gyro_bias_radps * normals[3:6]
    s["baro_noise_m"], s["baro_drift_sigma_m"] = senses.baro_noise_m, senses.baro_drift_m
    s["imu_scale"][:3] += senses.accel_scale * normals[10:13]
    s["imu_scale"][3:] += senses.gyro_scale * normals[13:16]
    s["baro_drift_m"] = senses.baro_drift_m * normals[6]
    s["baro_wash_m"], s["baro_speed_share"] = senses.baro_wash_m, senses.baro_speed_share
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
    s, bias, scale, stuck = sensed.imu, sensed.imu_bias, sensed.imu_scale, sensed.stuck
    for i in range(3):
        s[slot, i] = scale[i] * force[i] + bias[i] + sensed.imu_white[0] * normals[i]
        s[slot, 3 + i] = scale[3 + i] * rate[i] + bias[3 + i] + sensed.imu_white[1] * normals[3 + i]
        if stuck & _ACCEL_STUCK:
            s[slot, i] = s[1 - slot, i]
        if stuck & _GYRO_STUCK:
            s[slot, 3 + i] = s[1 - slot, 3 + i]
        sensed.imu_bias[i] += sensed.imu_walk[0] * normals[6 + i]
        sensed.imu_bias[3 + i] += sensed.imu_walk[1] * normals[9 + i]


@kernel
def measure_baro(
    sensed: np.record, down_m: float, load: float, airspeed_mps: float, normals: FloatArray
) -> None:
    """Take a pressure height. `load` is the rotors' thrust by the weight."""
    decay = math.exp(-BARO_S / _BARO_DRIFT_TIME_S)
    fresh = sensed.baro_drift_sigma_m * math.sqrt(1.0 - decay * decay)
    sensed.baro_drift_m = decay * sensed.baro_drift_m + fresh * normals[1]
    if sensed.stuck & _BARO_STUCK:
        return
    wash = sensed.baro_wash_m * load
    stream = sensed.baro_speed_share * airspeed_mps * airspeed_mps / (2.0 * GRAVITY_MPS2)
    error = sensed.baro_drift_m + wash + stream + sensed.baro_offset_m + sensed.baro_noise_m * normals[0]
    sensed.baro_alt_m = sensed.home[2] - down_m + error


@kernel
def measure_mag(sensed: np.record, q_ned_frd: FloatArray, normals: FloatArray) -> None:
    """Take the field along the body axes."""
    if sensed.stuck & _MAG_STUCK:
        return
    f, d = sensed.field_ned_gauss, sensed.disturbance_ned_gauss
    q = (q_ned_frd[0], q_ned_frd[1], q_ned_frd[2], q_ned_frd[3])
    field = unrotate(q, (f[0] + d[0], f[1] + d[1], f[2] + d[2]))
    for i in range(3):
        sensed.mag_frd_gauss[i] = field[i] + sensed.mag_noise_gauss * normals[i]


def measure_range(height_m: float, q_ned_frd: FloatArray) -> float:
    """What a range finder that looks along down reads over level ground, without error, as PX4's SIH has it."""
    _, x, y, _ = q_ned_frd.tolist()
    along = 1.0 - 2.0 * (x * x + y * y)
    return max(0.0, height_m) / along if along > 0.0 else math.inf


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
    bounce, soon = sensed.multipath, math.exp(-GPS_S / _MULTIPATH_TIME_S)
    for i in range(3):
        bounce[i] = soon * bounce[i] + math.sqrt(1.0 - soon * soon) * normals[9 + i]
    sigma = sensed.multipath_sigma_m
    sensed.fix_drift_m += GPS_S * sensed.fix_drift_mps
    slot = frame % 16
    sensed.fix_valid[slot] = received
    if sensed.stuck & _FIX_STUCK:
        for i in range(6):
            sensed.fix[slot, i] = sensed.fix[(frame - 10) % 16, i]
        return
    away = sensed.fix_offset_m + sensed.fix_drift_m
    place = geodetic_of_ned(
        (sensed.home[0], sensed.home[1], sensed.home[2]),
        (
            position_ned_m[0] + e[0] + white_h * normals[3] + sigma * bounce[0] + away,
            position_ned_m[1] + e[1] + white_h * normals[4] + sigma * bounce[1],
            position_ned_m[2] + e[2] + white_v * normals[5] + sigma * bounce[2],
        ),
    )
    for i in range(3):
        sensed.fix[slot, i] = place[i]
        sensed.fix[slot, 3 + i] = velocity_ned_mps[i] + speed * normals[6 + i]
