"""One smooth inward spiral above a roof.

    p(u) = ( Σ_k b(u/Δ − k)·s_k(u),  Σ_j b(u/δ − j)·z_j )

`s_k` are Fourier series of the rings at the keys, as on the spiral around a building, and the height is a B-spline,
too, whose coefficients are the least heights that keep the stand-off. Both are C³. On a map of heights going up never
leads nearer to anything, so a coefficient that is the greatest of the needed heights where it has weight is safe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve.fourier import ComplexArray, harmonics_needed, in_phase, spectra_of
from mavspiral.curve.insets import KEYS_PER_TURN, Insets
from mavspiral.curve.keyed import KeyedPath, plan_jet
from mavspiral.curve.mixing import DEGREE
from mavspiral.curve.profile import Profile
from mavspiral.shape.roofs import RoofGrid

__all__ = ["RoofPath", "Standoff", "roof_spiral"]

FIT_M = 0.15
POINTS = 256
SLOWEST_SHARE = 0.02
"""Of a ring's mean way per phase: less is nearly a cusp."""
SAMPLE_M = 0.6
KNOT_M = 1.5
SLOPE_MAX = 0.7
"""Of the height along the way: what rises more steeply is met higher up."""
ROUNDING_M = 2.0


@dataclass(frozen=True, slots=True)
class Standoff:
    """What is kept from cells up to `high_m`, and what from cells that are higher."""

    below_m: float
    beside_m: float
    high_m: float

    def heights_m(self, grid: RoofGrid, place_enu_m: FloatArray) -> FloatArray:
        """The least height `(n,)` above ground at places `(n, 2)` in plan that keeps it."""
        heights: FloatArray = _needed(
            np.ascontiguousarray(place_enu_m),
            grid.height_agl_m,
            grid.cell_m,
            grid.origin_enu_m,
            self.below_m,
            self.beside_m,
            self.high_m,
        )
        return heights


@dataclass(frozen=True, slots=True, eq=False)
class RoofPath(KeyedPath):
    """The spiral above a roof: `path(u_rad, order)`."""

    height_m: Profile
    u_end_rad: float

    def put_height(self, u_rad: FloatArray, jet: FloatArray) -> None:
        """Writes the height's spline at `u_rad` (M,) into `jet` (4, M)."""
        jet[...] = self.height_m.jerked(u_rad)


def roof_spiral(
    grid: RoofGrid, insets: Insets, standoff: Standoff, *, start_enu_m: FloatArray
) -> RoofPath | None:
    """The spiral through `insets`: a turn on the first, inward on the turns between, and a last one if they are closed.

    It begins near `start_enu_m` (2,), and where it ends in the roof's middle, at that end of it which is nearer to there.
    None where a ring is so thin that its series turns back on the spot.
    """
    spectra = [spectra_of(ring.resampled(POINTS).points_enu_m) for ring in insets.rings]
    inward = not insets.closed
    order = range(len(spectra) - 1, -1, -1) if inward else range(len(spectra))
    first = order[0]
    spectra[first] = _begun_at(insets.rings[first].resampled(POINTS).points_enu_m, start_enu_m, tip=inward)
    for number in order[1:]:
        spectra[number] = in_phase(spectra[number], spectra[number + 1 if inward else number - 1])
    coefficients = np.array(spectra)
    harmonics = harmonics_needed(coefficients, tolerance_m=FIT_M, count=POINTS)
    coefficients = coefficients[:, : harmonics + 1]

    level_turns = 2 if insets.closed and insets.turns else 1
    key_rad = 2.0 * np.pi / KEYS_PER_TURN
    spans = (level_turns + insets.turns) * KEYS_PER_TURN
    of_key = np.clip(np.arange(spans + DEGREE) - 1 - KEYS_PER_TURN, 0, len(spectra) - 1)
    u_end_rad = spans * key_rad

    length_m = max(ring.length_m for ring in insets.rings)
    turns = level_turns + insets.turns
    knots = math.ceil(max(length_m / KNOT_M, 16.0)) * turns
    u = np.linspace(0.0, u_end_rad, max(math.ceil(length_m / SAMPLE_M) * turns, 3 * knots) + 1)
    jet = plan_jet(coefficients, of_key, key_rad, u)
    lengths_m = np.array([ring.length_m for ring in insets.rings])[of_key]
    middles = (np.arange(spans + DEGREE) - 0.5 * (DEGREE - 1)) * key_rad
    pace_m = np.hypot(jet[1, :, 0], jet[1, :, 1])
    if (pace_m < SLOWEST_SHARE * np.interp(u, middles, lengths_m) / (2.0 * np.pi)).any():
        return None
    plan = jet[0, :, :2]
    needed = _gentle(plan, standoff.heights_m(grid, plan))
    height = Profile.above(u, needed, u_end_rad / knots, knots)
    return RoofPath(coefficients, of_key, key_rad, height, u_end_rad)


