"""The fewest waypoints: by brute force, not one of them can be left out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from mavspiral.export.aiming import aim_over
from mavspiral.export.thinning import LEAD_S, Tolerance, thin

TOLERANCE = Tolerance(0.35, np.radians(12.0))


def off_chord_m(place_m, begin_m, end_m):
    """The farthest of the places (n, 3) from the straight line between two points."""
    way = end_m - begin_m
    along = np.clip((place_m - begin_m) @ way / max(way @ way, 1e-12), 0.0, 1.0)
    return np.linalg.norm(place_m - begin_m - along[:, None] * way, axis=1).max()


def off_turn_rad(states, begin, end):
    """How far the gaze is off an even turn, and its pitch off the middle."""
    yaw = states.yaw_enu_rad[begin : end + 1]
    pitch = states.gimbal_pitch_rad[begin : end + 1]
    even = yaw[0] + (yaw[-1] - yaw[0]) * np.arange(len(yaw)) / (len(yaw) - 1)
    return max(np.abs(yaw - even).max(), (pitch.max() - pitch.min()) / 2)


@pytest.mark.parametrize("turns", [False, True], ids=["points kept in view", "even turns"])
@pytest.mark.parametrize("name", ["kiosk", "asilo", "l_block"])
def test_without_any_one_of_them_the_stated_errors_are_broken(planned, name, turns):
    trajectory = planned(name).trajectory
    thinned = thin(trajectory, TOLERANCE, turns=turns)
    states = trajectory.sampled(0.1)
    states.yaw_enu_rad.flags.writeable = True
    states.yaw_enu_rad[:] = np.interp(states.t_s + LEAD_S, states.t_s, states.yaw_enu_rad.copy())
    row = np.round(thinned.t_s * 10).astype(int).clip(0, len(states.t_s) - 1)
    row[-1] = len(states.t_s) - 1

    def errors(begin, end):
        """Chord and heading error from waypoint to waypoint, over those between."""
        here, there = row[begin], row[end]
        chord_m = off_chord_m(
            states.position_enu_m[here : there + 1],
            thinned.position_enu_m[begin],
            thinned.position_enu_m[end],
        )
        aimed_rad = aim_over(states, int(here), int(there)).error_rad
        return chord_m, max(aimed_rad, off_turn_rad(states, here, there)) if turns else aimed_rad

    sides = [errors(i, i + 1) for i in range(len(row) - 1)]
    assert max(chord_m for chord_m, _ in sides) <= thinned.chord_error_m + 1e-3 <= TOLERANCE.chord_m + 1e-3
    assert max(heading for _, heading in sides) <= TOLERANCE.heading_rad + 1e-3
    assert thinned.heading_error_rad <= TOLERANCE.heading_rad
    legs_s = np.cumsum([leg.law.duration_s for leg in trajectory.legs])
    tried_n = 0
    for (before, _), (i, t_s) in pairwise(enumerate(thinned.t_s[:-1])):
        if np.abs(legs_s - t_s).min() < 0.06:
            continue  # where a leg ends it stands
        chord_m, heading_rad = errors(before, i + 1)
        assert chord_m > TOLERANCE.chord_m or heading_rad > TOLERANCE.heading_rad, (i, t_s)
        tried_n += 1
    assert tried_n > 10
