"""What the camera looks at on a leg, and how fast that passes through its picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from mavspiral.arrays import FloatArray
from mavspiral.curve.mixing import LANES, NEAR_RAD, turned

__all__ = ["Sight"]


@dataclass(frozen=True, slots=True)
class Sight:
    """The place `distance_m` straight ahead of the camera, which no picture may pass faster than `speed_mps`."""

    distance_m: float
    speed_mps: float

    def passing(self, velocity: FloatArray, yaw: FloatArray, pitch: FloatArray) -> FloatArray:
        """How fast the middle of the picture moves over that place, `(n,)`: the way's part and the turning's.

        Args:
            velocity: of the camera in ENU, `(n, 3)`.
            yaw: the gaze `yaw_enu_rad` and its rate, `(2, n)`.
            pitch: the same of the camera's pitch, up positive.

        All rates by time, or all by phase.
        """
        passing: FloatArray = _passing(
            *(np.ascontiguousarray(each) for each in (velocity, yaw, pitch)),
            self.distance_m,
            bool(pitch.any()),
        )
        return passing


@njit(cache=True)
def _passing(
    velocity: FloatArray, yaw: FloatArray, pitch: FloatArray, distance: float, tilted: bool
) -> FloatArray:
    """`Sight.passing`. Where neighbours look in nearly the same direction, their sines are short polynomials."""
    cos, sin = np.empty((2, LANES)), np.empty((2, LANES))
    out = np.empty(len(velocity))
    for first in range(0, len(velocity), LANES):
        lanes = min(LANES, len(velocity) - first)
        for k in range(2 if tilted else 1):
            angle = (yaw if k == 0 else pitch)[0, first : first + lanes]
            farthest = 0.0
            for i in range(lanes):
                farthest = max(farthest, abs(angle[i] - angle[0]))
            if farthest < NEAR_RAD:
                begin_cos, begin_sin = np.cos(angle[0]), np.sin(angle[0])
                for i in range(lanes):
                    cos[k, i], sin[k, i] = turned(begin_cos, begin_sin, angle[i] - angle[0])
            else:
                for i in range(lanes):
                    cos[k, i], sin[k, i] = np.cos(angle[i]), np.sin(angle[i])
        for i in range(lanes):
            at = first + i
            east, north, along = velocity[at, 0], velocity[at, 1], velocity[at, 2]
            across = cos[0, i] * north - sin[0, i] * east
            turning = distance * yaw[1, at]
            if tilted:
                turning *= cos[1, i]
                ahead = cos[0, i] * east + sin[0, i] * north
                along = cos[1, i] * along - sin[1, i] * ahead + distance * pitch[1, at]
            across += turning
            out[at] = np.sqrt(across * across + along * along)
    return out
