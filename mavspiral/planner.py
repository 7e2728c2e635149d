"""From a mission to a plan: the whole recipe is `plan`.

map ─► outlines ─► spirals ─► time laws ─► trajectory ─► certificate ─► shots ─► coverage ─► gaps filled
"""

from __future__ import annotations

import time
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
from mavspiral.errors import LimitError
from mavspiral.filling import Draft, filled, survey_of, with_seeable
from mavspiral.inspection import Inspection
from mavspiral.mission import Mission
from mavspiral.pieces.of_site import pieces_of
from mavspiral.proof import failures_of, proof_of, remedy_of
from mavspiral.shape.readers import read_site
from mavspiral.survey.patches import patches_of
from mavspiral.survey.unseen import unseen_lines
from mavspiral.tour.passes import flown_in_order, tour_of
from mavspiral.tour.route import route_of, ways_of

__all__ = ["plan"]


def plan(mission: Mission) -> Inspection:
    """The inspection of the mission's building.

    Raises:
        InputError: the map, or the mission on this map, contradicts itself.
        LimitError: the plan does not keep its own limits; the place and the number are named.
    """
    watch = _Watch()
    site_map = read_site(map_request(mission))
    site = with_keepouts(mission, site_map.site)
    camera, limits = camera_of(mission), limits_of(mission)
    watch.lap("map")

    required_m = budget_of(mission).required_m(mission.limits.clearance_m)
    home = home_enu_m(mission, site, required_m)
    pace = pace_of(mission, camera, limits)
    ways = ways_of(mission, site, required_m)
    found = pieces_of(mission, site, camera, pace, home, ways)
    watch.lap("curve")

    passes = flown_in_order(found.pieces, sharpness_of(mission, camera))
    watch.lap("timing")

    tour = tour_of(passes, ways)
    trajectory = route_of(site, tour, home, ways)
    watch.lap("transits")

    clearance, certificate = proof_of(mission, site, trajectory, required_m)
    watch.lap("certificate")
    if not certificate.ok:
        raise LimitError(
            f"{mission.name}: the plan fails its limits: {'; '.join(failures_of(mission, site, trajectory, certificate))}. "
            f"Fix: {remedy_of(certificate)}"
        )

    shots, coverage = survey_of(mission, site, passes, trajectory, patches_of(site))
    if coverage.walls == 0.0:
        raise LimitError(
            f"{mission.name}: no wall is seen within [quality] gsd_max_mm = {mission.quality.gsd_max_mm:g} and incidence_max_deg = "
            f"{mission.quality.incidence_max_deg:g}: a pixel is {1e3 * camera.gsd_m(mission.inspection.standoff_m):.1f} mm at standoff_m = "
            f"{mission.inspection.standoff_m:g}. Fix: a smaller standoff_m, a longer lens, or a larger gsd_max_mm"
        )
    plain = with_seeable(
        Draft(passes, tour, trajectory, clearance, certificate, shots, coverage), mission, site, ways
    )
    draft = filled(plain, mission, site, home, ways)
    watch.lap("coverage")

    def inspection_of(draft: Draft) -> Inspection:
        unseen = unseen_lines(
            draft.coverage,
            draft.shots,
            site,
            camera,
            narrow_m=2 * (mission.inspection.standoff_m + pace.speed_mps**2 / pace.acceleration_mps2),
            room=room_of(mission, required_m),
            roofs=mission.inspection.roof,
        )
        return Inspection(
            mission,
            site,
            draft.passes,
            draft.tour,
            home,
            draft.trajectory,
            draft.clearance,
            required_m,
            draft.certificate,
            draft.shots,
            draft.coverage,
            (*mission.notices, *site_map.warnings, *found.told, *draft.told, *unseen),
            watch.laps_ms,
        )

    inspection = inspection_of(draft)
    try:
        inspection.sorties()  # refuses what no battery can fly
    except LimitError as error:
        if draft.passes == plain.passes:
            raise
        told = f"not flown: the lines for what is unseen, with which no battery lasts: {error}"
        inspection = inspection_of(replace(plain, told=(told,)))
        inspection.sorties()
    return inspection


class _Watch:
    """Laps of the planner's stages, and their sum."""

    def __init__(self) -> None:
        self._begin = self._last = time.perf_counter()
        self.laps_ms: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.laps_ms[stage] = (now - self._last) * 1e3
        self.laps_ms["total"] = (now - self._begin) * 1e3
        self._last = now
