"""From a mission to a plan: the whole recipe is `plan`.

map ─► outlines ─► spirals ─► time laws ─► trajectory ─► certificate ─► shots ─► coverage ─► gaps filled
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from mavspiral.brief import (
    budget_of,
    camera_of,
    home_enu_m,
    limits_of,
    map_request,
    pace_of,
    room_of,
    sharpness_of,
    with_keepouts,
)
from mavspiral.filling import filled, flyable, unasked_courts, with_seeable
from mavspiral.headway import within
from mavspiral.inspection import Inspection
from mavspiral.mission import Mission
from mavspiral.motion.limits import Limits
from mavspiral.pieces.of_site import pieces_of
from mavspiral.proof import judge_limits, judge_sight, proof_of, survey_of
from mavspiral.shape.readers import read_site
from mavspiral.survey.patches import patches_of
from mavspiral.survey.unseen import unseen_lines
from mavspiral.tour.passes import flown_in_order, tour_of
from mavspiral.tour.retreat import comes_down_aside
from mavspiral.tour.route import route_of, ways_of
from mavspiral.tour.transit import Ways

__all__ = ["STAGES", "OnStage", "plan", "to_nobody"]

STAGES = ("map", "curve", "timing", "transits", "certificate", "coverage")

SURVEYED, JUDGED = 0.3, 0.5
"""Shares of the coverage's headway: what is seen, and what could be; the rest is for gaps."""

BLIND_GRID_S = 2.0
"""Places this far apart are asked where one would come down."""

OnStage = Callable[[str, float], None]
"""Is told which of `STAGES` is worked on, and which share of it is done: 1 when it is."""


def to_nobody(stage: str, share: float) -> None:
    """Tells nobody."""


def plan(mission: Mission, on_stage: OnStage = to_nobody) -> Inspection:
    """The inspection of the mission's building; `on_stage` is told how far each stage is.

    Raises:
        InputError: the map, or the mission on this map, contradicts itself.
        LimitError: the plan does not keep its own limits; the place and the number are named.
    """
    watch = _Watch(on_stage)
    site_map = read_site(map_request(mission))
    site = with_keepouts(mission, site_map.site)
    watch.lap("map")

    camera, limits = camera_of(mission), limits_of(mission)
    required_m = budget_of(mission).required_m(mission.limits.clearance_m)
    pace = pace_of(mission, camera, limits)
    ways = ways_of(mission, site, required_m)
    home = home_enu_m(mission, site, ways.solids, required_m)
    found = pieces_of(mission, site, camera, pace, home, ways)
    watch.lap("curve")

    passes = flown_in_order(found.pieces, sharpness_of(mission, camera))
    watch.lap("timing")

    tour = tour_of(passes, ways)
    trajectory = route_of(site, tour, home, ways)
    watch.lap("transits")

    clearance, certificate = proof_of(mission, ways.solids, trajectory, required_m)
    watch.lap("certificate")
    judge_limits(mission, site, trajectory, certificate)

    def headway(share: float) -> None:
        on_stage("coverage", 0.99 * share)  # its end is the watch's

    shots, coverage = survey_of(
        mission, site, passes, trajectory, patches_of(site), headway=within(headway, 0.0, SURVEYED)
    )
    judge_sight(mission, coverage)
    told = (*mission.notices, *site_map.warnings, *found.told)
    draft = Inspection(
        mission=mission,
        site=site,
        passes=passes,
        tour=tour,
        home_enu_m=home,
        trajectory=trajectory,
        clearance=clearance,
        clearance_required_m=required_m,
        certificate=certificate,
        shots=shots,
        coverage=coverage,
        warnings=told,
        planning_ms=watch.laps_ms,
    )
    plain = with_seeable(draft, ways, within(headway, SURVEYED, JUDGED))
    inspection = flyable(filled(plain, ways, within(headway, JUDGED, 1.0)), plain)
    watch.lap("coverage")
    told = (*inspection.warnings, *_blind(inspection, ways), *_unseen(inspection, pace))
    return replace(inspection, warnings=told)


def _blind(inspection: Inspection, ways: Ways) -> tuple[str, ...]:
    """In words for how long it would come down on a roof, were its position lost."""
    states, site = inspection.trajectory.sampled(BLIND_GRID_S), inspection.site
    over = states.position_enu_m[site.heights.sample(states.position_enu_m) > 0.0]
    inside = [place for place in over if not comes_down_aside(ways.solids, place)]
    if not inside:
        return ()
    first = site.heights.frame.geo_point(inside[0])
    return (
        f"for some {BLIND_GRID_S * len(inside):.0f} s of {states.t_s[-1]:.0f} s it is over a roof that it would come down on if it lost its "
        f"position there, first at lat {first.lat_deg:.6f}, lon {first.lon_deg:.6f}",
    )


def _unseen(inspection: Inspection, pace: Limits) -> tuple[str, ...]:
    """In words what is unseen, and why."""
    mission = inspection.mission
    return unseen_lines(
        inspection.coverage,
        inspection.shots,
        inspection.site,
        camera_of(mission),
        narrow_m=2 * (mission.inspection.standoff_m + pace.speed_mps**2 / pace.acceleration_mps2),
        room=room_of(mission, inspection.clearance_required_m),
        roofs=mission.inspection.roof,
        closed=unasked_courts(inspection),
    )


class _Watch:
    """Laps of the planner's stages, and their sum."""

    def __init__(self, on_stage: OnStage) -> None:
        self._on_stage = on_stage
        self._begin = self._last = time.perf_counter()
        self.laps_ms: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.laps_ms[stage] = (now - self._last) * 1e3
        self.laps_ms["total"] = (now - self._begin) * 1e3
        self._last = now
        self._on_stage(stage, 1.0)
