"""From a mission to a plan: the whole recipe is `plan`.

map ─► outlines ─► spirals ─► time laws ─► trajectory ─► certificate ─► shots ─► coverage
"""

from __future__ import annotations

import math
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import (
    budget_of,
    camera_of,
    demand_of,
    home_enu_m,
    limits_of,
    map_request,
    pace_of,
    sharpness_of,
    with_keepouts,
)
from mavspiral.errors import LimitError
from mavspiral.flight.shutter import ShotOrders
from mavspiral.mission import Mission
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory, TrajectoryState, during
from mavspiral.obstacle import nearest_obstacle
from mavspiral.passes import Pass, flown_in_order, retimed, tour_of
from mavspiral.pieces import pieces_of
from mavspiral.route import route_of, ways_of
from mavspiral.shape.heightmap import Site
from mavspiral.shape.readers import read_site
from mavspiral.sorties import Sortie, digest_of, plan_sorties, shots_on, stretch
from mavspiral.survey.certificate import (
    STRAIGHT_ON,
    Certificate,
    blur_figure,
    ceiling_figure,
    clearance_figures,
    motion_figures,
)
from mavspiral.survey.clearance import Clearance, measure_clearance, run_on_m
from mavspiral.survey.coverage import Coverage, measure_coverage
from mavspiral.survey.patches import patches_of
from mavspiral.survey.shots import Shots, flown_shots, shots_of
from mavspiral.survey.unseen import unseen_lines
from mavspiral.transit import MARGIN_M, REACTION_S, Look

__all__ = ["Inspection", "plan"]

GRID_S = 0.01
"""Limits are judged on this grid."""

CLEARANCE_GRID_S = 0.2
"""Clearance is that of the straight ways between places this far apart: at 5 m/s and 2 m/s² within 1 cm of the curve."""


