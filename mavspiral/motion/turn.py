"""What a gaze is, and the gaze of a transit: from one yaw to another, the short way round."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray
from mavspiral.curve import Differentiable
from mavspiral.frames import wrap_rad

__all__ = ["LEVEL", "Gaze", "TurnGaze"]

# 10x³ - 15x⁴ + 6x⁵: the quintic with zero slope and zero curvature at 0 and 1.
_SMOOTH_STEP = np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
_DERIVATIVES = tuple(_SMOOTH_STEP.deriv(order) if order else _SMOOTH_STEP for order in range(3))


class Gaze(Protocol):
    """A C² yaw along a curve: `gaze(u_rad, order)`, unwrapped."""

    def __call__(self, u_rad: ArrayLike, order: int = 0) -> FloatArray:
        """The yaw `yaw_enu_rad`, or its derivative of `order` up to 2, in rad/radᵒʳᵈᵉʳ."""
        ...

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The yaw and its two derivatives, `(3, …)`."""
        ...


@dataclass(frozen=True, slots=True)
class TurnGaze(Differentiable):
    """From one yaw the short way round to another as u goes from 0 to `u_end_rad`."""

    yaw_start_enu_rad: float
    yaw_end_enu_rad: float
    u_end_rad: float = 1.0

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The yaw and its two derivatives, `(3, …)`."""
        u = np.asarray(u_rad, dtype=np.float64)
        jet = np.zeros((3, *u.shape))
        turn_rad = float(wrap_rad(self.yaw_end_enu_rad - self.yaw_start_enu_rad))
        if turn_rad:
            x = np.clip(u / self.u_end_rad, 0.0, 1.0)
            for order, step in enumerate(_DERIVATIVES):
                jet[order] = turn_rad / self.u_end_rad**order * step(x)
        jet[0] += self.yaw_start_enu_rad
        return jet


LEVEL = TurnGaze(0.0, 0.0)
"""A camera that is not tilted."""
