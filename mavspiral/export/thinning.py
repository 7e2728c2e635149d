"""The fewest waypoints that keep a trajectory's shape and gaze, or as many as a board can hold."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.export.aiming import Aim, aim_over
from mavspiral.export.corners import CUT_M, acceptance_m
from mavspiral.motion.trajectory import Trajectory, TrajectoryState, belongs

__all__ = ["Stage", "Thinned", "Tolerance", "thin"]

GRID_S = 0.1
SPEED_MIN_MPS = 0.5
LEAD_S = 0.2
"""The aims follow the gaze of so much later, because PX4's heading lags. Flown, 95 % of the pictures are within 11.8° of
their gaze round the kiosk (15.6° without), 10.0° round the torre (13.3°), 11.0° round the asilo (11.2°); with 0.35 s it
is 10.3° round the kiosk, but 15.7° round the asilo, whose corners come at once."""

SAGITTAS = (2.0, 1.7, 1.4, 1.2, 1.0)
"""How far a chord may be from the curve, in chord errors, before its ends are moved outwards; the last: they are not."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far the polygon of the waypoints may stray from the curve, the camera's aim from its gaze, a cut from a corner."""

    chord_m: float
    heading_rad: float
    cut_m: float = CUT_M

    def scaled(self, factor: float) -> Tolerance:
        """All of them larger or smaller; but corners are never cut deeper."""
        return Tolerance(self.chord_m * factor, self.heading_rad * factor, self.cut_m * min(factor, 1.0))


@dataclass(frozen=True, slots=True)
class Stage:
    """A leg as a mission knows it: its name and the greatest speed that is planned on it."""

    name: str
    speed_mps: float

    @property
    def inspects(self) -> bool:
        """Whether pictures are taken on it."""
        return belongs(self.name, "inspection")


@dataclass(frozen=True, slots=True, eq=False)
class Thinned:
    """Waypoints along a trajectory, where to look between them, and how far both stray from it.

    Args:
        t_s: the path times (n,) of the waypoints.
        position_enu_m: their places (n, 3), beside the curve where it bends.
        stages: for each waypoint, what leads to it; the first one's leads from it.
        aims: what to look at, from the waypoint of that number on; none where the nose is turned from waypoint to waypoint.
        heading_error_rad: how far the aims, or even turns, are off the gaze `LEAD_S` later.
        cut_m: how deep a corner may be cut.
        yaw_enu_rad: the gaze (n,) of `LEAD_S` later, continuous.
        pitch_rad: of the camera (n,), from each waypoint to the next.
    """

    t_s: FloatArray
    position_enu_m: FloatArray
    stages: tuple[Stage, ...]
    aims: tuple[tuple[int, Aim], ...]
    chord_error_m: float
    heading_error_rad: float
    cut_m: float
    yaw_enu_rad: FloatArray
    pitch_rad: FloatArray

    @property
    def radius_m(self) -> FloatArray:
        """The acceptance radius of each waypoint."""
        return acceptance_m(self.position_enu_m, self.cut_m)