@dataclass(frozen=True, slots=True, eq=False)
class Inspection:
    """A plan: the curve, when to be where on it, and the proof that it keeps its limits."""

    mission: Mission
    site: Site
    passes: tuple[Pass, ...]
    tour: tuple[Leg, ...]
    home_enu_m: FloatArray
    trajectory: Trajectory
    clearance: Clearance
    clearance_required_m: float
    certificate: Certificate
    shots: Shots
    coverage: Coverage
    warnings: tuple[str, ...]
    planning_ms: dict[str, float]

    def route_from(self, home_enu_m: FloatArray, sortie: Sortie | None = None) -> Trajectory:
        """The same inspection, or a sortie of it, flown from another home, `(3,)` in the plan's ENU.

        Raises:
            InputError: that home is in or at a wall.
            LimitError: no way from there to the first pass and back keeps the clearance.
        """
        legs = self.tour if sortie is None else sortie.legs
        ways = ways_of(self.mission, self.site, self.clearance_required_m)
        return route_of(self.site, legs, home_enu_m, ways)

    @property
    def shots_s(self) -> FloatArray:
        """When the shots are due, `(n,)` of the inspection's own time, which begins with it."""
        due_s: FloatArray = self.shots.t_s - self.trajectory.span_s("inspection")[0]
        return due_s

    @property
    def duration_s(self) -> float:
        """How long the inspection takes as planned in one go, without the ways to it and back."""
        begin_s, end_s = self.trajectory.span_s("inspection")
        return end_s - begin_s

    @property
    def digest(self) -> str:
        """Which inspection this is: another if it leads elsewhere, wherever its home is."""
        return digest_of(self.tour, self.shots_s)

    def sorties(
        self, begin_s: float = 0.0, end_s: float = math.inf, *, endurance_s: float | None = None
    ) -> tuple[Sortie, ...]:
        """The flights, each of one battery, that fly the inspection from `begin_s` to `end_s` of its own time, or its end.

        No flight takes longer than `endurance_s` as planned; by default, than the mission's.

        Raises:
            LimitError: no battery lasts for the way there and back and some shots.
        """
        legs = self.tour
        ways = ways_of(self.mission, self.site, self.clearance_required_m)

        def flight_s(sortie: Sortie) -> float:
            whole = sortie.legs == legs
            return (
                self.trajectory if whole else route_of(self.site, sortie.legs, self.home_enu_m, ways)
            ).duration_s

        return plan_sorties(
            legs,
            self.shots_s,
            endurance_s=self.mission.vehicle.endurance_s if endurance_s is None else endurance_s,
            flight_s=flight_s,
            retime=self._retimed,
            begin_s=begin_s,
            end_s=end_s,
        )

    def sortie(self, begin_s: float, end_s: float) -> Sortie:
        """The stretch of the inspection from `begin_s` to `end_s` of its own time."""
        return stretch(self.tour, begin_s, end_s, self._retimed)

    def shot_orders(self, sortie: Sortie) -> ShotOrders:
        """What camera and gimbal are told on a sortie."""
        camera, asked = self.mission.camera, self.mission.inspection
        return ShotOrders(
            camera.trigger,
            camera_of(self.mission).shot_spacing_m(asked.standoff_m, asked.side_overlap),
            camera.gimbal,
            lambda route: shots_on(sortie, self.shots_s, route),
        )

    def pitch_on(self, sortie: Sortie, since_s: FloatArray) -> FloatArray:
        """The camera's planned pitch `since_s` after the inspection of a sortie began; level off it (NaN too)."""
        planned_s = sortie.inspection_s(since_s)
        on_it = np.isfinite(planned_s)
        pitch_rad = np.zeros(len(planned_s))
        pitch_rad[on_it] = self.trajectory(
            planned_s[on_it] + self.trajectory.span_s("inspection")[0]
        ).gimbal_pitch_rad
        return pitch_rad

    def _retimed(self, leg: Leg) -> TimeLaw:
        """The law of a cut leg."""
        for whole in self.passes:
            if whole.leg.name == leg.name:
                return retimed(leg, whole)
        return fastest_law(leg.path, leg.gaze, limits_of(self.mission))

    def flown_by(self, autopilot: Literal["px4", "ardupilot"]) -> Inspection:
        """The same inspection for a vehicle of that autopilot."""
        vehicle = self.mission.vehicle.model_copy(update={"autopilot": autopilot})
        return replace(self, mission=self.mission.model_copy(update={"vehicle": vehicle}))

    def flown_shots(
        self,
        route: Trajectory,
        path_t_s: FloatArray,
        position_enu_m: FloatArray,
        yaw_enu_rad: FloatArray,
        sortie: Sortie | None = None,
    ) -> Shots:
        """The planned shots from where a vehicle was when it came to them.

        `route` is what was flown, of `sortie` if not the whole inspection. Its rows are poses at path times on it, NaN
        off it. Its way to the spiral begins where the vehicle stood, so that the spiral has other path times than planned.
        """
        since_s = path_t_s - route.span_s("inspection")[0]
        if sortie is not None:
            since_s = sortie.inspection_s(since_s)
        planned_s = since_s + self.trajectory.span_s("inspection")[0]
        return flown_shots(self.shots, planned_s, position_enu_m, yaw_enu_rad)

    def coverage_from(self, shots: Shots) -> Coverage:
        """What other shots than the planned ones show of the building."""
        return measure_coverage(
            self.coverage.patches, shots, self.site, camera_of(self.mission), self.coverage.demand
        )

    def way_home(self, start_enu_m: FloatArray, end_enu_m: FloatArray, yaw_enu_rad: float) -> Trajectory:
        """The way from anywhere to anywhere that keeps the clearance, or what of it there is at the start.

        Raises:
            LimitError: there is no such way below the ceiling, or it is there already.
        """
        ways = ways_of(self.mission, self.site, self.clearance_required_m)
        spare_m = float(ways.solids.distance_m(start_enu_m[None, :])[0]) - MARGIN_M - 0.1
        ways = replace(ways, clearance_m=min(self.clearance_required_m, spare_m))
        look = Look(yaw_enu_rad)
        legs = ways.legs(start_enu_m, end_enu_m, "home", (look, look))
        if not legs:
            raise LimitError("it is above home already")
        return Trajectory(legs)

    @property
    def safe_height_enu_m(self) -> float:
        """The height above which nothing stands in a straight way home."""
        return self.site.heights.top_m + self.clearance_required_m

    def summary(self) -> dict[str, Any]:
        """The figures of `plan --json`; what is not worked out yet is None."""
        figures = self.certificate
        return {
            "name": self.mission.name,
            "rings": sum(part.rings for part in self.passes),
            "parts": len(self.passes),
            "harmonics": [part.harmonics for part in self.passes],
            "length_m": round(sum(part.length_m for part in self.passes), 2),
            "duration_s": round(self.trajectory.duration_s, 2),
            "speed_max_mps": round(figures["speed"].worst, 4),
            "acceleration_max_mps2": round(figures["acceleration"].worst, 4),
            "jerk_max_mps3": round(figures["jerk"].worst, 4),
            "yaw_rate_max_dps": round(math.degrees(figures["yaw rate"].worst), 4),
            "blur_max_px": round(figures["blur"].worst, 3),
            "clearance_min_m": round(figures["clearance"].worst, 3),
            "clearance_required_m": round(self.clearance_required_m, 3),
            "clearance_budget": budget_of(self.mission).summary(self.mission.limits.clearance_m),
            "photos": len(self.shots),
            "sorties": len(self.sorties()),
            "coverage": self.coverage.summary(),
            "planning_ms": {stage: round(ms, 2) for stage, ms in self.planning_ms.items()},
            "failsafe": None,
            "warnings": list(self.warnings),
        }


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
    found = pieces_of(mission, site, camera, pace, home, required_m, ways.solids)
    watch.lap("curve")

    passes = flown_in_order(found.pieces, sharpness_of(mission, camera))
    watch.lap("timing")

    tour = tour_of(passes, ways)
    trajectory = route_of(site, tour, home, ways)
    watch.lap("transits")

    with ThreadPoolExecutor(max_workers=1) as beside:  # both are kernels that run without the interpreter
        measuring = beside.submit(
            measure_clearance,
            trajectory.sampled(CLEARANCE_GRID_S),
            site,
            reaction_s=REACTION_S,
            braking_mps2=limits.acceleration_mps2,
        )
        states = trajectory.sampled(GRID_S)
        clearance = measuring.result()
    certificate = _certificate(mission, trajectory, states, clearance, limits, required_m)
    watch.lap("certificate")
    if not certificate.ok:
        raise LimitError(
            f"{mission.name}: the plan fails its limits: {'; '.join(_failures(mission, site, trajectory, certificate))}. "
            "Fix: another standoff_m, or another band (bottom_m, top_m) away from it"
        )

    shots = shots_of(
        trajectory,
        camera,
        standoffs_m=[part.standoff_m for part in passes],
        side_overlap=mission.inspection.side_overlap,
    )
    coverage = measure_coverage(patches_of(site), shots, site, camera, demand_of(mission))
    if coverage.walls == 0.0:
        raise LimitError(
            f"{mission.name}: no wall is seen within [quality] gsd_max_mm = {mission.quality.gsd_max_mm:g} and incidence_max_deg = "
            f"{mission.quality.incidence_max_deg:g}: a pixel is {1e3 * camera.gsd_m(mission.inspection.standoff_m):.1f} mm at standoff_m = "
            f"{mission.inspection.standoff_m:g}. Fix: a smaller standoff_m, a longer lens, or a larger gsd_max_mm"
        )
    unseen = unseen_lines(
        coverage,
        shots,
        site,
        camera,
        narrow_m=2 * (mission.inspection.standoff_m + pace.speed_mps**2 / pace.acceleration_mps2),
        roofs=mission.inspection.roof,
    )
    watch.lap("coverage")
    inspection = Inspection(
        mission,
        site,
        passes,
        tour,
        home,
        trajectory,
        clearance,
        required_m,
        certificate,
        shots,
        coverage,
        (*mission.notices, *site_map.warnings, *found.told, *unseen),
        watch.laps_ms,
    )
    inspection.sorties()  # refuses what no battery can fly
    return inspection


