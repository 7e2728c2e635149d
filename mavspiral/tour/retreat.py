"""Away from the walls before anything else: where a flight that is given up goes first."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.survey.solids import Solids

__all__ = ["retreat"]

FARTHEST_M = 6.0
STEP_M = 0.5
GAIN = 0.5
"""Of each metre that it goes, so much must lead away from what stands there."""


def retreat(solids: Solids, place_enu_m: FloatArray) -> FloatArray:
    """The place `(3,)` at the same height, up to 6 m away, that is farthest from everything; `place_enu_m` where none is better.

    The straight way there leads away from everything all along.
    """
    turn = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    ahead = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    reach_m = np.arange(0.0, FARTHEST_M + STEP_M / 2, STEP_M)
    places = place_enu_m + reach_m[:, None, None] * ahead
    away_m = solids.distance_m(places.reshape(-1, 3)).reshape(len(reach_m), -1)
    if not np.isfinite(away_m).all():  # nothing stands there
        return place_enu_m
    leads = np.logical_and.accumulate(np.diff(away_m, axis=0) >= GAIN * STEP_M, axis=0)
    steps = leads.sum(axis=0)
    best = int(np.argmax(away_m[steps, np.arange(len(turn))]))
    farthest: FloatArray = places[steps[best], best]
    return farthest
