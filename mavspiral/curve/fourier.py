"""Closed curves as Fourier series, the paper's section III.B.

    s(u) = A + Σ A_k cos(ku) + B_k sin(ku),   k = 1 … N,
    s(u) = Re Σ c_k e^{iku},   k = 0 … N,   with c_k = A_k − i·B_k.

A row of `coefficients_m` is `c_k` for east and north; `c_0 = A`. Real axes have conjugate-symmetric spectra,
so the `N` harmonics of a half spectrum stand for themselves and for their conjugates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray

__all__ = [
    "ComplexArray",
    "FourierCurve",
    "harmonics_needed",
    "in_phase",
    "locked_spectra",
    "points_of",
    "spectra_of",
]

ComplexArray = NDArray[np.complex128]


def locked_spectra(values: ArrayLike, *, ndim: int) -> ComplexArray:
    """A read-only complex copy of `values`, which must be `(…, N+1, 2)` with `ndim` axes, and finite.

    Raises:
        ValueError: they are not.
    """
    array = np.array(values, dtype=np.complex128)
    if array.ndim != ndim or array.shape[-1] != 2 or not np.isfinite(array).all():
        raise ValueError(
            f"coefficients_m has shape {array.shape}, wanted {ndim} axes, the last of 2, all finite"
        )
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True, eq=False)
class FourierCurve:
    """A closed plan curve of period 2π: `curve(u_rad, order)`."""

    coefficients_m: ComplexArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the coefficients `(N+1, 2)`."""
        object.__setattr__(self, "coefficients_m", locked_spectra(self.coefficients_m, ndim=2))

    @classmethod
    def through(cls, points_enu_m: FloatArray, harmonics: int) -> FourierCurve:
        """The curve through the discrete Fourier transform of `(Q, 2)` points, truncated to `harmonics`."""
        return cls(spectra_of(points_enu_m)[: harmonics + 1])

    @property
    def harmonics(self) -> int:
        """The paper's N."""
        return len(self.coefficients_m) - 1

    def __call__(self, u_rad: ArrayLike, order: int = 0) -> FloatArray:
        """The ENU plan position `(…, 2)`, or its derivative of `order`, in m/radᵒʳᵈᵉʳ."""
        k = np.arange(len(self.coefficients_m))
        waves = np.exp(1j * np.asarray(u_rad, dtype=np.float64)[..., None] * k)
        return np.real(waves @ ((1j * k[:, None]) ** order * self.coefficients_m))


def spectra_of(points_enu_m: FloatArray) -> ComplexArray:
    """The `c_k` `(…, Q/2, 2)` of closed curves `(…, Q, 2)`; Q is even, its Nyquist wave is left out."""
    count = points_enu_m.shape[-2]
    spectra = np.fft.rfft(points_enu_m, axis=-2)[..., : count // 2, :] * (2.0 / count)
    spectra[..., 0, :] *= 0.5
    return np.asarray(spectra, dtype=np.complex128)


def points_of(spectra: ComplexArray, count: int) -> FloatArray:
    """The points `(…, count, 2)` at equal phases of curves `(…, N+1, 2)`: the inverse of `spectra_of`."""
    half = spectra * (0.5 * count)
    half[..., 0, :] *= 2.0
    return np.fft.irfft(half, n=count, axis=-2)


def in_phase(spectra: ComplexArray, reference: ComplexArray) -> ComplexArray:
    """The curve of `spectra` started where it lies closest, in the mean square, to that of `reference`.

    A start later by δ turns `c_k` into `c_k e^{ikδ}`; the best δ maximises Re Σ c_k·conj(r_k) e^{ikδ}, the
    circular correlation, which the inverse transform gives on a grid, and one parabola between its points.
    """
    cross = np.sum(spectra * np.conj(reference), axis=-1)
    cross[0] = 0.0
    count = 4 * len(cross)
    correlation = np.real(np.fft.ifft(cross, n=count))
    best = int(np.argmax(correlation))
    before, peak, after = correlation[best - 1], correlation[best], correlation[(best + 1) % count]
    bend = before - 2.0 * peak + after
    delta = 2.0 * np.pi / count * (best + (0.5 * (before - after) / bend if bend < 0.0 else 0.0))
    return np.asarray(spectra * np.exp(1j * delta * np.arange(len(spectra)))[:, None], dtype=np.complex128)


def harmonics_needed(spectra: ComplexArray, *, tolerance_m: float, count: int) -> int:
    """The smallest N at which all curves `(K, Q/2, 2)` stay within `tolerance_m` of themselves.

    Points of the same phase are compared, at `count` phases: there the curves are no farther apart than that.
    """
    full = points_of(spectra, count)
    enough, short = int(spectra.shape[-2]) - 1, 0
    while enough - short > 1:
        harmonics = (enough + short) // 2
        gap = points_of(spectra[..., : harmonics + 1, :], count) - full
        if np.hypot(gap[..., 0], gap[..., 1]).max() <= tolerance_m:
            enough = harmonics
        else:
            short = harmonics
    return enough
