"""What the camera looks at on a leg, and how fast that passes through its picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray

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
        sin, cos = np.sin(yaw[0]), np.cos(yaw[0])
        east, north, up = velocity.T
        across = cos * north - sin * east
        if not pitch.any():  # level
            return np.asarray(np.sqrt((across + self.distance_m * yaw[1]) ** 2 + up**2))
        sin_pitch, cos_pitch = np.sin(pitch[0]), np.cos(pitch[0])
        across += self.distance_m * cos_pitch * yaw[1]
        along = cos_pitch * up - sin_pitch * (cos * east + sin * north) + self.distance_m * pitch[1]
        return np.asarray(np.sqrt(across**2 + along**2))
