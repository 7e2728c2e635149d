"""PX4's simulation in hardware as it was when its tracking was measured, for the vehicle's own physics.

Source: PX4 v1.17, sih.cpp, SensorGpsSim.cpp, SensorMagSim.cpp (what they add, all of it white: IMU at 250 Hz, a fix
at 8 Hz that arrives at once, no bias and no error of scale), EKF2's defaults (by what it judges them at its 100 Hz) and
output_predictor.cpp (the output follows the filter with a quarter of a second; EKF2's horizon lies 0.2 s back, ours 0.12).
Rates that are not ours are met by equal densities, noises that differ by axis by the root of their mean square.
"""

import dataclasses
import math

from sitl.airframe import Airframe, Receiver, Senses

_IMU_S, _EKF_S, _FIX_S, _OUR_FIX_S = 0.004, 0.01, 0.125, 0.1
_THIN = math.sqrt(_FIX_S / _OUR_FIX_S)
_NOTHING = dict.fromkeys((field.name for field in dataclasses.fields(Senses)), 0.0)

NOISE = Senses(
    **_NOTHING
    | {
        "accel_noise_mps2_rthz": math.sqrt((0.5**2 + 1.7**2) / 2 * _IMU_S),
        "gyro_noise_radps_rthz": math.sqrt((0.14**2 + 0.07**2) / 2 * _IMU_S),
        "mag_noise_gauss": 0.023,
        "baro_noise_m": 0.14,
    }
)
FIX = Receiver(0.2 * _THIN, 0.5 * _THIN, 0.0, 0.0, 1.0, 0.1 * _THIN, fix_type=3, satellites=10)
_EKF2 = Senses(
    **_NOTHING
    | {
        "accel_noise_mps2_rthz": 0.35 * math.sqrt(_EKF_S),  # EKF2_ACC_NOISE
        "gyro_noise_radps_rthz": 0.015 * math.sqrt(_EKF_S),  # EKF2_GYR_NOISE
        "accel_walk_mps3_rthz": 0.003 * math.sqrt(_EKF_S),  # EKF2_ACC_B_NOISE
        "gyro_walk_radps2_rthz": 0.001 * math.sqrt(_EKF_S),  # EKF2_GYR_B_NOISE
        "accel_bias_mps2": 0.2,  # EKF2_ABIAS_INIT
        "gyro_bias_radps": 0.1,  # EKF2_GBIAS_INIT
        "mag_noise_gauss": 0.05,  # EKF2_MAG_NOISE
        "baro_noise_m": 3.5,  # EKF2_BARO_NOISE
    }
)
_EKF2_FIX = Receiver(0.9 * _THIN, 1.78 * _THIN, 0.0, 0.0, 1.0, 0.4 * _THIN, fix_type=3, satellites=10)


def config(airframe: Airframe) -> dict:
    """A vehicle's config with SIH's noise, judged and followed as EKF2 does."""
    return {
        "airframe": dataclasses.replace(airframe, senses=NOISE),
        "gps": FIX,
        "supposed": (_EKF2, _EKF2_FIX),
        "output_observer": True,
    }
