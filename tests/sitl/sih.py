"""PX4's simulation in hardware as it was when its tracking was measured, for the vehicle's own physics.

Source: PX4 v1.17, sih.cpp, SensorGpsSim.cpp, SensorMagSim.cpp (what they add, all of it white: IMU at 250 Hz, a fix
at 8 Hz that arrives at once, no bias and no error of scale), EKF2's defaults (by what it judges them at its 100 Hz) and
output_predictor.cpp (the output follows the filter with a quarter of a second, from a horizon 0.2 s back: EKF2_DELAY_MAX).
The body is that of sih_params.c. Rates that are not ours are met by equal densities, noises that differ by axis by the root of their mean square.
"""

import dataclasses
import math

import numpy as np

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


_MASS_KG, _THRUST_N, _ARM_M = 1.0, 5.0, 0.2  # SIH_MASS; of a rotor, SIH_T_MAX; SIH_L_ROLL, SIH_L_PITCH
_SPEED_RADPS = 1000.0  # any: SIH has no propellers
_DRAG_NSPM = 1.0  # SIH_KDV


def airframe(x500: Airframe) -> Airframe:
    """SIH's own quadrotor with its own drag, which here its rotors have: as much when they carry the weight.

    Its thrust lags and is linear in the signal; here the speed does, and THR_MDL_FAC undoes the square. Of `x500` it has
    legs and battery.
    """
    k = _THRUST_N / _SPEED_RADPS**2
    hover_radps = math.sqrt(_MASS_KG * 9.80665 / 4.0 / k)
    place = np.array([[1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]]) * _ARM_M
    rotors = dataclasses.replace(
        x500.rotors,
        position_frd_m=place,
        thrust_n_per_radps2=k,
        torque_per_thrust_m=0.1 / _THRUST_N,  # SIH_Q_MAX
        drag_n_per_radps_mps=_DRAG_NSPM / (4.0 * hover_radps),
        time_constant_up_s=0.05,  # SIH_T_TAU
        time_constant_down_s=0.05,
        speed_max_radps=_SPEED_RADPS,
    )
    inertia = np.array([0.025, 0.025, 0.030])  # SIH_IXX and so on
    body = dataclasses.replace(x500.body, mass_kg=_MASS_KG, inertia_kgm2=inertia, drag_area_m2=np.zeros(3))
    params = {"MPC_THR_HOVER": _MASS_KG * 9.80665 / (4.0 * _THRUST_N), "THR_MDL_FAC": 1.0}
    return dataclasses.replace(x500, body=body, rotors=rotors, params=params)


def config(airframe: Airframe) -> dict:
    """A vehicle's config with SIH's noise, judged and followed as EKF2 does."""
    return {
        "airframe": dataclasses.replace(airframe, senses=NOISE),
        "gps": FIX,
        "supposed": (_EKF2, _EKF2_FIX),
        "output_observer": True,
    }
