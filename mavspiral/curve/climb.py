"""Height along the spiral: a level turn, a climb at exactly the same rate everywhere, a level turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray

__all__ = ["BLEND_RAD", "Climb"]

BLEND_RAD = 0.5 * np.pi
"""Over which the slope grows from nothing to the climb's."""


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
        jet = np.zeros((4, u.size, 1))
        self.put(u.ravel(), jet[:, :, 0])
        height: FloatArray = jet[order].reshape(u.shape)
        return height

    def put(self, u_rad: FloatArray, jet: FloatArray) -> None:
        """Write height and three derivatives at `u_rad` (M,) into `jet` (4, M)."""
        slope = (self.top_m - self.bottom_m) / (2.0 * np.pi * max(1, self.turns))
        _climb(u_rad, self.bottom_m, slope, 2.0 * np.pi, 2.0 * np.pi * (self.turns + 1), jet)


@njit(cache=True)
def _climb(u: FloatArray, bottom: float, slope: float, begin: float, end: float, jet: FloatArray) -> None:
    """The climb: `slope` times a ramp that begins at `begin`, less one that begins at `end`.

    A ramp is the integral of a slope that grows from 0 to 1 as the smoothstep 10t³ − 15t⁴ + 6t⁵ over BLEND_RAD.
    """
    per_blend = 1.0 / BLEND_RAD
    level_m = slope * (end - begin)
    for i in range(u.size):
        height, rate, bend, twist = 0.0, 0.0, 0.0, 0.0
        if u[i] >= end + BLEND_RAD:
            height = level_m
        elif u[i] > begin:
            for k in range(2):
                x, sign = (u[i] - begin, slope) if k == 0 else (u[i] - end, -slope)
                if x >= BLEND_RAD:
                    height += sign * (x - 0.5 * BLEND_RAD)
                    rate += sign
                elif x > 0.0:
                    t = x * per_blend
                    t2 = t * t
                    height += sign * BLEND_RAD * t2 * t2 * (2.5 + t * (t - 3.0))
                    rate += sign * t2 * t * (10.0 + t * (6.0 * t - 15.0))
                    bend += sign * 30.0 * t2 * (1.0 - t) ** 2 * per_blend
                    twist += sign * 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) * (per_blend * per_blend)
        jet[0, i], jet[1, i], jet[2, i], jet[3, i] = bottom + height, rate, bend, twist
