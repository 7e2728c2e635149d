"""The outlines of a climb: one for every key, none ahead of its height, none far from the one before.

A key outline belongs to a height that the spiral has reached before the outline has any weight. Fields nest: the
higher, the farther from the solid, so an outline that lags is safe. Where a roof ends, the border of the slice
jumps from around that roof to around what stands on it. The outline then walks: every point goes straight to
the nearest point of the new border, one step a key. On that way its distance to the border falls linearly, so
mixtures of neighbouring outlines keep the stand-off too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve.fourier import ComplexArray, in_phase, points_of, spectra_of
from mavspiral.shape.contour import Ring, ring
from mavspiral.shape.slicing import Slice, SolidDistance

__all__ = ["KeyOutlines", "key_outlines"]

POINT_SPACING_M = 0.6
"""At most this far apart are the points that an outline's spectrum is taken from, unless it is very long."""


@dataclass(frozen=True, slots=True, eq=False)
class KeyOutlines:
    """Different outlines as spectra `(U, Q/2, 2)`, in phase with each other, and which one every key has.

    `points` is Q. The last keys are all at the last height and end with the outline that belongs to it.
    """

    spectra_m: ComplexArray
    of_key: NDArray[np.int64]
    points: int


def key_outlines(
    solid: SolidDistance,
    heights_m: FloatArray,
    *,
    anchor_enu_m: FloatArray,
    standoff_m: float,
    corner_radius_m: float,
    step_m: float,
) -> KeyOutlines:
    """The outlines at rising `heights_m`, around the anchor, and as many more as the last needs to be reached.

    Above the roof under the anchor, where there is nothing left to go around, the outline stays as it is.
    """

    def outline(cut: Slice) -> Ring | None:
        return ring(solid, cut, anchor_enu_m=anchor_enu_m, corner_radius_m=corner_radius_m)

    cut = solid.slice(float(heights_m[0]), standoff_m)
    target = outline(cut)
    if target is None:
        raise ValueError(f"nothing stands within {standoff_m} m of the anchor at {heights_m[0]} m")
    points = 1 << int(np.clip(np.ceil(np.log2(target.length_m / POINT_SPACING_M)), 8, 10))
    spectra = [spectra_of(_from_the_east(target).resampled(points).points_enu_m)]
    of_key: list[int] = []
    arrived = True
    key = 0
    while key < len(heights_m) or not arrived:
        here = solid.slice(float(heights_m[min(key, len(heights_m) - 1)]), standoff_m)
        if here != cut:
            cut, found = here, outline(here)
            if found is not None:
                target, arrived = found, False
        if not arrived:
            front, arrived = _stepped(points_of(spectra[-1], points), target.points_enu_m, step_m)
            walked = target if arrived else Ring(front)
            spectra.append(in_phase(spectra_of(walked.resampled(points).points_enu_m), spectra[-1]))
        of_key.append(len(spectra) - 1)
        key += 1
    return KeyOutlines(np.array(spectra), np.array(of_key), points)


def _from_the_east(outline: Ring) -> Ring:
    """The same ring, begun at its easternmost point."""
    points = outline.points_enu_m
    return Ring(np.roll(points, -int(np.argmax(points[:, 0])), axis=0))


@njit(cache=True)
def _stepped(points, target, step):  # type: ignore[no-untyped-def]
    """Points moved by up to `step` straight to the nearest place of the closed polygon; whether all are there."""
    out = np.empty_like(points)
    arrived = True
    for i in range(points.shape[0]):
        px, py = points[i, 0], points[i, 1]
        best, bx, by = np.inf, px, py
        ax, ay = target[-1, 0], target[-1, 1]
        for j in range(target.shape[0]):
            ex, ey = target[j, 0] - ax, target[j, 1] - ay
            t = min(max(((px - ax) * ex + (py - ay) * ey) / max(ex * ex + ey * ey, 1e-18), 0.0), 1.0)
            qx, qy = ax + t * ex, ay + t * ey
            d = (qx - px) ** 2 + (qy - py) ** 2
            if d < best:
                best, bx, by = d, qx, qy
            ax, ay = target[j, 0], target[j, 1]
        distance = np.sqrt(best)
        share = 1.0
        if distance > step:
            share = step / distance
            arrived = False
        out[i, 0] = px + share * (bx - px)
        out[i, 1] = py + share * (by - py)
    return out, arrived
