"""What a time law is found on: a curve, and what is seen from it, at equal steps of its phase."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.curve.gaze import GIMBAL_RADPS
from mavspiral.motion import kernels
from mavspiral.motion.sight import Sight
from mavspiral.motion.turn import Gaze

__all__ = ["Rows"]

FEWEST, MOST = 1_000, 40_000


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Rows of u, `du` apart: the kernels' `table` (n, 11), and what the camera asks for, `blur` (n,).

    That is 1/u̇ of the fastest way past each row that the gimbal follows and that leaves the picture sharp; `(0,)` where
    neither counts.
    """

    table: FloatArray
    du: float
    blur: FloatArray

    @classmethod
    def along(cls, path: Path, gaze: Gaze, pitch: Gaze, sight: Sight | None, grid_m: float) -> Rows:
        """Rows no farther than `grid_m` apart, unless there would be too many.

        Raises:
            ValueError: the curve stands still somewhere (p′ = 0), so that no law can pass.
        """
        u = np.linspace(0.0, path.u_end_rad, _count(path, grid_m))
        way, yaw, tilt = path.jet(u), gaze.jet(u), pitch.jet(u)
        table = kernels.rows(way, yaw)
        still = kernels.first_still(table)
        if still < len(u):
            raise ValueError(f"the curve stands still at u = {u[still]:.6g}: no law can pass there")
        blur: FloatArray = np.abs(tilt[1]) / GIMBAL_RADPS
        if sight is not None:
            blur = np.maximum(blur, sight.passing(way[1], yaw[:2], tilt[:2]) / sight.speed_mps)
        return cls(table, float(u[1]), blur if blur.any() else np.zeros(0))


def _count(path: Path, grid_m: float) -> int:
    coarse = np.linspace(0.0, path.u_end_rad, FEWEST)
    length_m = float(np.linalg.norm(path(coarse, 1), axis=1).mean() * path.u_end_rad)
    return int(np.clip(math.ceil(length_m / grid_m), FEWEST, MOST))
