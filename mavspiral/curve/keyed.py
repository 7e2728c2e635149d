"""Curves whose plan mixes Fourier series, one for every key, by the uniform quartic B-spline."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve import Differentiable
from mavspiral.curve.fourier import ComplexArray, FourierCurve, locked_spectra
from mavspiral.curve.mixing import BASIS, mixed_series

__all__ = ["KeyedPath", "plan_jet"]


@dataclass(frozen=True, slots=True, eq=False)
class KeyedPath(Differentiable):
    """The plan of a path; whoever inherits it puts in the heights.

    `coefficients_m` (U, N+1, 2) are its different outlines; `of_key` (K,) says which one each key has, where
    `of_key[DEGREE]` is the key at u = 0. Keys are `key_rad` apart.
    """

    coefficients_m: ComplexArray
    of_key: NDArray[np.int64]
    key_rad: float

    def __post_init__(self) -> None:
        """Copies, checks and locks the arrays."""
        of_key = np.array(self.of_key, dtype=np.int64)
        of_key.setflags(write=False)
        object.__setattr__(self, "of_key", of_key)
        object.__setattr__(self, "coefficients_m", locked_spectra(self.coefficients_m, ndim=3))

    @property
    def harmonics(self) -> int:
        """The paper's N."""
        return int(self.coefficients_m.shape[1]) - 1

    def outline(self, key: int) -> FourierCurve:
        """The plan curve of one key."""
        return FourierCurve(self.coefficients_m[self.of_key[key]])

    @abstractmethod
    def put_height(self, u_rad: FloatArray, jet: FloatArray) -> None:
        """Writes the height and its three derivatives at `u_rad` (M,) into `jet` (4, M)."""

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The ENU position and its three derivatives, `(4, …, 3)`."""
        u = np.asarray(u_rad, dtype=np.float64)
        flat = u.ravel()
        jet = plan_jet(self.coefficients_m, self.of_key, self.key_rad, flat)
        self.put_height(flat, jet[:, :, 2])
        return jet.reshape(4, *u.shape, 3)


def plan_jet(
    coefficients_m: ComplexArray, of_key: NDArray[np.int64], key_rad: float, u_rad: FloatArray
) -> FloatArray:
    """The plan at phases `(M,)` and its three derivatives, `(4, M, 3)`, with zeros for the height."""
    spectra = np.ascontiguousarray(coefficients_m).view(np.float64)
    jet: FloatArray = mixed_series(np.ascontiguousarray(u_rad), spectra, of_key, key_rad, BASIS)
    return jet
