"""What is left of an inspection: the stretches round the shots that nobody has taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.tour.sorties import OVERLAP_SHOTS_N

__all__ = ["Stretch", "stretches_left"]

Stretch = tuple[float, float]
"""From when to when, of the inspection's own time."""


def stretches_left(
    had: NDArray[np.bool_], shots_s: FloatArray, *, end_s: float, ways_s: float
) -> tuple[Stretch, ...]:
    """The stretches that are to be flown for the shots that nobody has.

    Each begins and ends with `OVERLAP_SHOTS_N` shots beyond one that is there, to tie its pictures to the others.
    What lies between two of them is flown too when that is shorter than going home and coming back.

    Args:
        had: which shots were taken, `(n,)`.
        shots_s: when they are due, `(n,)` of the inspection's own time, rising.
        end_s: when the inspection ends.
        ways_s: how long the ways from home and back take.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ~had, [False]])))
    left: list[Stretch] = []
    for first, past in edges.reshape(-1, 2):
        before, after = first - 1 - OVERLAP_SHOTS_N, past + OVERLAP_SHOTS_N
        begin_s = float(shots_s[before]) if before >= 0 else 0.0
        until_s = float(shots_s[after]) if after < len(shots_s) else end_s
        if left and begin_s - left[-1][1] < ways_s:
            begin_s = left.pop()[0]
        left.append((begin_s, until_s))
    return tuple(left)
