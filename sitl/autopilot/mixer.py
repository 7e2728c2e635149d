"""Torque and thrust to motors: PX4's sequential desaturation without air mode.

Columns of the mix are scaled as PX4 scales them, so that its gains mean the same here: thrust 1 per motor,
roll and pitch 1/√2 on a symmetric X, yaw 1.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.airframe import Rotors
from sitl.kernels import FloatArray, kernel

__all__ = ["mix", "mix_columns", "signal_for"]

_YAW_MARGIN = 0.15


def mix_columns(rotors: Rotors) -> FloatArray:
    """Rows roll, pitch, yaw, thrust: what each asks of every motor.

    Raises:
        ValueError: the rotors do not lie symmetrically, so that the axes would disturb each other.
    """
    x, y = rotors.position_frd_m[:, 0], rotors.position_frd_m[:, 1]
    columns = np.array([-y, x, rotors.spin, np.ones(4)])
    overlap = (columns[:, None, :] * columns[None, :, :]).sum(axis=2)
    if np.abs(overlap - np.diag(np.diag(overlap))).max() > 1e-9:
        raise ValueError(f"rotors at {rotors.position_frd_m[:, :2].tolist()} are not symmetric")
    columns[:2] /= np.sqrt(2.0 * (columns[:2] ** 2).mean(axis=1))[:, None]
    return columns


@kernel
def _shift(motors: FloatArray, column: FloatArray, most: float) -> float:
    """How much of `column` to add so that the worst overshoots at both ends meet in the middle."""
    low = high = 0.0
    for i in range(4):
        if column[i] == 0.0:
            continue
        k = 0.0
        if motors[i] < 0.0:
            k = -motors[i] / column[i]
        elif motors[i] > most:
            k = (most - motors[i]) / column[i]
        low, high = min(low, k), max(high, k)
    return low + high


@kernel
def _give_way(motors: FloatArray, column: FloatArray, most: float, raised: float) -> None:
    """Share out what overshoots [0, most]; not if that takes more than `raised` of the column."""
    least = min(motors[0], motors[1], motors[2], motors[3])
    if least >= 0.0 and max(motors[0], motors[1], motors[2], motors[3]) <= most:
        return
    first = _shift(motors, column, most)
    if first > raised:
        return
    for i in range(4):
        motors[i] += first * column[i]
    second = 0.5 * _shift(motors, column, most)
    for i in range(4):
        motors[i] += second * column[i]


@kernel
def mix(
    columns: FloatArray, torque: FloatArray, thrust: float, motors: FloatArray, saturated: np.ndarray
) -> None:
    """Set `motors`, each in [0, 1], and on which axes (+1, -1) torque was held back.

    Roll and pitch go before yaw, yaw before the last of the thrust; thrust is never raised for torque's sake.
    """
    for i in range(4):
        motors[i] = torque[0] * columns[0, i] + torque[1] * columns[1, i] + thrust * columns[3, i]
    _give_way(motors, columns[3], 1.0, 0.0)
    _give_way(motors, columns[0], 1.0, math.inf)
    _give_way(motors, columns[1], 1.0, math.inf)
    for i in range(4):
        motors[i] += torque[2] * columns[2, i]
    _give_way(motors, columns[2], 1.0 + _YAW_MARGIN, math.inf)
    _give_way(motors, columns[3], 1.0, 0.0)
    for i in range(4):
        motors[i] = min(max(motors[i], 0.0), 1.0)
    for axis in range(3):
        made = scale = 0.0
        for i in range(4):
            made += columns[axis, i] * motors[i]
            scale += columns[axis, i] ** 2
        short = torque[axis] - made / scale
        saturated[axis] = 0
        if abs(short) > 1e-6:
            saturated[axis] = 1 if short > 0.0 else -1


@kernel
def signal_for(thrust: float, model: float) -> float:
    """The motor signal that gives `thrust` = model·s² + (1 - model)·s (THR_MDL_FAC)."""
    if thrust <= 0.0:
        return 0.0
    rest = 1.0 - model
    return 2.0 * thrust / (rest + math.sqrt(rest * rest + 4.0 * model * thrust))
