"""The flight from home round the passes and back, and what all its ways keep."""

from __future__ import annotations

from functools import partial

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import limits_of
from mavspiral.errors import InputError
from mavspiral.mission import Mission
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.shape.heightmap import Site
from mavspiral.survey.solids import Solids
from mavspiral.tour.obstacle import nearest_obstacle
from mavspiral.tour.transit import MARGIN_M, Look, Ways, judge_home

__all__ = ["TAKEOFF_M", "route_of", "ways_of"]

TAKEOFF_M = 4.0
"""The autopilot takes off to this height above home at the least; there the trajectory begins and ends."""
STANDING_M = 0.5
"""What is lower is ground that a home stands on, not a thing."""


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
    )


def route_of(site: Site, tour: tuple[Leg, ...], home_enu_m: FloatArray, ways: Ways) -> Trajectory:
    """Home, the way to the first pass, the tour, the way back: from `TAKEOFF_M` above home and back to there.

    Above a home on something that stands, the clearance is kept from that too.

    Raises:
        InputError: home is in or at a wall, or at the ceiling.
        LimitError: no way from there to the first pass and back keeps the clearance.
    """
    judge_home(site.heights, ways.solids, home_enu_m, ways.clearance_m)
    standing_m = float(site.heights.sample(home_enu_m))
    rise_m = max(TAKEOFF_M, ways.clearance_m + MARGIN_M if standing_m > STANDING_M else 0.0)
    above_home_m = home_enu_m + np.array([0.0, 0.0, rise_m])
    if above_home_m[2] > ways.ceiling_m:
        raise InputError(
            f"[vehicle] home_height_m = {home_enu_m[2]:g}: a take-off there goes up to {above_home_m[2]:g} m, [limits] ceiling_m = "
            f"{ways.ceiling_m:g}. Fix: home_height_m is above the map's ground (ground_amsl_m), not above the sea; at most "
            f"{ways.ceiling_m - rise_m:g}, or a higher ceiling_m"
        )
    first, last = tour[0], tour[-1]
    entry, leaving = Look.at(first, 0.0), Look.at(last, last.path.u_end_rad)
    approach = ways.legs(above_home_m, first.path(0.0), "approach", (entry, entry))
    back = ways.legs(
        last.path(last.path.u_end_rad), above_home_m, "return", (leaving, leaving), ("the spiral", "home")
    )
    return Trajectory((*approach, *tour, *back))