def _certificate(
    mission: Mission,
    trajectory: Trajectory,
    states: TrajectoryState,
    clearance: Clearance,
    limits: Limits,
    required_m: float,
) -> Certificate:
    camera, allowed_px = camera_of(mission), mission.quality.blur_max_px
    blurs = [
        blur_figure(leg.sight, during(states, trajectory.span_s(leg.name)), camera, allowed_px)
        for leg in trajectory.legs
        if leg.sight is not None
    ]
    return Certificate(
        (
            *motion_figures(states, limits),
            max(blurs, key=lambda figure: figure.worst),
            *clearance_figures(clearance, required_m=required_m, vehicle_radius_m=mission.vehicle.radius_m),
            ceiling_figure(states, mission.limits.ceiling_m),
        )
    )


def _failures(
    mission: Mission, site: Site, trajectory: Trajectory, certificate: Certificate
) -> tuple[str, ...]:
    """Each limit that does not hold: value, limit, moment, place on earth, and what is too near."""
    told = []
    for figure in certificate.figures:
        if figure.ok:
            continue
        place = site.heights.frame.geo_point(np.array(figure.at_enu_m))
        line = f"{figure} (lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f})"
        if figure.at_least:
            states = trajectory.sampled(CLEARANCE_GRID_S)
            row = int(np.argmin(np.abs(states.t_s - figure.at_t_s)))
            if figure.name == STRAIGHT_ON:
                sweep_m = run_on_m(states.velocity_enu_mps[row], REACTION_S, mission.limits.acceleration_mps2)
            else:
                after = states.position_enu_m[min(row + 1, len(states.t_s) - 1)]
                sweep_m = after - states.position_enu_m[row]
            line += f", from {nearest_obstacle(mission, site, states.position_enu_m[row], sweep_m)}"
        told.append(line)
    return tuple(told)


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
