"""The time law u(t): when to be where on a curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray, locked

__all__ = ["TimeLaw"]


@dataclass(frozen=True, slots=True, eq=False)
class TimeLaw:
    """The phase u(t) from rest to rest: a C² piecewise cubic over equal steps of time.

    Knot k stands at `k · step_s`. Between knots u⃛ is constant, so ü is linear and continuous.

    Raises:
        ValueError: fewer than two knots, lengths that differ, or an end that is not at rest.
    """

    step_s: float
    phase_rad: FloatArray
    phase_rate_radps: FloatArray
    phase_acceleration_radps2: FloatArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the fields."""
        knots = np.size(self.phase_rad)
        if knots < 2 or not self.step_s > 0:
            raise ValueError(f"a time law of {knots} knots, {self.step_s} s apart: wanted at least 2, apart")
        for name in ("phase_rad", "phase_rate_radps", "phase_acceleration_radps2"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(knots,), name=name))
        if self.phase_rate_radps[0] != 0 or self.phase_rate_radps[-1] != 0:
            raise ValueError("a time law must begin and end at rest")

    @property
    def duration_s(self) -> float:
        """Time from rest to rest."""
        return self.step_s * (len(self.phase_rad) - 1)

    @property
    def knots_s(self) -> FloatArray:
        """When each knot is passed."""
        return np.arange(len(self.phase_rad), dtype=np.float64) * self.step_s

    def __call__(self, t_s: ArrayLike, order: int = 0) -> FloatArray:
        """The `order`-th derivative of u at `t_s`, in rad/sᵒʳᵈᵉʳ; t is clipped to [0, duration]."""
        return self.derivatives(t_s)[order]

    def derivatives(self, t_s: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """The values u, u̇, ü, u⃛ at `t_s`; t is clipped to [0, duration]."""
        t = np.asarray(t_s, dtype=np.float64)
        u, v, a, j = _law(
            t.ravel(), self.step_s, self.phase_rad, self.phase_rate_radps, self.phase_acceleration_radps2
        ).reshape(4, *t.shape)
        return u, v, a, j

    def stretched(self, factor: float) -> TimeLaw:
        """The same phases, `factor` times as slow."""
        return TimeLaw(
            self.step_s * factor,
            self.phase_rad,
            self.phase_rate_radps / factor,
            self.phase_acceleration_radps2 / factor**2,
        )


@njit(cache=True)
def _law(t: FloatArray, step: float, u: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
    """The cubics through the knots, and their derivatives, at `t` (M,): `(4, M)`."""
    out = np.empty((4, t.size))
    last = u.size - 1
    per_step = 1.0 / step  # a division takes as long as a dozen products
    for i in range(t.size):
        at = min(max(t[i] * per_step, 0.0), float(last))
        k = min(int(at), last - 1)
        s = (at - k) * step
        j = (a[k + 1] - a[k]) * per_step
        out[0, i] = min(max(u[k] + s * (v[k] + s * (0.5 * a[k] + s * j * (1.0 / 6.0))), u[0]), u[last])
        out[1, i] = v[k] + s * (a[k] + 0.5 * s * j)
        out[2, i] = a[k] + s * j
        out[3, i] = j
    return out
