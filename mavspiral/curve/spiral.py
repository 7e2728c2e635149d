"""One smooth spiral around a building.

    p(u) = ( Σ_k b(u/Δ − k)·s_k(u),  z(u) )

`s_k` are Fourier series of the outlines at the keys, Δ apart in phase, `b` is the uniform quartic B-spline,
and `z` the climb. Each factor is C³, so the spiral is. Key k has weight for u from kΔ to (k+5)Δ only, and its
outline belongs to the height z(kΔ): no outline is ever flown below its own height. The weights are convex.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve.climb import Climb
from mavspiral.curve.fourier import harmonics_needed
from mavspiral.curve.keyed import KeyedPath
from mavspiral.curve.mixing import BASIS, DEGREE
from mavspiral.curve.outlines import key_outlines
from mavspiral.errors import InputError, LimitError
from mavspiral.shape.parts import Part
from mavspiral.shape.slicing import SolidDistance

__all__ = [
    "ATTEMPTS",
    "FIT_M",
    "TOLERANCE_M",
    "Spiral",
    "SpiralPath",
    "TooNearError",
    "nearest",
    "plan_spiral",
]

FAR_EAST = np.array([1e6, 0.0])
TOLERANCE_M = 0.3
"""The flown curve comes closer than the stand-off by no more than this."""
FIT_M = 0.1
"""Of the tolerance, what the truncation of the Fourier series may take at every outline."""
WALK_FIT_M = 0.3
"""The same for outlines on a walk, which only touch the stand-off where they have arrived."""
MIXING_M = 0.1
"""Of the tolerance, what mixing outlines that slide along each other may take: it sets the step of a walk."""
ATTEMPTS = 6
"""A curve that comes too close is planned again, with wider outlines and shorter steps, up to so often."""


@dataclass(frozen=True, slots=True, eq=False)
class SpiralPath(KeyedPath):
    """The spiral: `path(u_rad, order)`. Beyond its ends it goes on as level turns."""

    climb: Climb
    u_end_rad: float

    @property
    def rings(self) -> int:
        """The paper's n: turns that climb. Level turns are extra."""
        return self.climb.turns

    def begun(self, phase_rad: float) -> SpiralPath:
        """The same outlines at the same heights, begun `phase_rad` further along them."""
        turned = np.exp(1j * phase_rad * np.arange(self.harmonics + 1))
        return replace(self, coefficients_m=self.coefficients_m * turned[:, None])

    def put_height(self, u_rad: FloatArray, jet: FloatArray) -> None:
        """Writes the climb at `u_rad` (M,) into `jet` (4, M)."""
        self.climb.put(u_rad, jet)

    def places_begun(self, u_rad: float, phases_rad: FloatArray) -> FloatArray:
        """Where the same outlines, begun each of the phases (n,) further along them, are at `u_rad`: `(n, 3)`.

        What `begun(phase)(u_rad)` tells, for all of them at once.
        """
        span = min(max(int(np.floor(u_rad / self.key_rad)), 0), len(self.of_key) - DEGREE - 1)
        share = min(max(u_rad / self.key_rad - span, 0.0), 1.0)
        weights = BASIS[0] @ share ** np.arange(DEGREE + 1)
        mixed = np.tensordot(weights, self.coefficients_m[self.of_key[span : span + DEGREE + 1]], axes=1)
        waves = np.exp(1j * np.outer(phases_rad + u_rad, np.arange(self.harmonics + 1)))
        height_m = np.full(len(phases_rad), float(self.climb(u_rad)))
        return np.column_stack([(waves @ mixed).real, height_m])


