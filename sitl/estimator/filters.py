"""The arithmetic of the filter that flies: that of filterpy's `ExtendedKalmanFilter`, in kernels."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sitl.estimator.error_state import STATES, inject, predict_covariance
from sitl.estimator.strapdown import PREDICT_S
from sitl.kernels import FloatArray, kernel

__all__ = ["KernelFilter", "gated_update", "worst_ratio"]


@kernel
def _update(
    x: FloatArray, P: FloatArray, residual: FloatArray, H: FloatArray, R: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """K, S and L⁻¹ r of an update that moves `x` and `P` in place, P := P - K S Kᵀ exactly symmetric.

    With S = L Lᵀ and W = P Hᵀ L⁻ᵀ, K S Kᵀ is W Wᵀ, K r is W L⁻¹ r and K is W L⁻¹.
    """
    m, n = H.shape
    PHt = np.zeros((n, m))
    for i in range(n):
        for k in range(m):
            total = 0.0
            for j in range(n):
                if H[k, j] != 0.0:
                    total += P[i, j] * H[k, j]
            PHt[i, k] = total
    S = R.copy()
    for a in range(m):
        for b in range(m):
            for j in range(n):
                if H[a, j] != 0.0:
                    S[a, b] += H[a, j] * PHt[j, b]
    L = np.zeros((m, m))
    for a in range(m):
        for b in range(a + 1):
            total = S[a, b]
            for k in range(b):
                total -= L[a, k] * L[b, k]
            L[a, b] = math.sqrt(total) if a == b else total / L[b, b]
    W = PHt.copy()
    whitened = residual.copy()
    for a in range(m):
        for b in range(a):
            whitened[a] -= L[a, b] * whitened[b]
            for i in range(n):
                W[i, a] -= W[i, b] * L[a, b]
        whitened[a] /= L[a, a]
        for i in range(n):
            W[i, a] /= L[a, a]
    for i in range(n):
        for a in range(m):
            x[i] += W[i, a] * whitened[a]
        for j in range(i + 1):
            total = P[i, j]
            for a in range(m):
                total -= W[i, a] * W[j, a]
            P[i, j] = P[j, i] = total
    for a in range(m - 1, -1, -1):
        for b in range(a + 1, m):
            for i in range(n):
                W[i, a] -= W[i, b] * L[b, a]
        for i in range(n):
            W[i, a] /= L[a, a]
    return W, S, whitened


@kernel
def worst_ratio(P: FloatArray, residual: FloatArray, H: FloatArray, R: FloatArray) -> float:
    """The greatest r²/S of the components: what PX4 holds against the gate squared."""
    worst = 0.0
    for a in range(H.shape[0]):
        s = R[a, a]
        for i in range(STATES):
            if H[a, i] != 0.0:
                for j in range(STATES):
                    s += H[a, i] * P[i, j] * H[a, j]
        worst = max(worst, residual[a] * residual[a] / s)
    return worst


@kernel
def gated_update(
    navs: np.ndarray,
    x: FloatArray,
    P: FloatArray,
    z: FloatArray,
    expected: FloatArray,
    H: FloatArray,
    R: FloatArray,
    gate: float,
) -> bool:
    """Move the nominal state by an update; not if a component lies beyond `gate` sigmas."""
    residual = np.empty(z.size)
    for a in range(z.size):
        residual[a] = z[a] - expected[a]
    if worst_ratio(P, residual, H, R) > gate * gate:
        return False
    _update(x, P, residual, H, R)
    inject(navs, x, P)
    for i in range(x.size):
        x[i] = 0.0
    return True


class KernelFilter:
    """`StockFilter`'s twin, with `predict` and `update` in kernels that know the transition's zeros.

    It keeps no priors and posteriors beside `x` and `P`. It does not inherit from filterpy's filter, whose import
    brings much of scipy: 0.4 s and 45 MB.
    """

    def __init__(self, nav: np.ndarray, noise: FloatArray) -> None:
        self.x, self.P = np.zeros(STATES), np.eye(STATES)
        self._nav, self._noise, self._work = nav, noise, np.zeros((STATES, STATES))

    def predict(self) -> None:
        """P at the end of the horizon's frame; the error state is zero and stays so."""
        predict_covariance(self.P, self._work, self._nav, self._noise, PREDICT_S)

    def update(self, z: FloatArray, HJacobian: Callable, Hx: Callable, R: FloatArray) -> None:
        """As filterpy's: moves `x` and `P`, and leaves the residual `y`, `K`, `S` and `mahalanobis`."""
        self.y = z - Hx(self.x)
        self.K, self.S, whitened = _update(self.x, self.P, self.y, HJacobian(self.x), R)
        self.mahalanobis = math.sqrt((whitened * whitened).sum())

    def fuse(self, z: FloatArray, expected: FloatArray, H: FloatArray, R: FloatArray, gate: float) -> bool:
        """Move the nominal state by an update, in one call; not if a component lies beyond `gate` sigmas."""
        return bool(gated_update(self._nav, self.x, self.P, z, expected, H, R, gate))