def thin(
    trajectory: Trajectory, tolerance: Tolerance, stops_s: tuple[float, ...] = (), *, turns: bool = False
) -> Thinned:
    """The fewest waypoints within the tolerance: the ends of the legs, `stops_s`, and what is needed between.

    From each to the next the camera keeps a point in view, or the nose `turns` evenly, and could keep one in view too: without
    that the asilo's sudden turns, flown at AUTO's own pace, are up to 45° late. None of them can be left out.
    The chords' middles stray to one side of the curve as far as the waypoints to the other: so a chord may be
    √2 times as long as one between points of the curve.
    """
    states = trajectory.sampled(GRID_S)
    states = replace(states, yaw_enu_rad=np.interp(states.t_s + LEAD_S, states.t_s, states.yaw_enu_rad))
    corners = np.cumsum([0.0, *(leg.law.duration_s for leg in trajectory.legs)])
    wanted_s = np.concatenate([corners, stops_s])
    stops = np.unique(np.clip(np.round(wanted_s / GRID_S).astype(np.int64), 0, len(states.t_s) - 1))
    stops[-1] = len(states.t_s) - 1

    def looks(begin: int, end: int) -> bool:
        if turns and _turn_error_rad(states, begin, end) > tolerance.heading_rad:
            return False
        return aim_over(states, begin, end).error_rad <= tolerance.heading_rad

    def within(sagitta_m: float, begin: int, end: int) -> bool:
        return _bulge_m(states.position_enu_m[begin : end + 1]) <= sagitta_m and looks(begin, end)

    for sagitta in SAGITTAS:
        kept = [0]
        for begin, end in itertools.pairwise(stops):
            kept += _leg(partial(within, sagitta * tolerance.chord_m), int(begin), int(end))
        index = np.array(kept)
        share = 0.5 if sagitta > 1.0 else 0.0
        places = _balanced(states.position_enu_m, index, np.isin(index, stops), share)
        chord_error_m = _stray_m(states.position_enu_m, index, places)
        if chord_error_m <= tolerance.chord_m:
            break
    index, places = _pruned(
        states.position_enu_m, index, places, set(stops.tolist()), looks, tolerance.chord_m
    )
    chord_error_m = _stray_m(states.position_enu_m, index, places)
    aims = () if turns else _aims(states, index, tolerance)
    sides = tuple(itertools.pairwise(index.tolist()))
    errors_rad = (
        [_turn_error_rad(states, *side) for side in sides] if turns else [a.error_rad for _, a in aims]
    )
    stages = _stages(trajectory, states)
    ends = np.clip(np.searchsorted(corners, states.t_s[index] - GRID_S / 2) - 1, 0, len(stages) - 1)
    return Thinned(
        t_s=states.t_s[index],
        position_enu_m=places,
        stages=tuple(stages[i] for i in ends),
        aims=aims,
        chord_error_m=chord_error_m,
        heading_error_rad=max(errors_rad),
        cut_m=tolerance.cut_m,
        yaw_enu_rad=states.yaw_enu_rad[index],
        pitch_rad=np.array([_middle_pitch_rad(states, *side) for side in (*sides, (index[-1], index[-1]))]),
    )


def _stages(trajectory: Trajectory, states: TrajectoryState) -> list[Stage]:
    begins_s = np.cumsum([0.0, *(leg.law.duration_s for leg in trajectory.legs)])
    speed_mps = np.sqrt((states.velocity_enu_mps**2).sum(axis=1))
    stages = []
    for leg, (begin_s, end_s) in zip(trajectory.legs, itertools.pairwise(begins_s), strict=True):
        on = (states.t_s >= begin_s) & (states.t_s <= end_s)
        greatest_mps = float(speed_mps[on].max(initial=0.0))
        stages.append(Stage(leg.name, max(SPEED_MIN_MPS, round(greatest_mps, 2))))
    return stages


def _leg(within: Callable[[int, int], bool], begin: int, end: int) -> list[int]:
    """Greedy: from each waypoint the farthest next one whose chord and aim are still `within` bounds."""
    kept, here = [], begin
    while here < end:
        good, step = here + 1, 1
        while good < end:
            ahead = min(good + step, end)
            if within(here, ahead):
                good, step = ahead, step * 2
            elif step == 1:
                break
            else:
                step = 1
        kept.append(good)
        here = good
    return kept


def _bulge_m(position_m: FloatArray) -> float:
    return float(np.sqrt((_offsets_m(position_m) ** 2).sum(axis=1)).max())


def _turn_error_rad(states: TrajectoryState, begin: int, end: int) -> float:
    """How far the gaze is from an even turn between two rows, and its pitch from the middle."""
    yaw_rad, pitch_rad = states.yaw_enu_rad[begin : end + 1], states.gimbal_pitch_rad[begin : end + 1]
    even_rad = np.linspace(yaw_rad[0], yaw_rad[-1], len(yaw_rad))
    return float(max(np.abs(yaw_rad - even_rad).max(), 0.5 * np.ptp(pitch_rad)))


