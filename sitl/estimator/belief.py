"""What the estimator tells of itself, as kernels: its estimate at the output, and whether the place is known."""

from __future__ import annotations

import math

import numpy as np

from sitl.estimator.fusion import ALONE_FRAMES, BARO_BIAS_TIME_S, DEAD_RECKONING_FRAMES
from sitl.estimator.strapdown import PREDICT_S
from sitl.kernels import FloatArray, Triple, kernel
from sitl.rotation import matrix

__all__ = ["BELIEF_N", "believe", "knows_place", "wander_m2"]

BELIEF_N = 31
_BARO_DRIFT_TIME_S = 300.0


@kernel
def wander_m2(navs: np.ndarray, books: np.ndarray, sheets: np.ndarray) -> Triple:
    """What NED position's variance has beyond P: the wander of its frame.

    Without fixes height is the barometer's, less the mean of its drift over the last BARO_BIAS_TIME before:
    a Gauss-Markov process now against an exponential mean of it then.
    """
    sheet, lost_frames = sheets[0], navs[0].frame - books[0].fix_frame
    down_m2 = sheet.wander_m2[2]
    if lost_frames > ALONE_FRAMES:
        share = _BARO_DRIFT_TIME_S / (_BARO_DRIFT_TIME_S + BARO_BIAS_TIME_S)
        kept = math.exp(-lost_frames * PREDICT_S / _BARO_DRIFT_TIME_S)
        down_m2 += sheet.baro_drift_m2 * (1.0 + share - 2.0 * kept * share)
    return sheet.wander_m2[0], sheet.wander_m2[1], down_m2


@kernel
def believe(
    navs: np.ndarray, books: np.ndarray, sheets: np.ndarray, P: FloatArray, belief: FloatArray
) -> None:
    """Fill `belief`, (31,), with what an Estimate says.

    Position, velocity, q, rate, acceleration, gyro and accelerometer bias; then NED variances of position, velocity
    and attitude. Position's variance is carried from the horizon to the output.
    """
    nav = navs[0]
    q, ahead_s = nav.out_q_ned_frd, (nav.horizon_frames - 1) * PREDICT_S
    for i in range(4):
        belief[6 + i] = q[i]
    r = matrix((q[0], q[1], q[2], q[3]))
    wander = wander_m2(navs, books, sheets)
    for i in range(3):
        belief[i] = nav.out_position_ned_m[i]
        belief[3 + i] = nav.out_velocity_ned_mps[i]
        belief[10 + i] = nav.out_rate_frd_radps[i]
        belief[13 + i] = nav.out_acceleration_ned_mps2[i]
        belief[16 + i] = nav.gyro_bias[i]
        belief[19 + i] = nav.accel_bias[i]
        belief[22 + i] = P[i, i] + ahead_s * (2.0 * P[i, 3 + i] + ahead_s * P[3 + i, 3 + i]) + wander[i]
        belief[25 + i] = P[3 + i, 3 + i]
        belief[28 + i] = 0.0
        for j in range(3):
            for k in range(3):
                belief[28 + i] += r[i][j] * P[6 + j, 6 + k] * r[i][k]


@kernel
def knows_place(navs: np.ndarray, books: np.ndarray, sheets: np.ndarray, P: FloatArray) -> bool:
    """Whether fixes are fresh and the horizontal position's variance, both axes together, is no more: PX4's eph, squared."""
    nav, sheet = navs[0], sheets[0]
    if not nav.running or nav.frame - books[0].fix_frame > DEAD_RECKONING_FRAMES:
        return False
    north_m2, east_m2 = P[0, 0] + sheet.wander_m2[0], P[1, 1] + sheet.wander_m2[1]
    return bool(north_m2 + east_m2 <= sheet.eph_max_m2)
