"""Height along the spiral: a level turn, a climb at exactly the same rate everywhere, a level turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray

__all__ = ["BLEND_RAD", "Climb"]

BLEND_RAD = 0.5 * np.pi
"""Over which the slope grows from nothing to the climb's."""

_RAMP = (
    np.polynomial.Polynomial([0.0, 0.0, 0.0, 0.0, 2.5, -3.0, 1.0]),
    np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0]),
    np.polynomial.Polynomial([0.0, 0.0, 30.0, -60.0, 30.0]),
    np.polynomial.Polynomial([0.0, 60.0, -180.0, 120.0]),
)
"""The integral of the smoothstep 10t³ − 15t⁴ + 6t⁵ on [0, 1], and its derivatives."""


@dataclass(frozen=True, slots=True)
class Climb:
    """The height of the spiral, C³: a level turn, `turns` turns of equal rise, and level again at the top.

    The slope grows after the level turn and dies out after the last turn, each over `BLEND_RAD`, so the
    climb takes that much longer than its turns.
    """

    bottom_m: float
    top_m: float
    turns: int

    @property
    def end_rad(self) -> float:
        """Where the top is reached."""
        return 2.0 * np.pi + (2.0 * np.pi * self.turns + BLEND_RAD if self.turns else 0.0)

    def __call__(self, u_rad: ArrayLike, order: int = 0) -> FloatArray:
        """The height in m, or its derivative of `order` up to 3."""
        u = np.asarray(u_rad, dtype=np.float64)
        level = np.full(u.shape, self.bottom_m if order == 0 else 0.0)
        if not self.turns:
            return level
        slope = (self.top_m - self.bottom_m) / (2.0 * np.pi * self.turns)
        begin, end = 2.0 * np.pi, 2.0 * np.pi * (self.turns + 1)
        return level + slope * (_ramp(u - begin, order) - _ramp(u - end, order))


def _ramp(x: FloatArray, order: int) -> FloatArray:
    """A function whose slope is 0 before 0 and 1 after `BLEND_RAD`, or its derivative of `order`."""
    t = np.clip(x / BLEND_RAD, 0.0, 1.0)
    value = _RAMP[order](t) * BLEND_RAD ** (1 - order)
    if order == 0:
        value = value + np.maximum(x - BLEND_RAD, 0.0)
    return np.asarray(value)
