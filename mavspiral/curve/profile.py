"""One number along a path as a uniform quintic B-spline of the phase, C⁴: a height, a yaw, a pitch.

One degree more than a time law needs: the third derivative has no kinks, which a law that looks at it here and there
would miss.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.lib.stride_tricks import sliding_window_view
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray, locked

__all__ = ["Profile"]

DEGREE = 5
SPREAD = 2


def _basis() -> FloatArray:
    """Coefficients `(order, knot, power)` of the pieces that weigh the knots of a span, and of their derivatives.

    Cox and de Boor's recursion for equal spans: w_k = ((t + d − k)·w′_{k−1} + (1 − t + k)·w′_k)/d, with w′ of degree d − 1.
    """
    pieces = [Polynomial([1.0])]
    for degree in range(1, DEGREE + 1):
        before = [Polynomial([0.0]), *pieces, Polynomial([0.0])]
        pieces = [
            (Polynomial([degree - k, 1.0]) * before[k] + Polynomial([1.0 + k, -1.0]) * before[k + 1]) / degree
            for k in range(degree + 1)
        ]
    basis = np.zeros((4, DEGREE + 1, DEGREE + 1))
    for order in range(4):
        for k, piece in enumerate(pieces):
            coefficients = (piece.deriv(order) if order else piece).coef
            basis[order, k, : len(coefficients)] = coefficients
    return basis


BASIS = _basis()


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """A quintic B-spline: `profile(u_rad, order)`.

    `knots` (M,) serve the phases up to (M − 5)·knot_rad: span j mixes the knots j to j + 5, so that knot i has weight
    from (i − 5)·knot_rad to (i + 1)·knot_rad only. The weights are convex.
    """

    knots: FloatArray
    knot_rad: float

    def __post_init__(self) -> None:
        """Copies, checks and locks the knots."""
        object.__setattr__(self, "knots", locked(self.knots, shape=(None,), name="knots"))
        if len(self.knots) <= DEGREE or not self.knot_rad > 0.0:
            raise ValueError(f"{len(self.knots)} knots {self.knot_rad} apart, wanted 6 or more, apart")

    @classmethod
    def above(cls, u_rad: FloatArray, values: FloatArray, knot_rad: float, spans: int) -> Profile:
        """A profile of so many spans that is nowhere below `values` at rising `u_rad`.

        A knot must be as high as the highest value where it has weight. It is the mean, over `SPREAD` knots each way,
        of what is the highest of those within as many: no less than that, and gentle.
        """
        first = np.searchsorted(u_rad, (np.arange(spans + DEGREE) - DEGREE) * knot_rad - 1e-9)
        last = np.searchsorted(u_rad, (np.arange(spans + DEGREE) + 1) * knot_rad + 1e-9)
        least = np.array([values[a:b].max() for a, b in zip(first, last, strict=True)])
        for take in (np.max, np.mean):
            windows = sliding_window_view(np.pad(least, SPREAD, mode="edge"), 2 * SPREAD + 1)
            least = take(windows, axis=1)
        return cls(least, knot_rad)

    @classmethod
    def along(cls, u_rad: FloatArray, values: FloatArray, knot_rad: float, spans: int) -> Profile:
        """A profile of so many spans whose knots are `values`, given at rising `u_rad`, at the knots' middles."""
        middles = (np.arange(spans + DEGREE) - 0.5 * (DEGREE - 1)) * knot_rad
        return cls(np.interp(middles, u_rad, values), knot_rad)

    def __call__(self, u_rad: ArrayLike, order: int = 0) -> FloatArray:
        """The value `(…)`, or its derivative of `order` up to 3."""
        if order not in (0, 1, 2, 3):
            raise ValueError(f"order is {order}, wanted 0 to 3")
        derivative: FloatArray = self.jerked(u_rad)[order]
        return derivative

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The value and two derivatives, `(3, …)`."""
        return self.jerked(u_rad)[:3]

    def jerked(self, u_rad: ArrayLike) -> FloatArray:
        """The value and three derivatives, `(4, …)`."""
        u = np.asarray(u_rad, dtype=np.float64)
        jet: FloatArray = _mixed(np.ascontiguousarray(u.ravel()), self.knots, self.knot_rad, BASIS)
        return jet.reshape(4, *u.shape)


@njit(cache=True)
def _mixed(u: FloatArray, knots: FloatArray, knot_rad: float, basis: FloatArray) -> FloatArray:
    """The jet at phases `(M,)`, `(4, M)`."""
    out = np.zeros((4, u.size))
    weights = basis.shape[1]
    spans = knots.size - weights + 1
    for i in range(u.size):
        span = min(max(int(np.floor(u[i] / knot_rad)), 0), spans - 1)
        t = min(max(u[i] / knot_rad - span, 0.0), 1.0)
        for order in range(4):
            value = 0.0
            for k in range(weights):
                b = basis[order, k, weights - 1]
                for power in range(weights - 2, -1, -1):
                    b = b * t + basis[order, k, power]
                value += b * knots[span + k]
            out[order, i] = value / knot_rad**order
    return out
