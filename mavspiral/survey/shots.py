"""When and from where pictures are taken: one row for each shot, planned or flown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray, locked
from mavspiral.motion.trajectory import Trajectory
from mavspiral.survey.camera import Camera

__all__ = ["Shots", "flown_shots", "shots_at", "shots_of"]

GRID_S = 0.1
ROW_S = 0.02
"""The rows of a flight are this far apart: a shot at either end of the leg may lie just beside them."""


@dataclass(frozen=True, slots=True, eq=False)
class Shots:
    """Poses of the camera, roll 0: `t_s` (n,) in path time, positions (n, 3), yaw and pitch (n,), up is positive."""

    t_s: FloatArray
    position_enu_m: FloatArray
    yaw_enu_rad: FloatArray
    pitch_rad: FloatArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the fields."""
        object.__setattr__(self, "t_s", locked(self.t_s, shape=(None,), name="t_s"))
        n = len(self.t_s)
        for name, shape in (("position_enu_m", (n, 3)), ("yaw_enu_rad", (n,)), ("pitch_rad", (n,))):
            object.__setattr__(self, name, locked(getattr(self, name), shape=shape, name=name))

    def __len__(self) -> int:
        """How many there are."""
        return len(self.t_s)


def shots_of(
    trajectory: Trajectory,
    camera: Camera,
    *,
    standoffs_m: Sequence[float],
    side_overlap: float,
) -> Shots:
    """The shots along the legs of the inspection, the first and the last moment of each among them.

    Each leg has its own stand-off.
    From shot to shot neither the camera nor the place it looks at, its stand-off ahead, moves on by more than
    leaves `side_overlap` of the picture: round an inner corner the camera hardly moves, but its picture does.
    Only where the shutter needs longer, `camera.min_interval_s`, are they farther apart.
    """
    taken_s = [
        _along(
            trajectory,
            span_s,
            camera.shot_spacing_m(standoff_m, side_overlap),
            standoff_m,
            camera.min_interval_s,
        )
        for span_s, standoff_m in zip(trajectory.spans_s("inspection"), standoffs_m, strict=True)
    ]
    return _posed(trajectory, np.concatenate(taken_s))


def _along(
    trajectory: Trajectory,
    span_s: tuple[float, float],
    spacing_m: float,
    standoff_m: float,
    interval_s: float,
) -> FloatArray:
    """The times of the shots of one leg."""
    begin_s, end_s = span_s
    t_s = np.linspace(begin_s, end_s, max(2, math.ceil((end_s - begin_s) / GRID_S) + 1))
    states = trajectory(t_s)
    camera_enu_m = states.position_enu_m[:, :2]
    ahead = np.stack([np.cos(states.yaw_enu_rad), np.sin(states.yaw_enu_rad)], axis=1)
    ahead *= np.cos(states.gimbal_pitch_rad)[:, None]
    ways_m = [_steps_m(camera_enu_m), _steps_m(camera_enu_m + standoff_m * ahead)]
    progress_m = np.concatenate([[0.0], np.cumsum(np.maximum(*ways_m))])

    gaps = min(math.ceil(progress_m[-1] / spacing_m), math.floor((end_s - begin_s) / interval_s + 1e-9))
    index = np.arange(max(gaps, 1) + 1)
    wanted_s = np.interp(index / index[-1] * progress_m[-1], progress_m, t_s)
    wanted_s[0], wanted_s[-1] = begin_s, end_s
    return _apart(wanted_s, interval_s)


def flown_shots(
    shots: Shots, path_t_s: FloatArray, position_enu_m: FloatArray, yaw_enu_rad: FloatArray
) -> Shots:
    """The planned shots from where they were really taken.

    A shot is taken when the flight's path time `path_t_s` (rows, NaN where there is none) crosses its own. Poses
    are interpolated between the rows; shots that the flight never came to are left out.
    """
    known = np.flatnonzero(np.isfinite(path_t_s))
    if not len(known):
        return Shots(np.empty(0), np.empty((0, 3)), np.empty(0), np.empty(0))
    row_t_s = path_t_s[known]
    # Where path time stands still, the first row of that time is the crossing.
    onward = known[np.concatenate([[True], row_t_s[1:] > np.maximum.accumulate(row_t_s)[:-1]])]
    row_t_s = path_t_s[onward]
    taken = (shots.t_s >= row_t_s[0] - ROW_S) & (shots.t_s <= row_t_s[-1] + ROW_S)
    t_s = shots.t_s[taken]
    places = [np.interp(t_s, row_t_s, position_enu_m[onward, axis]) for axis in range(3)]
    return Shots(
        t_s,
        np.stack(places, axis=1),
        np.interp(t_s, row_t_s, yaw_enu_rad[onward]),
        shots.pitch_rad[taken],
    )


def shots_at(
    t_s: FloatArray,
    row_t_s: FloatArray,
    position_enu_m: FloatArray,
    yaw_enu_rad: FloatArray,
    pitch_rad: FloatArray,
) -> Shots:
    """Shots at the times `t_s`, posed by rows of a flight: one clock for both, rising, yaw unwrapped."""
    places = [np.interp(t_s, row_t_s, position_enu_m[:, axis]) for axis in range(3)]
    return Shots(
        t_s,
        np.stack(places, axis=1),
        np.interp(t_s, row_t_s, yaw_enu_rad),
        np.interp(t_s, row_t_s, pitch_rad),
    )


def _posed(trajectory: Trajectory, t_s: FloatArray) -> Shots:
    states = trajectory(t_s)
    return Shots(t_s, states.position_enu_m, states.yaw_enu_rad, states.gimbal_pitch_rad)


def _steps_m(place_m: FloatArray) -> FloatArray:
    steps_m: FloatArray = np.hypot(*np.diff(place_m, axis=0).T)
    return steps_m


def _apart(t_s: FloatArray, interval_s: float) -> FloatArray:
    """Rising times moved as little as need be for gaps of `interval_s`; the first and the last stay."""
    if (t_s[-1] - t_s[0]) < interval_s * (len(t_s) - 1):
        return t_s
    ramp_s = interval_s * np.arange(len(t_s))
    later_s = np.maximum.accumulate(t_s - ramp_s) + ramp_s
    apart_s: FloatArray = np.minimum(later_s, t_s[-1] - ramp_s[::-1])
    return apart_s
