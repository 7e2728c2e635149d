"""How exact the missions of a trajectory can be: what the clearance demands and what the board holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mavspiral.errors import LimitError
from mavspiral.export.corners import cut_lines_m
from mavspiral.export.items import MissionItems
from mavspiral.export.thinning import Tolerance
from mavspiral.survey.solids import Solids

__all__ = ["Board", "Fit", "fitted"]

TOLERANCE = Tolerance(chord_m=0.35, heading_rad=math.radians(12.0))
"""Found by flying the kiosk in AUTO. Finer chords are shorter, and PX4 flies no faster than lets it stop two waypoints
ahead: the inspection takes 88 s at 0.2 m and 84 s at 0.35 m; at 0.5 m it takes 82 s and strays further."""

FINEST, COARSEST = 0.1, 2.0
STEP = 1.25
SORTIES_MAX = 24
AUTO_SLOWER = 1.3
AROUND_S = 60.0
"""Flown: from home to home AUTO takes up to 1.3 times the plan's time and a minute to take off and to land."""


@dataclass(frozen=True, slots=True)
class Board:
    """What a mission must fit into."""

    items_max: int
    endurance_s: float


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Missions that fit, and what that cost: their least clearance, and how much coarser than wished they are."""

    missions: tuple[MissionItems, ...]
    clearance_m: float
    coarser: float


def fitted(
    made: Callable[[Tolerance, int], tuple[MissionItems, ...]],
    board: Board,
    solids: Solids,
    required_m: float,
) -> Fit:
    """The fewest missions, then the most exact ones, that keep the clearance and fit the board.

    Args:
        made: the missions for a tolerance and a number of sorties.
        board: what each of them must fit into.
        solids: what stands there.
        required_m: the clearance that the lines between the waypoints must keep, corners cut.

    Raises:
        LimitError: there are none; the number and the limit are named.
    """
    scale, missions = 1.0, made(TOLERANCE, 1)
    while (finest_m := _clearance_m(missions, solids)) < required_m:
        scale /= 2.0
        if scale < FINEST:
            raise LimitError(
                f"as a mission the flight comes within {finest_m:.2f} m of something solid, {required_m:.2f} m are required, "
                "however close the waypoints. Fix: a larger standoff_m, or stream it with `mavspiral fly`"
            )
        missions = made(TOLERANCE.scaled(scale), 1)
    finest = scale
    for count in range(1, SORTIES_MAX + 1):
        scale = finest
        while scale <= max(COARSEST, finest):
            missions = made(TOLERANCE.scaled(scale), count)
            least_m = _clearance_m(missions, solids)
            if least_m < required_m or any(_lasts_s(m) > board.endurance_s for m in missions):
                break
            if all(len(mission.items) <= board.items_max for mission in missions):
                return Fit(missions, least_m, scale / finest)
            scale *= STEP
    items = max(len(mission.items) for mission in missions)
    lasts_s = max(_lasts_s(mission) for mission in missions)
    raise LimitError(
        f"even in {SORTIES_MAX} sorties the mission takes {items} items ([vehicle] max_items = {board.items_max}) and "
        f"{lasts_s:.0f} s (endurance_s = {board.endurance_s:g}). Fix: larger ones, or stream it with `mavspiral fly`"
    )


def _clearance_m(missions: tuple[MissionItems, ...], solids: Solids) -> float:
    nearest_m = math.inf
    for mission in missions:
        lines = cut_lines_m(mission.thinned.position_enu_m, mission.thinned.radius_m)
        nearest_m = min(nearest_m, float(solids.distance_m(*lines).min()))
    return nearest_m


def _lasts_s(mission: MissionItems) -> float:
    """How long the flight takes, roughly: what is planned, or the way at the leg's speed, slower, and both ends."""
    thinned = mission.thinned
    length_m = np.sqrt((np.diff(thinned.position_enu_m, axis=0) ** 2).sum(axis=1))
    speed_mps = np.array([stage.speed_mps for stage in thinned.stages[1:]])
    return AUTO_SLOWER * float(np.maximum(np.diff(thinned.t_s), length_m / speed_mps).sum()) + AROUND_S
