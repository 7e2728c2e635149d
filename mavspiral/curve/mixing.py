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


@njit(cache=True, nogil=True)
def mixed_series(
    u: FloatArray, spectra: FloatArray, of_key: NDArray[np.int64], key_rad: float, basis: FloatArray
) -> FloatArray:
    """Σ b_k(u)·s_k(u) at phases `(M,)` and its three derivatives, `(4, M, 3)`, with zeros for the height.

    By Leibniz' rule: with c_j = Σ_k b_k⁽ʲ⁾·c_k the spectrum that the j-th derivatives of the weights mix, derivative m is
    Re Σ_n Σ_j C(m, j)·(in)^(m−j)·c_j·e^{inu}. Rows of `spectra` (U, 4, N+1): real and imaginary east, then north.
    Keys that all have one outline are that outline, and only c_0 is there.
    """
    harmonics = spectra.shape[2]
    spans = of_key.size - 4
    mixed = np.zeros((4, 4, harmonics))
    weight = np.empty(4)
    out = np.zeros((4, u.size, 3))
    for i in range(u.size):
        span = min(max(int(np.floor(u[i] / key_rad)), 0), spans - 1)
        t = min(max(u[i] / key_rad - span, 0.0), 1.0)
        still = True
        for k in range(1, 5):
            still = still and of_key[span + k] == of_key[span]
        c = spectra[of_key[span]]
        if not still:
            mixed[:] = 0.0
            for k in range(5):
                c = spectra[of_key[span + k]]
                for j in range(4):
                    b = basis[j, k, 4]
                    for power in range(3, -1, -1):
                        b = b * t + basis[j, k, power]
                    weight[j] = b / key_rad**j
                    for row in range(4):
                        for m in range(harmonics):
                            mixed[j, row, m] += weight[j] * c[row, m]
            c = mixed[0]
        # Both axes and all orders in one loop: their sums do not wait for each other.
        x0 = x1 = x2 = x3 = y0 = y1 = y2 = y3 = 0.0
        cos_1, sin_1 = np.cos(u[i]), np.sin(u[i])
        cos, sin = 1.0, 0.0
        for m in range(harmonics):
            n = float(m)
            xp, xq = c[0, m] * cos - c[1, m] * sin, n * (c[0, m] * sin + c[1, m] * cos)
            yp, yq = c[2, m] * cos - c[3, m] * sin, n * (c[2, m] * sin + c[3, m] * cos)
            n2 = n * n
            x0 += xp
            x1 -= xq
            x2 -= n2 * xp
            x3 += n2 * xq
            y0 += yp
            y1 -= yq
            y2 -= n2 * yp
            y3 += n2 * yq
            cos, sin = cos * cos_1 - sin * sin_1, sin * cos_1 + cos * sin_1
        out[0, i, 0], out[1, i, 0], out[2, i, 0], out[3, i, 0] = x0, x1, x2, x3
        out[0, i, 1], out[1, i, 1], out[2, i, 1], out[3, i, 1] = y0, y1, y2, y3
        if still:
            continue
        cos, sin = 1.0, 0.0
        for m in range(harmonics):
            n = float(m)
            for axis in range(2):
                re, im = mixed[:, 2 * axis, m], mixed[:, 2 * axis + 1, m]
                p1, q1 = re[1] * cos - im[1] * sin, re[1] * sin + im[1] * cos
                p2, q2 = re[2] * cos - im[2] * sin, re[2] * sin + im[2] * cos
                p3 = re[3] * cos - im[3] * sin
                out[1, i, axis] += p1
                out[2, i, axis] += p2 - 2.0 * n * q1
                out[3, i, axis] += p3 - 3.0 * n * (q2 + n * p1)
            cos, sin = cos * cos_1 - sin * sin_1, sin * cos_1 + cos * sin_1
    return out
