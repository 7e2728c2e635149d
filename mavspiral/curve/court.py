"""The spiral inside a courtyard: one outline at all heights, clockwise, so that the camera looks at the walls."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve.climb import Climb
from mavspiral.curve.fourier import harmonics_needed, spectra_of
from mavspiral.curve.mixing import DEGREE
from mavspiral.curve.outlines import POINT_SPACING_M, begun_at
from mavspiral.curve.spiral import ATTEMPTS, FIT_M, TOLERANCE_M, SpiralPath, nearest
from mavspiral.errors import LimitError
from mavspiral.shape.courts import Court, court_ring
from mavspiral.shape.slicing import SolidDistance

__all__ = ["plan_court"]


def plan_court(
    solid: SolidDistance,
    court: Court,
    *,
    standoff_m: float,
    rise_m: float,
    bottom_m: float,
    top_m: float,
    corner_radius_m: float,
    start_enu_m: FloatArray,
) -> SpiralPath:
    """The spiral at `standoff_m` from the walls of a court, kept to within `TOLERANCE_M`.

    What is free at `bottom_m` is free above it, so the lowest outline serves all heights.

    Raises:
        LimitError: the court is too narrow for it.
    """
    climb = Climb(bottom_m, top_m, int(np.ceil((top_m - bottom_m) / rise_m - 1e-9)))
    ring_m, found_m = standoff_m, 0.0
    for _ in range(ATTEMPTS):
        ring = court_ring(solid, court, height_m=bottom_m, standoff_m=ring_m, corner_radius_m=corner_radius_m)
        if ring is None:
            break
        count = 1 << int(np.clip(np.ceil(np.log2(ring.length_m / POINT_SPACING_M)), 7, 10))
        spectra_m = spectra_of(begun_at(ring, start_enu_m).resampled(count).points_enu_m)[None]
        harmonics = harmonics_needed(spectra_m, tolerance_m=FIT_M, count=count)
        key_rad = 0.25 * np.pi
        keys = int(np.ceil(climb.end_rad / key_rad)) + 2 * DEGREE + 2
        u_end_rad = climb.end_rad + (2.0 * np.pi if climb.turns else 0.0)
        path = SpiralPath(
            spectra_m[:, : harmonics + 1], np.zeros(keys, dtype=np.int64), key_rad, climb, u_end_rad
        )
        found_m = nearest(solid, path)[0]
        if found_m >= standoff_m - TOLERANCE_M:
            return path
        ring_m += 1.2 * (standoff_m - TOLERANCE_M - found_m) + 0.02
    raise LimitError(
        f"a turn inside comes within {found_m:.2f} m of the walls, wanted {standoff_m - TOLERANCE_M:.2f} m"
    )