def _begun_at(points: FloatArray, start_enu_m: FloatArray, *, tip: bool) -> ComplexArray:
    """The spectrum of a ring begun at its point nearest to `start_enu_m`, or at the nearer of its two far ends."""
    nearest = np.hypot(*(points - start_enu_m).T)
    if tip:
        one = int(np.argmax(np.hypot(*(points - points.mean(axis=0)).T)))
        other = int(np.argmax(np.hypot(*(points - points[one]).T)))
        begin = min((one, other), key=lambda k: float(nearest[k]))
    else:
        begin = int(np.argmin(nearest))
    return spectra_of(np.roll(points, -begin, axis=0))


def _gentle(plan: FloatArray, height_m: FloatArray) -> FloatArray:
    """Heights nowhere below these: no steeper along the way than is flown, and without a kink.

    The mean, over `ROUNDING_M` each way, of the highest within as much is no less than what was there; twice.
    """
    way_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(plan, axis=0).T))])
    if np.ptp(height_m) < 1e-9:
        return height_m
    rising = np.maximum.accumulate(height_m + SLOPE_MAX * way_m) - SLOPE_MAX * way_m
    falling = np.maximum.accumulate((height_m - SLOPE_MAX * way_m)[::-1])[::-1] + SLOPE_MAX * way_m
    first = np.searchsorted(way_m, way_m - ROUNDING_M)
    last = np.searchsorted(way_m, way_m + ROUNDING_M, side="right")
    gentle = np.maximum(rising, falling)
    for _ in range(2):
        gentle = _mean_of_highest(gentle, first, last)
    return gentle


@njit(cache=True)
def _mean_of_highest(values: FloatArray, first: NDArray[np.int64], last: NDArray[np.int64]) -> FloatArray:
    highest = np.empty_like(values)
    for i in range(values.size):
        highest[i] = values[first[i] : last[i]].max()
    means = np.empty_like(values)
    for i in range(values.size):
        means[i] = highest[first[i] : last[i]].mean()
    return means


@njit(cache=True)
def _needed(
    place: FloatArray,
    height: FloatArray,
    cell: float,
    origin: FloatArray,
    below: float,
    beside: float,
    high: float,
) -> FloatArray:
    """The greatest over the cells of H + √(d² − E²), where E < d is the distance in plan and d that of the cell's kind."""
    rows, cols = height.shape
    out = np.zeros(place.shape[0])
    reach = int(max(below, beside) / cell) + 1
    for i in range(place.shape[0]):
        x, y = (place[i, 0] - origin[0]) / cell, (place[i, 1] - origin[1]) / cell
        col, row = int(np.floor(x)), int(np.floor(y))
        best = below + height[min(max(row, 0), rows - 1), min(max(col, 0), cols - 1)]
        for r in range(max(0, row - reach), min(rows, row + reach + 1)):
            dy = max(r - y, y - r - 1.0, 0.0) * cell
            for c in range(max(0, col - reach), min(cols, col + reach + 1)):
                h = height[r, c]
                d = below if h <= high else beside
                if h + d <= best:
                    continue
                dx = max(c - x, x - c - 1.0, 0.0) * cell
                rest = d * d - dx * dx - dy * dy
                if rest > 0.0:
                    best = max(best, h + np.sqrt(rest))
        out[i] = best
    return out
