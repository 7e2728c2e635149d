"""filterpy's `ExtendedKalmanFilter` as it stands: what the kernels are judged by, and can be flown instead of."""

from __future__ import annotations

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from sitl.estimator.error_state import STATES, inject, transition
from sitl.estimator.strapdown import PREDICT_S
from sitl.kernels import FloatArray

__all__ = ["StockFilter"]


class StockFilter(ExtendedKalmanFilter):  # type: ignore[misc]  # filterpy carries no types
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
        if ((z - expected) ** 2 / np.diag(H @ self.P @ H.T + R)).max() > gate * gate:
            return False
        self.update(z, lambda _: H, lambda _: expected, R=R)
        inject(self._nav, self.x, self.P)
        self.x[:] = 0.0
        return True
