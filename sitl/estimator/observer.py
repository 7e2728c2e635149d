"""EKF2's output observer: the output follows the filter by and by instead of being made anew.

PX4 v1.17, output_predictor.cpp: what the output was at the horizon's time is compared with the filter; position and
velocity are pulled with EKF2_TAU_POS and EKF2_TAU_VEL and a tenth of an integral, now and in all that is kept; the turn of
each IMU sample takes the attitude's error with half the rate that the delay allows. Height is treated as the other
two axes, which PX4 does otherwise.
"""

from __future__ import annotations

import numpy as np

from sitl.estimator.strapdown import IMU_S, PREDICT_S, RING, catch_up
from sitl.kernels import kernel
from sitl.rotation import multiply

__all__ = ["follow"]

_GAIN = PREDICT_S / 0.25
"""A frame by EKF2_TAU_VEL and EKF2_TAU_POS, at their default."""
_INTEGRAL_SHARE = 0.1


@kernel
def follow(navs: np.ndarray) -> None:
    """Pull the output towards the nominal state at the horizon, once a frame; the first call starts it there."""
    nav = navs[0]
    p, v, q, kept = nav.out_position_ned_m, nav.out_velocity_ned_mps, nav.out_q_ned_frd, nav.outputs
    first = nav.following == 0
    if first:
        catch_up(navs)
        nav.following = 1
    for slot in range(RING):
        if first or slot == nav.frame % RING:
            for i in range(3):
                kept[slot, i], kept[slot, 3 + i] = p[i], v[i]
            for i in range(4):
                kept[slot, 6 + i] = q[i]
    ahead = nav.horizon_frames - 1
    then, h = (nav.frame - ahead) % RING, nav.q_ned_frd
    turn_gain = 0.5 * IMU_S / (ahead * PREDICT_S)
    was = (kept[then, 6], kept[then, 7], kept[then, 8], kept[then, 9])
    error_q = multiply((h[0], -h[1], -h[2], -h[3]), was)
    back = -2.0 if error_q[0] >= 0.0 else 2.0
    for i in range(3):
        nav.turn_rad[i] = back * error_q[1 + i] * turn_gain
    for i in range(6):
        error = nav.pose[i] - kept[then, i]
        nav.output_error[i] += error
        pull = _GAIN * (error + _INTEGRAL_SHARE * _GAIN * nav.output_error[i])
        for slot in range(RING):
            kept[slot, i] += pull
        if i < 3:
            p[i] += pull
        else:
            v[i - 3] += pull