def _middle_pitch_rad(states: TrajectoryState, begin: int, end: int) -> float:
    pitch_rad = states.gimbal_pitch_rad[begin : end + 1]
    return 0.5 * float(pitch_rad.min() + pitch_rad.max())


def _offsets_m(position_m: FloatArray) -> FloatArray:
    """From the straight line between the first and the last of the points to each of them."""
    return _from_chord_m(position_m, position_m[0], position_m[-1])


def _from_chord_m(position_m: FloatArray, begin_m: FloatArray, end_m: FloatArray) -> FloatArray:
    offset, chord = position_m - begin_m, end_m - begin_m
    length_2 = float((chord * chord).sum())
    along = np.clip((offset @ chord) / length_2, 0.0, 1.0) if length_2 > 0 else np.zeros(len(offset))
    away: FloatArray = offset - along[:, None] * chord
    return away


def _balanced(position_m: FloatArray, index: np.ndarray, fixed: np.ndarray, share: float) -> FloatArray:
    """The waypoints moved outwards by a share of how far inside the worse of the chords beside them is."""
    places: FloatArray = position_m[index].copy()
    bulge = np.zeros((len(index) - 1, 3))
    for i, (a, b) in enumerate(itertools.pairwise(index)):
        away = _offsets_m(position_m[a : b + 1])
        bulge[i] = away[int(np.argmax((away**2).sum(axis=1)))]
    size = (bulge**2).sum(axis=1)
    places[1:-1] += share * np.where((size[:-1] > size[1:])[:, None], bulge[:-1], bulge[1:])
    places[fixed] = position_m[index][fixed]
    return places


def _pruned(
    position_m: FloatArray,
    index: np.ndarray,
    places: FloatArray,
    fixed: set[int],
    looks: Callable[[int, int], bool],
    chord_m: float,
) -> tuple[np.ndarray, FloatArray]:
    """Without the waypoints that its neighbours, moved outwards, do not need any more."""
    kept = [0]
    for i in range(1, len(index) - 1):
        begin, end = int(index[kept[-1]]), int(index[i + 1])
        away = _from_chord_m(position_m[begin : end + 1], places[kept[-1]], places[i + 1])
        near = float((away**2).sum(axis=1).max()) <= chord_m**2
        if int(index[i]) in fixed or not (near and looks(begin, end)):
            kept.append(i)
    kept.append(len(index) - 1)
    if len(kept) == len(index):
        return index, places
    return _pruned(position_m, index[kept], places[kept], fixed, looks, chord_m)


def _stray_m(position_m: FloatArray, index: np.ndarray, places: FloatArray) -> float:
    """The largest distance between curve and polygon, either way."""
    worst = 0.0
    for i, (a, b) in enumerate(itertools.pairwise(index)):
        away = _from_chord_m(position_m[a : b + 1], places[i], places[i + 1])
        worst = max(worst, float((away**2).sum(axis=1).max()))
    moved = ((places - position_m[index]) ** 2).sum(axis=1).max()
    return math.sqrt(max(worst, float(moved)))


def _aims(states: TrajectoryState, index: np.ndarray, tolerance: Tolerance) -> tuple[tuple[int, Aim], ...]:
    """Greedy: each aim for as many chords as it serves."""
    aims: list[tuple[int, Aim]] = []
    first = 0
    while first < len(index) - 1:
        last = first + 1
        aim = aim_over(states, int(index[first]), int(index[last]))
        while last + 1 < len(index):
            wider = aim_over(states, int(index[first]), int(index[last + 1]))
            if wider.error_rad > tolerance.heading_rad:
                break
            aim, last = wider, last + 1
        aims.append((first, aim))
        first = last
    return tuple(aims)
