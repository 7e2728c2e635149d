"""Fourier series mixed by uniform quartic B-splines: the inner loop of a spiral."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray

__all__ = ["BASIS", "DEGREE", "LANES", "NEAR_RAD", "mixed_series", "turned"]

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
LANES = 64
"""So many phases of one span are worked out side by side: the processor takes several at a time."""
NEAR_RAD = 0.4
"""They are no farther than this from the first of them: their sines are then short polynomials, exact to rounding."""


@njit(cache=True)
def turned(cos: float, sin: float, x: float) -> tuple[float, float]:
    """Cosine and sine of an angle that is `x`, up to `NEAR_RAD`, more than the one whose they are given."""
    y = x * x
    even = odd = 1.0
    for m in range(14, 0, -2):
        even = 1.0 - even * y * (1.0 / (m * (m - 1)))
        odd = 1.0 - odd * y * (1.0 / (m * (m + 1)))
    return cos * even - sin * odd * x, sin * even + cos * odd * x


@njit(cache=True)
def mixed_series(
    u: FloatArray, spectra: FloatArray, of_key: NDArray[np.int64], key_rad: float, basis: FloatArray
) -> FloatArray:
    """Σ b_k(u)·s_k(u) at phases `(M,)` and its three derivatives, `(4, M, 3)`, with zeros for the height.

    Leibniz' rule: derivative m of b·s is Σ_j C(m, j)·b⁽ʲ⁾·s⁽ᵐ⁻ʲ⁾. Rows of `spectra` (U, N+1, 4): real and imaginary
    east, then north. Keys that all have one outline are that outline. Phases in order are far quicker than others.
    """
    spans = of_key.size - 4
    turn, wave = np.empty((2, LANES)), np.empty((2, LANES))  # e^{iu} and e^{imu}
    sums = np.empty((2, 4, LANES))
    out = np.zeros((4, u.size, 3))
    first = 0
    while first < u.size:
        begin = u[first]
        span = min(max(int(np.floor(begin / key_rad)), 0), spans - 1)
        lanes = 1
        while lanes < LANES and first + lanes < u.size and abs(u[first + lanes] - begin) < NEAR_RAD:
            if min(max(int(np.floor(u[first + lanes] / key_rad)), 0), spans - 1) != span:
                break
            lanes += 1
        still = True
        for k in range(1, 5):
            still = still and of_key[span + k] == of_key[span]
        begin_cos, begin_sin = np.cos(begin), np.sin(begin)
        for i in range(lanes):
            turn[0, i], turn[1, i] = turned(begin_cos, begin_sin, u[first + i] - begin)
        for k in range(1 if still else 5):
            outline = spectra[of_key[span + k]]
            wave[0], wave[1] = 1.0, 0.0
            sums[:] = 0.0
            for m in range(outline.shape[0]):
                n = float(m)
                n2 = n * n
                for axis in range(2):
                    re, im = outline[m, 2 * axis], outline[m, 2 * axis + 1]
                    for i in range(lanes):
                        p = re * wave[0, i] - im * wave[1, i]
                        q = n * (re * wave[1, i] + im * wave[0, i])
                        sums[axis, 0, i] += p
                        sums[axis, 1, i] -= q
                        sums[axis, 2, i] -= n2 * p
                        sums[axis, 3, i] += n2 * q
                for i in range(lanes):
                    cos, sin = wave[0, i], wave[1, i]
                    wave[0, i] = cos * turn[0, i] - sin * turn[1, i]
                    wave[1, i] = sin * turn[0, i] + cos * turn[1, i]
            for i in range(lanes):
                at = first + i
                if still:
                    for axis in range(2):
                        for order in range(4):
                            out[order, at, axis] = sums[axis, order, i]
                    continue
                t = min(max(u[at] / key_rad - span, 0.0), 1.0)
                b0 = b1 = b2 = b3 = 0.0
                for power in range(4, -1, -1):
                    b0, b1 = b0 * t + basis[0, k, power], b1 * t + basis[1, k, power]
                    b2, b3 = b2 * t + basis[2, k, power], b3 * t + basis[3, k, power]
                b1, b2, b3 = b1 / key_rad, b2 / key_rad**2, b3 / key_rad**3
                for axis in range(2):
                    s0, s1, s2, s3 = sums[axis, 0, i], sums[axis, 1, i], sums[axis, 2, i], sums[axis, 3, i]
                    out[0, at, axis] += b0 * s0
                    out[1, at, axis] += b0 * s1 + b1 * s0
                    out[2, at, axis] += b0 * s2 + 2.0 * b1 * s1 + b2 * s0
                    out[3, at, axis] += b0 * s3 + 3.0 * (b1 * s2 + b2 * s1) + b3 * s0
        first += lanes
    return out
