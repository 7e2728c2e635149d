"""The paper's own recipe, for comparison: voxel slices, the largest contour, 100 samples, a few harmonics a ring.

    Δh = d/f·h_s·(1 − o)    n = ceil(span/Δh)    h(l) = bottom + span·(l − 1)/n    I_l = {H > h(l)}        eqs. 2 to 6
    ring l:  the largest contour of I_l dilated by d, with z from h(l) to h(l) + Δh, sampled Q = 100 times
    s_l(u) = A + Σ A_k cos(ku) + B_k sin(ku),   k = 1 … N,   of all three axes                             eqs. 8 to 10

Vasquez et al., *Spiral Trajectories for Building Inspection with Quadrotors*. Its rings are taken as they are: nothing
closes their corners, a ramp is no periodic signal and so its series rings at the seam, and ring l + 1 does not begin
where ring l ends. Such a jump nobody flies. Here, and only here, this goes beyond the paper: round each seam, for a
quarter of a turn, one ring's series passes over into the next one's by a smooth step, C⁴.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve import Differentiable
from mavspiral.curve.fourier import ComplexArray, spectra_of
from mavspiral.errors import InputError
from mavspiral.shape.contour import Ring
from mavspiral.shape.distance import cells_away
from mavspiral.shape.heightmap import Site

__all__ = [
    "SAMPLES",
    "PaperPath",
    "PaperSpiral",
    "largest_contour",
    "plan_paper",
    "ring_heights_m",
    "slice_at",
]

SAMPLES = 100
"""Q, to which the paper resamples every ring."""
JOINT_RAD = 0.5 * np.pi
"""A quarter of a turn: sharper joints cost more time than they keep of the paper."""
_STEP = np.polynomial.Polynomial([0.0, 0.0, 0.0, 0.0, 0.0, 126.0, -420.0, 540.0, -315.0, 70.0])
"""From 0 to 1 on [0, 1], with four derivatives that vanish at both ends."""


@dataclass(frozen=True, slots=True, eq=False)
class PaperPath(Differentiable):
    """The rings in a row: `path(u_rad, order)`; `coefficients_m` (n, N+1, 3) are `c_k = A_k − i·B_k` of each ring."""

    coefficients_m: ComplexArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the coefficients."""
        spectra = np.array(self.coefficients_m, dtype=np.complex128)
        if (
            spectra.ndim != 3
            or spectra.shape[0] < 1
            or spectra.shape[2] != 3
            or not np.isfinite(spectra).all()
        ):
            raise ValueError(f"coefficients_m has shape {spectra.shape}, wanted (rings, N+1, 3), all finite")
        spectra.setflags(write=False)
        object.__setattr__(self, "coefficients_m", spectra)

    @property
    def rings(self) -> int:
        """The paper's n."""
        return int(self.coefficients_m.shape[0])

    @property
    def harmonics(self) -> int:
        """The paper's N."""
        return int(self.coefficients_m.shape[1]) - 1

    @property
    def u_end_rad(self) -> float:
        """A turn for each ring."""
        return 2.0 * np.pi * self.rings

    @property
    def seams_m(self) -> FloatArray:
        """How far each ring ends from where the next one begins, `(n − 1,)`."""
        starts = np.real(self.coefficients_m.sum(axis=1))
        return np.asarray(np.sqrt((np.diff(starts, axis=0) ** 2).sum(axis=1)))

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The ENU position and its three derivatives, `(4, …, 3)`."""
        u = np.asarray(u_rad, dtype=np.float64)
        flat = u.ravel()
        jet = np.empty((4, flat.size, 3))
        nearest = np.rint(flat / (2.0 * np.pi)).astype(np.int64)  # seam k lies between the rings k − 1 and k
        for seam in np.unique(nearest):
            rows = np.flatnonzero(nearest == seam)
            before, after = (int(np.clip(ring, 0, self.rings - 1)) for ring in (seam - 1, seam))
            jet[:, rows] = self._series(flat[rows], before)
            if before != after:
                x = np.clip((flat[rows] - 2.0 * np.pi * seam) / JOINT_RAD + 0.5, 0.0, 1.0)
                weight = [_STEP.deriv(j)(x) / JOINT_RAD**j if j else _STEP(x) for j in range(4)]
                step = self._series(flat[rows], after) - jet[:, rows]
                for m in range(4):
                    jet[m, rows] += sum(
                        math.comb(m, j) * weight[j][:, None] * step[m - j] for j in range(m + 1)
                    )
        return jet.reshape(4, *u.shape, 3)

    def _series(self, u: FloatArray, ring: int) -> FloatArray:
        """One ring's Fourier series and its three derivatives, `(4, M, 3)`."""
        ik = 1j * np.arange(self.harmonics + 1)[:, None]
        waves = np.exp(u[:, None] * ik[:, 0])
        return np.stack([np.real(waves @ (ik**order * self.coefficients_m[ring])) for order in range(4)])


