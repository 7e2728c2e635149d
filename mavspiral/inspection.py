"""A plan as a value: the inspection, and what can be asked of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import budget_of, camera_of, limits_of
from mavspiral.errors import LimitError
from mavspiral.flight.shutter import ShotOrders
from mavspiral.mission import Mission
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.shape.heightmap import Site
from mavspiral.survey.certificate import Certificate
from mavspiral.survey.clearance import Clearance
from mavspiral.survey.coverage import Coverage, measure_coverage
from mavspiral.survey.shots import Shots, flown_shots
from mavspiral.tour.passes import Pass, retimed
from mavspiral.tour.retreat import retreat
from mavspiral.tour.route import route_of, ways_of
from mavspiral.tour.sorties import Sortie, digest_of, plan_sorties, shots_on, stretch
from mavspiral.tour.transit import JOINABLE_M, MARGIN_M, Look, transit_legs

__all__ = ["Inspection"]

SPARE_M = (6.0, 4.0, 2.0, 0.0)
"""How much more clearance a way home is tried with, one after the other."""


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
        return fastest_law(leg.path, leg.gaze, limits_of(self.mission), pitch=leg.gimbal_pitch)

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
            self.coverage.patches,
            shots,
            self.site,
            camera_of(self.mission),
            self.coverage.demand,
            self.coverage.best_pose,
        )

    def way_home(self, start_enu_m: FloatArray, end_enu_m: FloatArray, yaw_enu_rad: float) -> Trajectory:
        """The way from anywhere to anywhere: away from the walls first, then farther from everything than the plan must be.

        `SPARE_M` farther where that can be, because who is called home may not know where it is; no nearer than the required
        clearance, or than what of it there is at the start.

        Raises:
            LimitError: there is no such way below the ceiling, or it is there already.
        """
        ways = ways_of(self.mission, self.site, self.clearance_required_m)
        look, away_enu_m = Look(yaw_enu_rad), retreat(ways.solids, start_enu_m)
        leaving = transit_legs(
            np.array([start_enu_m, away_enu_m]),
            "leave",
            look,
            look,
            ways.limits,
            solids=ways.solids,
            radius_m=ways.radius_m,
        )
        spare_m = float(ways.solids.distance_m(away_enu_m[None, :])[0]) - MARGIN_M - JOINABLE_M
        wanted_m = [min(self.clearance_required_m + more_m, spare_m) for more_m in SPARE_M]
        for clearance_m in wanted_m:
            try:
                way = replace(ways, clearance_m=clearance_m).legs(away_enu_m, end_enu_m, "home", (look, look))
                break
            except LimitError:
                if clearance_m == wanted_m[-1]:
                    raise
        legs = (*leaving, *way)
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
