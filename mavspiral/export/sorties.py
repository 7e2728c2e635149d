"""Missions that no board or battery holds, as several: each from home to a stretch of the inspection and back."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.export.thinning import Thinned, Tolerance, thin
from mavspiral.motion.trajectory import Trajectory

__all__ = ["sorties_of"]

OVERLAP_WAYPOINTS_N = 1
"""A sortie begins so many waypoints before the last one ended."""

Way = Callable[[FloatArray, FloatArray, float], Trajectory]
"""The safe way from one place to another, `(3,)` in the plan's ENU, with a yaw to keep."""


def sorties_of(
    thinned: Thinned, count: int, way: Way, tolerance: Tolerance, yaw_at: Callable[[float], float]
) -> tuple[Thinned, ...]:
    """`thinned`, which goes from home to home, as `count` missions that do; `way` and `yaw_at` join them to home."""
    if count == 1:
        return (thinned,)
    inspecting = [i for i, stage in enumerate(thinned.stages) if stage.inspects]
    first, last = max(inspecting[0] - 1, 0), inspecting[-1]
    cuts = np.round(np.linspace(first, last, count + 1)).astype(np.int64)
    sorties = []
    for begin, end in pairwise(cuts):
        from_first, to_last = begin == first, end == last
        begin = begin if from_first else begin - OVERLAP_WAYPOINTS_N
        stretch = _stretch(
            thinned, 0 if from_first else int(begin), len(thinned.t_s) - 1 if to_last else int(end)
        )
        if not from_first:
            yaw = yaw_at(float(stretch.t_s[0]))
            stretch = _joined(
                _waiting(
                    thin(way(thinned.position_enu_m[0], stretch.position_enu_m[0], yaw), tolerance),
                    stretch.t_s[0],
                ),
                stretch,
            )
        if not to_last:
            yaw = yaw_at(float(stretch.t_s[-1]))
            back = thin(way(stretch.position_enu_m[-1], thinned.position_enu_m[-1], yaw), tolerance)
            stretch = _joined(stretch, _waiting(back, stretch.t_s[-1]))
        sorties.append(stretch)
    return tuple(sorties)


def _stretch(thinned: Thinned, begin: int, end: int) -> Thinned:
    """The waypoints from `begin` to `end`, both included, and what is looked at between them."""
    before = [aim for index, aim in thinned.aims if index <= begin]
    aims = [(0, before[-1])] if before else []
    aims += [(index - begin, aim) for index, aim in thinned.aims if begin < index < end]
    stages = (thinned.stages[min(begin + 1, end)], *thinned.stages[begin + 1 : end + 1])
    return Thinned(
        thinned.t_s[begin : end + 1],
        thinned.position_enu_m[begin : end + 1],
        stages,
        tuple(aims),
        thinned.chord_error_m,
        thinned.heading_error_rad,
        thinned.cut_m,
    )


def _waiting(way: Thinned, t_s: float) -> Thinned:
    """A way that is not of the plan: its waypoints have the path time of the place that they lead to or from."""
    return Thinned(
        np.full(len(way.t_s), t_s),
        way.position_enu_m,
        way.stages,
        way.aims,
        way.chord_error_m,
        way.heading_error_rad,
        way.cut_m,
    )


def _joined(first: Thinned, second: Thinned) -> Thinned:
    """One after the other: the second begins where the first ends."""
    shift = len(first.t_s) - 1
    return Thinned(
        np.concatenate([first.t_s, second.t_s[1:]]),
        np.vstack([first.position_enu_m, second.position_enu_m[1:]]),
        (*first.stages, *second.stages[1:]),
        (*first.aims, *((index + shift, aim) for index, aim in second.aims)),
        max(first.chord_error_m, second.chord_error_m),
        max(first.heading_error_rad, second.heading_error_rad),
        max(first.cut_m, second.cut_m),
    )
