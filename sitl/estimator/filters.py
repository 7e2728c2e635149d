"""The arithmetic of the filter that flies: that of filterpy's `ExtendedKalmanFilter`, in kernels."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sitl.estimator.error_state import STATES, inject, predict_covariance
from sitl.estimator.strapdown import PREDICT_S
from sitl.kernels import FloatArray, kernel

__all__ = ["WORK", "KernelFilter", "gated_update"]

ROWS_MAX = 6

WORK = np.dtype(
    [
        ("FP", "f8", (9, STATES)),
        ("fix_ned", "f8", 6),  # place, speed
        ("rows", "i8"),  # of an update's Jacobian, at most ROWS_MAX
        ("first", "i8"),  # its columns before this one, and from `last` on, are zero and not looked at
        ("last", "i8"),
        ("residual", "f8", ROWS_MAX),
        ("H", "f8", (ROWS_MAX, STATES)),
        ("R", "f8", (ROWS_MAX, ROWS_MAX)),
        ("W", "f8", (ROWS_MAX, STATES)),
        ("L", "f8", (ROWS_MAX, ROWS_MAX)),
    ]
)
"""What a prediction and an update work on, so that a frame allocates nothing; none of it lasts."""


@kernel
def _update(x: FloatArray, P: FloatArray, works: np.ndarray) -> None:
    """Move `x` and `P` in place by the residual r, H and R in `works`: P := P - K S Kᵀ, exactly symmetric.

    With S = L Lᵀ and W = P Hᵀ L⁻ᵀ, K S Kᵀ is W Wᵀ, K r is W L⁻¹ r and K is W L⁻¹. It leaves L, Wᵀ and, as the
    residual, L⁻¹ r.
    """
    work = works[0]
    m, residual, H, W, L = work.rows, work.residual, work.H, work.W, work.L
    for a in range(m):
        for i in range(STATES):
            W[a, i] = 0.0
        for j in range(work.first, work.last):
            if H[a, j] != 0.0:
                for i in range(STATES):
                    W[a, i] += P[i, j] * H[a, j]
    for a in range(m):
        for b in range(a + 1):
            total = work.R[a, b]
            for j in range(work.first, work.last):
                if H[a, j] != 0.0:
                    total += H[a, j] * W[b, j]
            for k in range(b):
                total -= L[a, k] * L[b, k]
            L[a, b] = math.sqrt(total) if a == b else total / L[b, b]
    for a in range(m):
        for b in range(a):
            residual[a] -= L[a, b] * residual[b]
            for i in range(STATES):
                W[a, i] -= W[b, i] * L[a, b]
        residual[a] /= L[a, a]
        for i in range(STATES):
            W[a, i] /= L[a, a]
            x[i] += W[a, i] * residual[a]
    for i in range(STATES):
        for a in range(m):
            for j in range(STATES):
                P[i, j] -= W[a, i] * W[a, j]
    for i in range(STATES):
        for j in range(i):
            P[j, i] = P[i, j]


@kernel
def _worst_ratio(P: FloatArray, work: np.record) -> float:
    """The greatest r²/S of the components: what PX4 holds against the gate squared."""
    worst, H = 0.0, work.H
    for a in range(work.rows):
        s = work.R[a, a]
        for i in range(work.first, work.last):
            if H[a, i] != 0.0:
                for j in range(work.first, work.last):
                    s += H[a, i] * P[i, j] * H[a, j]
        worst = max(worst, work.residual[a] * work.residual[a] / s)
    return worst


@kernel
def gated_update(navs: np.ndarray, x: FloatArray, P: FloatArray, works: np.ndarray, gate: float) -> bool:
    """Move the nominal state by the update that stands in `works`; not if a component lies beyond `gate` sigmas."""
    if _worst_ratio(P, works[0]) > gate * gate:
        return False
    _update(x, P, works)
    inject(navs, x, P)
    for i in range(STATES):
        x[i] = 0.0
    return True


class KernelFilter:
    """`StockFilter`'s twin, with `predict` and `update` in kernels that know the transition's zeros.

    It keeps no priors and posteriors beside `x` and `P`. It does not inherit from filterpy's filter, whose import
    brings much of scipy: 0.4 s and 45 MB.
    """

    def __init__(self, nav: np.ndarray, noise: FloatArray) -> None:
        self.x, self.P, self.work = np.zeros(STATES), np.eye(STATES), np.zeros(1, WORK)
        self._nav, self._noise = nav, noise

    def predict(self) -> None:
        """P at the end of the horizon's frame; the error state is zero and stays so."""
        predict_covariance(self.P, self.work["FP"][0], self._nav, self._noise, PREDICT_S)

    def update(self, z: FloatArray, HJacobian: Callable, Hx: Callable, R: FloatArray) -> None:
        """As filterpy's: moves `x` and `P`, and leaves the residual `y`, `K`, `S` and `mahalanobis`."""
        m = z.size
        self.y = z - Hx(self.x)
        self._write(self.y, HJacobian(self.x), R)
        _update(self.x, self.P, self.work)
        L, W, whitened = self.work["L"][0, :m, :m], self.work["W"][0, :m], self.work["residual"][0, :m]
        L = np.tril(L)
        self.S, self.K = L @ L.T, np.linalg.solve(L.T, W).T
        self.mahalanobis = math.sqrt((whitened * whitened).sum())

    def fuse(self, z: FloatArray, expected: FloatArray, H: FloatArray, R: FloatArray, gate: float) -> bool:
        """Move the nominal state by an update, in one call; not if a component lies beyond `gate` sigmas."""
        self._write(z - expected, H, R)
        return bool(gated_update(self._nav, self.x, self.P, self.work, gate))

    def _write(self, residual: FloatArray, H: FloatArray, R: FloatArray) -> None:
        work, m = self.work[0], residual.size
        work["rows"], work["first"], work["last"] = m, 0, STATES
        work["residual"][:m], work["H"][:m], work["R"][:m, :m] = residual, H, R
