"""A level turn through a pose that shows what is unseen, or an arc of it, the camera tilted all along as there.

Where a band goes unseen on all sides of a building, the foot below the lowest safe height for one, a turn shows it in
one smooth pass; where something stands in its way, or less is unseen, an arc of the turn does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve.gaze import inward_gaze
from mavspiral.curve.spiral import SpiralPath, TooNearError, plan_spiral
from mavspiral.curve.stretch import Stretch
from mavspiral.motion.limits import Limits
from mavspiral.pieces.gap import Fill, Gap, Pose, worth_flying
from mavspiral.shape.parts import Part
from mavspiral.shape.slicing import SolidDistance
from mavspiral.survey.solids import Solids

__all__ = ["Round", "turn_through"]

BETWEEN_N = 16
"""Places between two shots at which a turn is asked whether it is safe."""
WHOLE = 0.8
"""Of a turn: a longer arc of one that is safe all the way round is flown as the turn."""


class Round(NamedTuple):
    """What turns are flown round, and how: the building, all that stands there, and what is kept from that.

    Whole ones begin near `start_enu_m`, and corners are round enough for the pace.
    """

    building: SolidDistance
    solids: Solids
    clearance_m: float
    pace: Limits
    start_enu_m: FloatArray


def turn_through(pose: Pose, gap: Gap, around: Round, *, spacing_m: float) -> Fill | None:
    """The turn at the pose's height and distance, or an arc of it, with a shot about every `spacing_m`; None if not safe."""
    turn = _level_turn(pose, gap, around)
    if turn is None:
        return None
    u = np.linspace(0.0, turn.u_end_rad, 512)
    length_m = float(np.sqrt((np.diff(turn(u), axis=0) ** 2).sum(axis=1)).sum())
    count = 3 + int(length_m / spacing_m)
    here = int(np.argmin(np.hypot(*(turn(u) - pose.place_enu_m)[:, :2].T)))
    opposite = turn.begun(float(u[here]) + np.pi)
    shots_rad = np.linspace(0.0, turn.u_end_rad, count + (count % 2 == 0))
    middle = len(shots_rad) // 2
    safe = _safe(opposite, shots_rad, around)
    gaze = inward_gaze(opposite, smoothing_m=around.pace.speed_mps)
    shows = gap.shows(opposite(shots_rad), gaze(shots_rad), np.full(len(shots_rad), pose.pitch_rad))
    before = int(np.argmin(np.append(safe[:middle][::-1], False)))
    after = int(np.argmin(np.append(safe[middle:], False)))
    begin = middle - before
    first, last = (begin + k for k in worth_flying(shows[begin : middle + after + 1], before))
    if safe.all() and last - first >= WHOLE * (len(shots_rad) - 1):
        gaze = inward_gaze(turn, smoothing_m=around.pace.speed_mps)
        return Fill(turn, gaze, pose, turn.harmonics, length_m, np.asarray(shows.any(axis=0)))
    if first == last:
        return None
    span = float(shots_rad[first]), float(shots_rad[last] - shots_rad[first])
    arc_m = length_m * span[1] / turn.u_end_rad
    shown = np.asarray(shows[first : last + 1].any(axis=0))
    return Fill(Stretch(opposite, *span), Stretch(gaze, *span), pose, turn.harmonics, arc_m, shown)


def _level_turn(pose: Pose, gap: Gap, around: Round) -> SpiralPath | None:
    """The turn round what the pose looks at; None if it is not a wall beside it."""
    away_m, height_m = float(around.building(pose.place_enu_m)), float(pose.place_enu_m[2])
    behind_enu_m = (pose.centre_enu_m - 0.5 * gap.site.heights.cell_m * pose.normal_enu)[:2]
    top_m = float(gap.site.heights.sample(behind_enu_m))
    if away_m < around.clearance_m or height_m >= top_m:
        return None
    try:
        return plan_spiral(
            around.building,
            Part(behind_enu_m, 0.0, top_m, None, False, ()),
            standoff_m=away_m,
            rise_m=away_m,
            bottom_m=height_m,
            top_m=height_m,
            clearance_m=around.clearance_m,
            corner_radius_m=around.pace.speed_mps**2 / around.pace.acceleration_mps2,
            start_enu_m=around.start_enu_m[:2],
        ).path
    except TooNearError:
        return None


def _safe(turn: SpiralPath, shots_rad: FloatArray, around: Round) -> NDArray[np.bool_]:
    """Whether the way from each shot to the next one is."""
    places = turn(np.linspace(0.0, turn.u_end_rad, BETWEEN_N * (len(shots_rad) - 1) + 1))
    clear = around.solids.clear(places[:-1], np.diff(places, axis=0), around.clearance_m)
    return np.asarray(clear.reshape(-1, BETWEEN_N).all(axis=1))
