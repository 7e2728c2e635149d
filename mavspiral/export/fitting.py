"""How exact the mission of a route can be: what the clearance demands and what the board holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from mavspiral.errors import LimitError
from mavspiral.export.corners import cut_lines_m
from mavspiral.export.items import MissionItems
from mavspiral.export.thinning import Tolerance
from mavspiral.survey.solids import Solids

__all__ = ["AROUND_S", "AUTO_SLOWER", "Fit", "fitted"]

TOLERANCE = Tolerance(chord_m=0.35, heading_rad=math.radians(12.0))
"""Found by flying the kiosk in AUTO. Finer chords are shorter, and PX4 flies no faster than lets it stop two waypoints
ahead: the inspection takes 88 s at 0.2 m and 84 s at 0.35 m; at 0.5 m it takes 82 s and strays further."""

FINEST, COARSEST = 0.1, 2.0
STEP = 1.25
AUTO_SLOWER = 1.3
AROUND_S = 60.0
"""Flown: from home to home AUTO takes up to 1.3 times the plan's time and a minute to take off and to land."""


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A mission, its least clearance with corners cut, and how much coarser than wished it is."""

    mission: MissionItems
    clearance_m: float
    coarser: float


def fitted(
    made: Callable[[Tolerance], MissionItems], items_max: int, solids: Solids, required_m: float
) -> Fit:
    """The most exact mission of at most `items_max` items, or the shortest one if all have more.

    Args:
        made: the mission for a tolerance.
        items_max: what the board holds.
        solids: what stands there.
        required_m: the clearance that the lines between the waypoints must keep, corners cut.

    Raises:
        LimitError: none keeps the clearance.
    """
    scale = 1.0
    fit = _fit(made, scale, scale, solids)
    while fit.clearance_m < required_m:
        scale /= 2.0
        if scale < FINEST:
            raise LimitError(
                f"as a mission the flight comes within {fit.clearance_m:.2f} m of something solid, {required_m:.2f} m are "
                "required, however close the waypoints. Fix: a larger standoff_m, or stream it with `mavspiral fly`"
            )
        fit = _fit(made, scale, scale, solids)
    finest = scale
    while len(fit.mission.items) > items_max and scale * STEP <= max(COARSEST, finest):
        scale *= STEP
        coarser = _fit(made, scale, finest, solids)
        if coarser.clearance_m < required_m:
            break
        fit = coarser
    return fit


def _fit(made: Callable[[Tolerance], MissionItems], scale: float, finest: float, solids: Solids) -> Fit:
    mission = made(TOLERANCE.scaled(scale))
    lines = cut_lines_m(mission.thinned.position_enu_m, mission.thinned.radius_m)
    return Fit(mission, float(solids.distance_m(*lines).min()), scale / finest)