@dataclass(frozen=True, slots=True, eq=False)
class PaperSpiral:
    """The paper's curve, and how many contours its slices had beside the largest, summed over the rings."""

    path: PaperPath
    dropped_n: int

    @property
    def notices(self) -> tuple[str, ...]:
        """What a reader of the plan has to know, in words."""
        path = self.path
        told = [
            f'[inspection] mode = "paper": {path.rings} rings of {path.harmonics} harmonics as the paper has them, '
            "for comparison"
        ]
        if path.rings > 1:
            told.append(
                f"the paper's rings end up to {path.seams_m.max():.1f} m from where the next one begins; each joint is "
                f"smoothed over {math.degrees(JOINT_RAD):.0f}° of a turn, else nothing could fly it"
            )
        if self.dropped_n:
            told.append(
                f"the paper keeps the largest contour of a slice: {self.dropped_n} others in {path.rings} slices are left out"
            )
        return tuple(told)


def ring_heights_m(bottom_m: float, top_m: float, rise_m: float) -> FloatArray:
    """h(l) of the n rings: equations 3 and 6, with `bottom_m` to `top_m` for the building's height."""
    rings = max(1, math.ceil((top_m - bottom_m) / rise_m - 1e-9))
    return np.asarray(bottom_m + (top_m - bottom_m) / rings * np.arange(rings))


def slice_at(height_m: FloatArray, start_m: float) -> NDArray[np.bool_]:
    """I_l of equations 4 and 5, without a grid of voxels: what rises above the ring's beginning."""
    return np.asarray(height_m > start_m)


def largest_contour(occupied: NDArray[np.bool_], cell_m: float, standoff_m: float) -> tuple[FloatArray, int]:
    """The contour of the largest area of the slice dilated by the stand-off, and how many others there were.

    Cells `(m, 2)` as column and row, counter-clockwise with rows to the north; the map must reach farther than the
    stand-off. The paper's kernel "of diameter d at least" is taken as one of radius d. Distances run between
    cells' middles, the wall is half a cell nearer, and the contour's cells lie half a cell inside the line on the
    mean: so the line is drawn a cell farther out, and the contour is at d, give or take half a cell's diagonal.
    """
    near = (cells_away(occupied) * cell_m < standoff_m + cell_m).astype(np.uint8)
    contours, _ = cv2.findContours(near, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    areas = [cv2.contourArea(contour) for contour in contours]
    largest = contours[int(np.argmax(areas))]
    if cv2.contourArea(largest, oriented=True) < 0.0:
        largest = np.roll(largest[::-1], 1, axis=0)
    return largest[:, 0, :].astype(np.float64), len(contours) - 1


def plan_paper(
    site: Site, *, standoff_m: float, rise_m: float, bottom_m: float, top_m: float, terms: int
) -> PaperSpiral:
    """The paper's curve around the building, from `bottom_m`; each ring keeps `terms` harmonics, 49 at the most.

    Clearance is not looked at: the certificate does.

    Raises:
        InputError: nothing of the building reaches a ring's height.
    """
    wide = site.padded(standoff_m + 4.0 * site.heights.cell_m)
    height, cell_m = wide.building_height_m, wide.heights.cell_m
    dropped, spectra = 0, []
    for number, start_m in enumerate(ring_heights_m(bottom_m, top_m, rise_m), start=1):
        occupied = slice_at(height, start_m)
        if not occupied.any():
            raise InputError(
                f'[inspection] mode = "paper": ring {number} begins at {start_m:.1f} m, the building ends at '
                f"{height.max():.1f} m. Fix: top_m ≤ {height.max():.1f}"
            )
        cells, others = largest_contour(occupied, cell_m, standoff_m)
        plan = Ring(wide.heights.origin_enu_m + (cells + 0.5) * cell_m).resampled(SAMPLES).points_enu_m
        climb = np.linspace(start_m, start_m + rise_m, SAMPLES)
        spectra.append(spectra_of(np.column_stack([plan, climb]))[: terms + 1])
        dropped += others
    return PaperSpiral(PaperPath(np.array(spectra)), dropped)