class TooNearError(LimitError):
    """No spiral keeps its distance: the place `(3,)` where the last one came nearest, how near, and what was wanted."""

    def __init__(self, place_enu_m: FloatArray, nearest_m: float, required_m: float) -> None:
        self.place_enu_m, self.nearest_m, self.required_m = place_enu_m, nearest_m, required_m
        super().__init__(
            f"the spiral comes within {nearest_m:.2f} m of the building at "
            f"{np.array2string(place_enu_m, precision=1)} ENU, wanted {required_m:.2f} m"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Spiral:
    """A planned spiral, and the least distance to the building along it."""

    path: SpiralPath
    clearance_min_m: float


def plan_spiral(
    solid: SolidDistance,
    part: Part,
    *,
    standoff_m: float,
    rise_m: float,
    bottom_m: float,
    top_m: float,
    clearance_m: float,
    corner_radius_m: float,
    start_enu_m: FloatArray = FAR_EAST,
    keys_per_turn: int = 8,
) -> Spiral:
    """The spiral around a part of the building, from `bottom_m` to `top_m`.

    It climbs in as few turns as keep each at or below `rise_m`. Neighbours are not looked at.

    Args:
        solid: the distance to the building, on a grid that reaches 2·standoff_m + corner_radius_m beyond it.
        part: the part.
        standoff_m: the distance to keep from walls and roofs; kept to within `TOLERANCE_M`.
        rise_m: the paper's Δh, the most that a turn may climb.
        bottom_m: the height of the level turn below.
        top_m: the height of the level turn above.
        clearance_m: never closer than this.
        corner_radius_m: no concave corner of an outline is sharper; speed²/acceleration.
        start_enu_m: `(2,)`; the spiral begins where it is nearest to this place in plan.
        keys_per_turn: outlines a turn where they change with height.

    Raises:
        InputError: the numbers contradict each other.
        TooNearError: the curve cannot keep the clearance.
    """
    if not 0.0 < clearance_m <= standoff_m:
        raise InputError(
            f"clearance_m is {clearance_m}, wanted above 0 and at most standoff_m = {standoff_m}"
        )
    if not (rise_m > 0.0 and corner_radius_m >= 0.0 and keys_per_turn >= 4):
        raise InputError(f"{rise_m=}, {corner_radius_m=}, {keys_per_turn=}: wanted > 0, >= 0 and >= 4")
    if top_m < bottom_m:
        raise InputError(f"top_m is {top_m}, below bottom_m = {bottom_m}")
    if bottom_m >= part.top_m + standoff_m:
        raise InputError(f"bottom_m is {bottom_m}, above everything: the roof is at {part.top_m:.1f} m")
    climb = Climb(bottom_m, top_m, int(np.ceil((top_m - bottom_m) / rise_m - 1e-9)))
    required_m = max(clearance_m, standoff_m - TOLERANCE_M)
    # A quartic B-spline mixes keys with a variance of 5/12 key², so outlines that slide by s from key to key
    # along an arc of radius d leave it by 5/24·s²/d.
    ring_m, step_m = standoff_m, float(np.sqrt(24.0 / 5.0 * MIXING_M * standoff_m))
    for _ in range(ATTEMPTS):
        path = _spiral_at(
            solid, part.anchor_enu_m, start_enu_m, climb, ring_m, corner_radius_m, step_m, keys_per_turn
        )
        nearest_m, at_rad = nearest(solid, path)
        if nearest_m >= required_m:
            return Spiral(path, nearest_m)
        ring_m += 1.2 * (required_m - nearest_m) + 0.02
        step_m *= 0.75
    raise TooNearError(path(at_rad), nearest_m, required_m)


def _spiral_at(
    solid: SolidDistance,
    anchor_enu_m: FloatArray,
    start_enu_m: FloatArray,
    climb: Climb,
    standoff_m: float,
    corner_radius_m: float,
    step_m: float,
    keys_per_turn: int,
) -> SpiralPath:
    """The spiral whose outlines keep `standoff_m` and walk by `step_m`."""
    key_rad = 2.0 * np.pi / keys_per_turn
    keys_rad = np.arange(-DEGREE, np.ceil(climb.end_rad / key_rad) + 1) * key_rad
    outlines = key_outlines(
        solid,
        climb(keys_rad),
        anchor_enu_m=anchor_enu_m,
        start_enu_m=start_enu_m,
        standoff_m=standoff_m,
        corner_radius_m=corner_radius_m,
        step_m=step_m,
    )
    harmonics = max(
        harmonics_needed(outlines.spectra_m[chosen], tolerance_m=tolerance_m, count=outlines.points)
        for chosen, tolerance_m in ((~outlines.walking, FIT_M), (outlines.walking, WALK_FIT_M))
        if chosen.any()
    )
    # From the phase of the first key with the last outline on, no other outline has any weight.
    of_key = np.pad(outlines.of_key, (0, DEGREE), mode="edge")
    changes = np.flatnonzero(np.diff(of_key))
    settled_rad = (changes[-1] + 1) * key_rad if changes.size else 0.0
    u_end_rad = max(climb.end_rad, settled_rad) + (2.0 * np.pi if climb.turns else 0.0)
    return SpiralPath(outlines.spectra_m[:, : harmonics + 1], of_key, key_rad, climb, u_end_rad)


def nearest(solid: SolidDistance, path: SpiralPath) -> tuple[float, float]:
    """The least distance from the curve to the solid, looked at every half metre, and where."""
    u = np.linspace(0.0, path.u_end_rad, 64)
    length_m = np.hypot(*path(u, 1)[:, :2].T).mean() * path.u_end_rad
    u = np.linspace(0.0, path.u_end_rad, int(length_m / 0.5) + 64)
    distance = solid(path(u))
    worst = int(np.argmin(distance))
    return float(distance[worst]), float(u[worst])
