"""Away from the walls before anything else: where a flight that is given up goes first."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.survey.solids import Solids

__all__ = ["comes_down_aside", "retreat"]

FARTHEST_M = 6.0
STEP_M = 0.5
GAIN = 0.5
"""Of each metre that it goes, so much must lead away from what stands there."""

OFF_A_ROOF_M, BESIDE_M = 9.0, 3.0
"""Over a roof, or hardly beside it, it goes so far at the most to where it would come down at least so far beside it."""

SAME_M = 0.05
SHORTER = 0.01


def retreat(solids: Solids, place_enu_m: FloatArray) -> FloatArray:
    """The place `(3,)` at the same height, up to 6 m away, that is farthest from everything; `place_enu_m` where none is better.

    The straight way there leads away from everything all along. But who soon cannot tell where it is comes down there: where
    that would be on a roof or at its edge, it is the place, up to 9 m away, from which the way down is the clearest, 6 m being
    enough, and the straight way there comes no nearer to anything. A vehicle too far inside for that stays over the roof.
    """
    turn = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    ahead = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    reach_m = np.arange(0.0, OFF_A_ROOF_M + STEP_M / 2, STEP_M)
    places = place_enu_m + reach_m[:, None, None] * ahead
    away_m = solids.distance_m(places.reshape(-1, 3)).reshape(len(reach_m), -1)
    if not np.isfinite(away_m).all():  # nothing stands there
        return place_enu_m
    near_n = np.count_nonzero(reach_m <= FARTHEST_M)
    leads = np.logical_and.accumulate(np.diff(away_m[:near_n], axis=0) >= GAIN * STEP_M, axis=0)
    steps = leads.sum(axis=0)
    best = int(np.argmax(away_m[steps, np.arange(len(turn))]))
    farthest: FloatArray = places[steps[best], best]
    return _off_the_roof(solids, farthest, places, away_m, reach_m)


def comes_down_aside(solids: Solids, place_enu_m: FloatArray) -> bool:
    """Whether it comes down beside everything, and not on a roof, after it retreated from there."""
    away_enu_m = retreat(solids, place_enu_m)
    down = np.array([0.0, 0.0, -max(float(away_enu_m[2]), 0.0)])
    return bool(solids.clear(away_enu_m[None, :], down, BESIDE_M)[0])


def _off_the_roof(
    solids: Solids, farthest_enu_m: FloatArray, places: FloatArray, away_m: FloatArray, reach_m: FloatArray
) -> FloatArray:
    """The place of `places` from which the way down is clear; `farthest_enu_m` where it is so from there, or from none."""
    down = np.array([0.0, 0.0, -max(float(farthest_enu_m[2]), 0.0)])
    if solids.clear(farthest_enu_m[None, :], down, BESIDE_M)[0]:
        return farthest_enu_m
    comes_no_nearer = np.logical_and.accumulate(away_m >= away_m[0] - SAME_M, axis=0)
    beside_m = solids.distance_m(places.reshape(-1, 3), down).reshape(away_m.shape)
    worth = np.where(comes_no_nearer, np.minimum(beside_m, FARTHEST_M), -np.inf) - SHORTER * reach_m[:, None]
    step, way = np.unravel_index(np.argmax(worth), worth.shape)
    clearest: FloatArray = places[step, way]
    return clearest if beside_m[step, way] >= BESIDE_M else farthest_enu_m
