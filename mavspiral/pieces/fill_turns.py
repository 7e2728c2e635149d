"""A level turn through a pose that shows what is unseen, the camera tilted as there all the way round.

Where a band goes unseen on all sides of a building, the foot below the lowest safe height for one, a turn shows it in
one smooth pass.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve.gaze import inward_gaze
from mavspiral.curve.spiral import TooNearError, plan_spiral
from mavspiral.motion.limits import Limits
from mavspiral.pieces.gap import Fill, Gap, Pose
from mavspiral.shape.parts import Part
from mavspiral.shape.slicing import SolidDistance
from mavspiral.survey.solids import Solids

__all__ = ["Round", "turn_through"]

SAMPLES = 256


class Round(NamedTuple):
    """What turns are flown round, and how: the building, all that stands there, and what is kept from that.

    They begin near `start_enu_m`, and their corners are round enough for the pace.
    """

    building: SolidDistance
    solids: Solids
    clearance_m: float
    pace: Limits
    start_enu_m: FloatArray


def turn_through(pose: Pose, gap: Gap, around: Round, *, spacing_m: float) -> Fill | None:
    """The turn at the pose's height and distance, with a shot every `spacing_m`; None where none is safe all the way round."""
    away_m, height_m = float(around.building(pose.place_enu_m)), float(pose.place_enu_m[2])
    behind_enu_m = (pose.centre_enu_m - 0.5 * gap.site.heights.cell_m * pose.normal_enu)[:2]
    top_m = float(gap.site.heights.sample(behind_enu_m))
    if away_m < around.clearance_m or height_m >= top_m:
        return None
    try:
        path = plan_spiral(
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
    places = path(np.linspace(0.0, path.u_end_rad, SAMPLES))
    sides = np.diff(places, axis=0)
    if not around.solids.clear(places[:-1], sides, around.clearance_m).all():
        return None
    length_m = float(np.sqrt((sides**2).sum(axis=1)).sum())
    shots_rad = np.linspace(0.0, path.u_end_rad, 2 + int(length_m / spacing_m))
    gaze = inward_gaze(path, smoothing_m=around.pace.speed_mps)
    shows = gap.shows(path(shots_rad), gaze(shots_rad), np.full(len(shots_rad), pose.pitch_rad))
    return Fill(path, gaze, pose, path.harmonics, length_m, np.asarray(shows.any(axis=0)))
