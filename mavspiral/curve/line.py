"""The straight way from one place to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray, locked
from mavspiral.curve import Differentiable

__all__ = ["LinePath"]


@dataclass(frozen=True, slots=True, eq=False)
class LinePath(Differentiable):
    """The segment from `start_enu_m` to `end_enu_m`, at constant speed in `u_rad` from 0 to 1."""

    start_enu_m: FloatArray
    end_enu_m: FloatArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the fields."""
        object.__setattr__(self, "start_enu_m", locked(self.start_enu_m, shape=(3,), name="start_enu_m"))
        object.__setattr__(self, "end_enu_m", locked(self.end_enu_m, shape=(3,), name="end_enu_m"))

    @property
    def u_end_rad(self) -> float:
        """1."""
        return 1.0

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The ENU position and its three derivatives, `(4, …, 3)`."""
        u = np.asarray(u_rad, dtype=np.float64)
        along = self.end_enu_m - self.start_enu_m
        jet = np.zeros((4, *u.shape, 3))
        jet[0] = self.start_enu_m + u[..., None] * along
        jet[1] = along
        return jet
