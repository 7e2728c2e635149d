"""The flight from home round the passes and back, and what all its ways keep."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import limits_of, smaller_clearance
from mavspiral.errors import InputError
from mavspiral.mission import Mission
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.shape.heightmap import Site
from mavspiral.survey.solids import Solids
from mavspiral.tour.obstacle import nearest_obstacle
from mavspiral.tour.transit import MARGIN_M, ON_A_ROOF_M, Look, Ways, judge_home

__all__ = ["TAKEOFF_M", "route_of", "ways_of"]

TAKEOFF_M = 4.0
"""The autopilot takes off to this height above home at the least; there the trajectory begins and ends."""
ROUGH_M, STEP_M = 1.0, 0.05
"""A roof that a home stands on is so rough at the most: what rises farther beside it is a thing of its own."""


def ways_of(mission: Mission, site: Site, clearance_m: float) -> Ways:
    """The ways of a mission that keep `clearance_m`."""
    heights = site.heights
    return Ways(
        solids=Solids.of_map(heights),
        frame=heights.frame,
        top_m=heights.top_m,
        limits=limits_of(mission),
        clearance_m=clearance_m,
        ceiling_m=mission.limits.ceiling_m,
        radius_m=mission.vehicle.radius_m,
        named=partial(nearest_obstacle, mission, site),
        smaller=partial(smaller_clearance, mission),
    )


def route_of(site: Site, tour: tuple[Leg, ...], home_enu_m: FloatArray, ways: Ways) -> Trajectory:
    """Home, the way to the first pass, the tour, the way back: from above home, where the take-off ends, and back to there.

    Raises:
        InputError: home is in or at a wall, or at the ceiling.
        LimitError: no way from there to the first pass and back keeps the clearance.
    """
    above_home_m = _above_home_m(site, home_enu_m, ways)
    judge_home(site.heights, ways, home_enu_m, above_home_m)
    if above_home_m[2] > ways.ceiling_m:
        most_m = math.floor(10.0 * (ways.ceiling_m - above_home_m[2] + home_enu_m[2])) / 10.0
        raise InputError(
            f"[vehicle] home_height_m = {home_enu_m[2]:.1f}: a take-off there goes up to {above_home_m[2]:.1f} m, [limits] ceiling_m = "
            f"{ways.ceiling_m:g}. Fix: home_height_m is above the map's ground (ground_amsl_m), not above the sea; at most "
            f"{most_m:g}, or ceiling_m ≥ {math.ceil(above_home_m[2])}"
        )
    first, last = tour[0], tour[-1]
    entry, leaving = Look.at(first, 0.0), Look.at(last, last.path.u_end_rad)
    approach = ways.legs(above_home_m, first.path(0.0), "approach", (entry, entry))
    back = ways.legs(
        last.path(last.path.u_end_rad), above_home_m, "return", (leaving, leaving), ("the spiral", "home")
    )
    return Trajectory((*approach, *tour, *back))


def _above_home_m(site: Site, home_enu_m: FloatArray, ways: Ways) -> FloatArray:
    """Where the take-off ends: `TAKEOFF_M` above home, and above a roof as high as ways begin that keep the clearance from it.

    Home may lie a little lower than that roof, which is not quite as even as its map says, nor its height so well known.
    """
    keeps_m, standing_m = ways.clearance_m + MARGIN_M, float(site.heights.sample(home_enu_m))
    low_m = float(home_enu_m[2]) + TAKEOFF_M
    if standing_m > ON_A_ROOF_M:
        low_m = max(low_m, standing_m + keeps_m)
        heights_m = low_m + np.arange(0.0, ROUGH_M + STEP_M / 2, STEP_M)
        free = ways.solids.clear(
            np.column_stack([np.tile(home_enu_m[:2], (len(heights_m), 1)), heights_m]), 0.0, keeps_m - 1e-9
        )
        low_m = float(heights_m[int(np.argmax(free))])
    return np.array([*home_enu_m[:2], low_m])
