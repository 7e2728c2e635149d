"""Fourier series mixed by uniform quartic B-splines: the inner loop of a spiral."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray

__all__ = ["BASIS", "DEGREE", "mixed_series"]

DEGREE = 4
"""Quartic: C³. A span of the phase mixes DEGREE + 1 keys."""


def _basis() -> FloatArray:
    """Coefficients `(order, key, power)` of a quartic B-spline's five pieces and of their derivatives."""
    pieces = np.array(
        [[1, -4, 6, -4, 1], [11, -12, -6, 12, -4], [11, 12, -6, -12, 6], [1, 4, 6, 4, -4], [0, 0, 0, 0, 1]]
    )
    basis = np.zeros((4, DEGREE + 1, DEGREE + 1))
    basis[0] = pieces / 24.0
    for order in (1, 2, 3):
        basis[order, :, :-1] = basis[order - 1, :, 1:] * np.arange(1, DEGREE + 1)
    return basis


BASIS = _basis()
"""Of the pieces that weigh the five keys of a span, in ascending powers of the place in the span."""


@njit(cache=True)
def mixed_series(
    u: FloatArray,
    order: int,
    spectra: FloatArray,
    of_key: NDArray[np.int64],
    key_rad: float,
    basis: FloatArray,
) -> FloatArray:
    """The `order`-th derivative of Σ b_k(u)·s_k(u) at phases `(M,)`, by Leibniz' rule.

    With w_j = C(order, j)·b⁽ʲ⁾ a key adds Σ_n c_n·(Σ_j w_j·(in)^(order−j))·e^{inu}; the inner sum is
    (e_0 + e_2·n²) + i·n·(o_1 + o_3·n²). Rows of `spectra` (U, 4, N+1): real and imaginary east, then north.
    Keys that all have one outline are that outline. Arrays over n, not sums, are what a processor works on in
    parallel.
    """
    binomial = np.array([[1, 0, 0, 0], [1, 1, 0, 0], [1, 2, 1, 0], [1, 3, 3, 1]])
    harmonics = spectra.shape[2]
    spans = of_key.size - 4
    n = np.arange(harmonics) * 1.0
    sum_of = np.empty((4, harmonics))
    w = np.zeros(4)
    out = np.empty((u.size, 2))
    for i in range(u.size):
        span = min(max(int(np.floor(u[i] / key_rad)), 0), spans - 1)
        t = min(max(u[i] / key_rad - span, 0.0), 1.0)
        still = True
        for k in range(1, 5):
            still = still and of_key[span + k] == of_key[span]
        sum_of[:] = 0.0
        for k in range(1 if still else 5):
            for j in range(order + 1):
                b = basis[j, k, 4]
                for power in range(3, -1, -1):
                    b = b * t + basis[j, k, power]
                w[j] = binomial[order, j] * b / key_rad**j
            if still:
                w[:] = 0.0
                w[0] = 1.0
            e_0, e_2, o_1, o_3 = w[0], 0.0, 0.0, 0.0
            if order == 1:
                e_0, o_1 = w[1], w[0]
            elif order == 2:
                e_0, e_2, o_1 = w[2], -w[0], w[1]
            elif order == 3:
                e_0, e_2, o_1, o_3 = w[3], -w[1], w[2], -w[0]
            c = spectra[of_key[span + k]]
            for m in range(harmonics):
                square = n[m] * n[m]
                even, odd = e_0 + e_2 * square, n[m] * (o_1 + o_3 * square)
                sum_of[0, m] += c[0, m] * even - c[1, m] * odd
                sum_of[1, m] += c[0, m] * odd + c[1, m] * even
                sum_of[2, m] += c[2, m] * even - c[3, m] * odd
                sum_of[3, m] += c[2, m] * odd + c[3, m] * even
        cos_1, sin_1 = np.cos(u[i]), np.sin(u[i])
        cosine, sine, x, y = 1.0, 0.0, 0.0, 0.0
        for m in range(harmonics):
            x += sum_of[0, m] * cosine - sum_of[1, m] * sine
            y += sum_of[2, m] * cosine - sum_of[3, m] * sine
            cosine, sine = cosine * cos_1 - sine * sin_1, sine * cos_1 + cosine * sin_1
        out[i, 0], out[i, 1] = x, y
    return out
