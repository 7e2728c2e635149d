"""The arithmetic of the filter that flies: filterpy's `ExtendedKalmanFilter`, in kernels or as it stands."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from sitl.estimator.model import PREDICT_S, STATES, inject, predict_covariance, transition
from sitl.kernels import FloatArray, kernel

__all__ = ["KernelFilter", "StockFilter", "gated_update", "worst_ratio"]


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
    residual = z - expected
    if worst_ratio(P, residual, H, R) > gate * gate:
        return False
    _update(x, P, residual, H, R)
    inject(navs, x, P)
    x[:] = 0.0
    return True


class KernelFilter(ExtendedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter with `predict` and `update` in kernels that know the transition's zeros.

    It keeps no priors and posteriors beside `x` and `P`.
    """

    def __init__(self, nav: np.ndarray, noise: FloatArray) -> None:
        super().__init__(dim_x=STATES, dim_z=6)
        self.x = np.zeros(STATES)
        self._nav, self._noise, self._work = nav, noise, np.zeros((STATES, STATES))

    def predict(self, u: float = 0) -> None:
        """P at the end of the horizon's frame; the error state is zero and stays so."""
        predict_covariance(self.P, self._work, self._nav, self._noise, PREDICT_S)

    def update(  # noqa: D102 - filterpy's own words
        self, z: FloatArray, HJacobian: Callable, Hx: Callable, R: FloatArray, **_: object
    ) -> None:
        self.y = z - Hx(self.x)
        self.K, self.S, whitened = _update(self.x, self.P, self.y, HJacobian(self.x), R)
        self._mahalanobis = math.sqrt((whitened * whitened).sum())

    def fuse(self, z: FloatArray, expected: FloatArray, H: FloatArray, R: FloatArray, gate: float) -> bool:
        """Move the nominal state by an update, in one call; not if a component lies beyond `gate` sigmas."""
        return bool(gated_update(self._nav, self.x, self.P, z, expected, H, R, gate))


class StockFilter(ExtendedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter and arithmetic, given the horizon's transition before each prediction."""

    def __init__(self, nav: np.ndarray, noise: FloatArray) -> None:
        super().__init__(dim_x=STATES, dim_z=6)
        self.x = np.zeros(STATES)
        self._noise = noise
        self._nav = nav

    def predict(self, u: float = 0) -> None:
        """P at the end of the horizon's frame."""
        nav = self._nav[0]
        self.F = transition(nav["mean_q"], nav["mean_force"], nav["mean_rate"], PREDICT_S)
        self.Q = np.diag(self._noise)
        self.Q[range(6, 9), range(6, 9)] += nav["scale_noise_s"] * nav["mean_rate"] ** 2 * PREDICT_S
        super().predict()

    def fuse(self, z: FloatArray, expected: FloatArray, H: FloatArray, R: FloatArray, gate: float) -> bool:
        """Move the nominal state by an update; not if a component lies beyond `gate` sigmas."""
        if worst_ratio(self.P, z - expected, H, R) > gate * gate:
            return False
        self.update(z, lambda _: H, lambda _: expected, R=R)
        inject(self._nav, self.x, self.P)
        self.x[:] = 0.0
        return True
