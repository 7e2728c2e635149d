"""The greatest of every limited quantity along a trajectory, on a grid of times, and when and where.

Each moment is worked out from the leg's own curve, gaze and law by the chain rule, and only the greatest are kept:
what a `TrajectoryState` of all those moments would show, without writing it down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.motion.trajectory import Leg, Trajectory

__all__ = ["QUANTITIES", "Peaks", "peaks_of"]

QUANTITIES = (
    "speed",
    "climb",
    "descent",
    "acceleration",
    "jerk",
    "yaw rate",
    "yaw acceleration",
    "passing",
    "gimbal rate",
    "height",
)
"""In SI units. *passing* is how fast the middle of the picture moves over what is looked at; 0 on a leg without a sight."""


@dataclass(frozen=True, slots=True, eq=False)
class Peaks:
    """The greatest of each of `QUANTITIES` on a stretch of a leg (10,), when (10,), and where `(10, 3)`."""

    leg: Leg
    greatest: FloatArray
    at_t_s: FloatArray
    at_enu_m: FloatArray


def peaks_of(trajectory: Trajectory, t_s: FloatArray) -> tuple[Peaks, ...]:
    """The peaks at the rising times `(n,)`, of one stretch after the other. Where something is NaN, that is its peak."""
    return tuple(_of_stretch(leg, here_s, begin_s) for leg, here_s, begin_s in trajectory.stretches(t_s))


def _of_stretch(leg: Leg, here_s: FloatArray, begin_s: float) -> Peaks:
    """The peaks at times of one leg, which begins at `begin_s`."""
    u, u1, u2, u3 = leg.law.derivatives(here_s - begin_s)
    way, yaw, tilt = leg.path.jet(u), leg.gaze.jet(u), leg.gimbal_pitch.jet(u)
    passing = np.zeros(len(u)) if leg.sight is None else leg.sight.passing(way[1], yaw[:2], tilt[:2])
    greatest, rows = _greatest(way, yaw, tilt, passing, u1, u2, u3)
    return Peaks(leg, greatest, here_s[rows], way[0, rows])


@njit(cache=True)
def _greatest(
    way: FloatArray,
    yaw: FloatArray,
    tilt: FloatArray,
    passing: FloatArray,
    u1: FloatArray,
    u2: FloatArray,
    u3: FloatArray,
) -> tuple[FloatArray, NDArray[np.int64]]:
    """The greatest of each of `QUANTITIES`, and the first row that has it; NaN is greater than all numbers.

    Of a way `(4, M, 3)` and angles `(3, M)` by u, of what passes by u (M,), and of the law's derivatives.
    """
    greatest, rows = np.full(10, -np.inf), np.zeros(10, dtype=np.int64)
    here = np.empty(10)
    for i in range(u1.size):
        v, a, j = u1[i], u2[i], u3[i]
        v2, v3, va = v * v, v * v * v, 3.0 * v * a
        velocity2 = acceleration2 = jerk2 = 0.0
        for axis in range(3):
            p1, p2, p3 = way[1, i, axis], way[2, i, axis], way[3, i, axis]
            velocity2 += p1 * p1 * v2
            acceleration2 += (p2 * v2 + p1 * a) ** 2
            jerk2 += (p3 * v3 + p2 * va + p1 * j) ** 2
        rise = way[1, i, 2] * v
        here[0], here[1], here[2] = velocity2, max(rise, 0.0), max(-rise, 0.0)
        here[3], here[4] = acceleration2, jerk2
        here[5], here[6] = abs(yaw[1, i] * v), abs(yaw[2, i] * v2 + yaw[1, i] * a)
        here[7], here[8], here[9] = passing[i] * v, abs(tilt[1, i] * v), way[0, i, 2]
        for k in range(10):
            if not here[k] <= greatest[k] and greatest[k] == greatest[k]:
                greatest[k], rows[k] = here[k], i
    for k in (0, 3, 4):  # norms
        greatest[k] = np.sqrt(greatest[k])
    return greatest, rows
