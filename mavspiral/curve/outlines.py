"""The outlines of a climb: one for every key, none ahead of its height, none far from the one before.

A key outline belongs to a height that the spiral has reached before the outline has any weight. Fields nest:
the higher, the farther from the solid, so an outline that lags is safe. Where a roof ends, the border of the
slice jumps from around that roof to around what stands on it; the outline then walks there, some steps
behind.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve.fourier import ComplexArray, in_phase, spectra_of
from mavspiral.curve.walk import Walk, signed_distance
from mavspiral.shape.contour import Ring, ring
from mavspiral.shape.slicing import Slice, SolidDistance

__all__ = ["POINT_SPACING_M", "KeyOutlines", "begun_at", "key_outlines"]

POINT_SPACING_M = 0.6
"""At most this far apart are the points that an outline's spectrum is taken from, unless it is very long."""


@dataclass(frozen=True, slots=True, eq=False)
class KeyOutlines:
    """Different outlines as spectra `(U, Q/2, 2)`, in phase with each other, and which one every key has.

    `points` is Q, and `walking` (U,) tells which outlines are on their way between two borders. The last keys
    are all at the last height and end with the outline that belongs to it.
    """

    spectra_m: ComplexArray
    of_key: NDArray[np.int64]
    walking: NDArray[np.bool_]
    points: int


def key_outlines(
    solid: SolidDistance,
    heights_m: FloatArray,
    *,
    anchor_enu_m: FloatArray,
    start_enu_m: FloatArray,
    standoff_m: float,
    corner_radius_m: float,
    step_m: float,
) -> KeyOutlines:
    """The outlines at rising `heights_m` around the anchor, and as many more as the last one takes.

    Phase 0 of the first is its point nearest to `start_enu_m`; the others are in phase with it.
    Above the roof under the anchor, where there is nothing left to go around, the outline stays as it is.
    """

    @cache
    def cut_above(height_m: float) -> Slice:
        return solid.slice(height_m, standoff_m, corner_radius_m)

    def cut_at(height_m: float) -> Slice:
        return cut_above(max(float(height_m), lowest_roof_m))  # below all roofs one slice is like another

    def outline(cut: Slice) -> Ring | None:
        return ring(solid, cut, anchor_enu_m=anchor_enu_m, corner_radius_m=corner_radius_m)

    lowest_roof_m = float(solid.levels_m[0])
    cut = cut_at(heights_m[0])
    target = outline(cut)
    if target is None:
        raise ValueError(f"nothing stands within {standoff_m} m of the anchor at {heights_m[0]} m")
    points = 1 << int(np.clip(np.ceil(np.log2(target.length_m / POINT_SPACING_M)), 8, 10))
    reached = target
    spectra = [spectra_of(begun_at(target, start_enu_m).resampled(points).points_enu_m)]
    of_key: list[int] = []
    walking = [False]
    walk: Walk | None = None
    while len(of_key) < len(heights_m) or reached is not target:
        here = cut_at(heights_m[min(len(of_key), len(heights_m) - 1)])
        if here != cut:
            cut = here
            target = outline(here) or target
        if reached is not target:
            if walk is None and _farthest_m(reached, target) > step_m:
                walk = Walk(reached, target, anchor_enu_m, corner_radius_m)
            reached = walk.step(step_m) if walk else target
            if walk and walk.arrived:
                walk = None
            walking.append(walk is not None)
            spectra.append(in_phase(spectra_of(reached.resampled(points).points_enu_m), spectra[-1]))
        of_key.append(len(spectra) - 1)
    return KeyOutlines(np.array(spectra), np.array(of_key), np.array(walking), points)


def begun_at(outline: Ring, start_enu_m: FloatArray) -> Ring:
    """The same ring, begun at its point nearest to `start_enu_m` (2,)."""
    points = outline.points_enu_m
    return Ring(np.roll(points, -int(np.argmin(((points - start_enu_m) ** 2).sum(axis=1))), axis=0))


def _farthest_m(outline: Ring, target: Ring) -> float:
    """How far the farthest point of one ring is from the other, both ways."""
    a, b = outline.points_enu_m, target.points_enu_m
    return float(max(np.abs(signed_distance(a, b)).max(), np.abs(signed_distance(b, a)).max()))
