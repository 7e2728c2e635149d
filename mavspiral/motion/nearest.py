"""Where on a trajectory somebody was who flew it at times of his own."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.motion.trajectory import Trajectory

__all__ = ["path_times_s"]

GRID_S = 0.05
AHEAD_S = 6.0
"""No farther ahead is looked for him: the next turn of a spiral passes near by, but later."""


def path_times_s(trajectory: Trajectory, position_enu_m: FloatArray) -> FloatArray:
    """For each of the positions `(n, 3)`, in the order they were flown, the path time of the nearest point, `(n,)`.

    Path time never runs backwards. Between the points of a grid it is that of the foot on the chord.
    """
    states = trajectory.sampled(GRID_S)
    points, t_s = states.position_enu_m, states.t_s
    ahead = round(AHEAD_S / GRID_S)
    here, times = 0, np.empty(len(position_enu_m))
    for row, place in enumerate(position_enu_m):
        window = points[here : here + ahead + 1] - place
        here += int(np.argmin(np.einsum("ij,ij->i", window, window)))
        times[row] = t_s[here] + _foot_s(points, t_s, here, place)
    return np.asarray(np.maximum.accumulate(times))


def _foot_s(points: FloatArray, t_s: FloatArray, here: int, place: FloatArray) -> float:
    """How long before or after grid point `here` the trajectory is nearest to `place`."""
    before, after = max(here - 1, 0), min(here + 1, len(points) - 1)
    chord = points[after] - points[before]
    length_2 = float(chord @ chord)
    if length_2 == 0.0:
        return 0.0
    share = float((place - points[here]) @ chord) / length_2
    return float(np.clip(share * (t_s[after] - t_s[before]), t_s[before] - t_s[here], t_s[after] - t_s[here]))
