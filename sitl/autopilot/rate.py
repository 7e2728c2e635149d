"""Body rates to torque: PX4's PID on filtered gyros; the derivative is the measurement's, not the error's."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sitl.kernels import FloatArray, kernel

__all__ = ["LowPass", "control_rate", "filter_gyro", "low_pass"]

_FADE_RADPS = math.radians(400.0)


class LowPass(NamedTuple):
    """A second-order Butterworth low-pass, direct form II."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


def low_pass(sample_hz: float, cutoff_hz: float) -> LowPass:
    """The filter by the bilinear transform."""
    k = math.tan(math.pi * cutoff_hz / sample_hz)
    norm = 1.0 + math.sqrt(2.0) * k + k * k
    b = k * k / norm
    return LowPass(b, 2.0 * b, b, 2.0 * (k * k - 1.0) / norm, (1.0 - math.sqrt(2.0) * k + k * k) / norm)


@kernel
def filter_gyro(mind: np.record, gains: np.record, rate_frd_radps: FloatArray, dt: float) -> None:
    """Take a gyro sample into `mind.rate_frd_radps` and its slope (IMU_GYRO_CUTOFF, IMU_DGYRO_CUTOFF)."""
    b0, b1, b2, a1, a2 = gains.gyro[0], gains.gyro[1], gains.gyro[2], gains.gyro[3], gains.gyro[4]
    for i in range(3):
        fresh = rate_frd_radps[i] - a1 * mind.gyro_delay[i, 0] - a2 * mind.gyro_delay[i, 1]
        out = b0 * fresh + b1 * mind.gyro_delay[i, 0] + b2 * mind.gyro_delay[i, 1]
        mind.gyro_delay[i, 1] = mind.gyro_delay[i, 0]
        mind.gyro_delay[i, 0] = fresh
        rise = (out - mind.rate_frd_radps[i]) / dt
        mind.rate_frd_radps[i] = out
        mind.rate_slope[i] += gains.rate_slope_alpha * (rise - mind.rate_slope[i])


@kernel
def control_rate(mind: np.record, gains: np.record, dt: float) -> None:
    """Set `mind.torque`; integrate where the mixer had room the last time."""
    for i in range(3):
        wanted = mind.rate_wanted_frd_radps[i]
        error = wanted - mind.rate_frd_radps[i]
        mind.torque[i] = (
            gains.rate_p[i] * error
            + mind.rate_integral[i]
            - gains.rate_d[i] * mind.rate_slope[i]
            + gains.rate_ff[i] * wanted
        )
        if (error > 0.0 and mind.saturated[i] > 0) or (error < 0.0 and mind.saturated[i] < 0):
            continue
        fade = max(0.0, 1.0 - (error / _FADE_RADPS) ** 2)
        limit = gains.rate_integral_max[i]
        grown = mind.rate_integral[i] + fade * gains.rate_i[i] * error * dt
        mind.rate_integral[i] = min(max(grown, -limit), limit)
    # PX4 1.17 smooths the yaw torque alone: weak, it saturates motors first (MC_YAW_TQ_CUTOFF).
    mind.yaw_torque += gains.yaw_torque_alpha * (mind.torque[2] - mind.yaw_torque)
    mind.torque[2] = mind.yaw_torque
