"""What the planner knows before it has a curve, and what it has found to fly along."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from mavspiral.arrays import FloatArray
from mavspiral.brief import sharpness_of
from mavspiral.mission import Mission
from mavspiral.motion.limits import Limits
from mavspiral.shape.heightmap import Site
from mavspiral.shape.slicing import SolidDistance
from mavspiral.survey.camera import Camera
from mavspiral.survey.solids import Solids
from mavspiral.tour.passes import Piece
from mavspiral.tour.transit import JOINABLE_M, MARGIN_M, REACTION_S, STOPPING_MARGIN_M

__all__ = ["Candidate", "Setting"]


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """The mission on its site: `solid` is the building, `others` what stands near it, `everything` all of it."""

    mission: Mission
    site: Site
    camera: Camera
    pace: Limits
    required_m: float
    solid: SolidDistance
    others: SolidDistance | None
    everything: Solids

    @property
    def standoff_m(self) -> float:
        """The stand-off that the mission asks for."""
        return self.mission.inspection.standoff_m

    @property
    def corner_radius_m(self) -> float:
        """The sharpest corner at the full pace."""
        return self.pace.speed_mps**2 / self.pace.acceleration_mps2

    @property
    def joinable_m(self) -> float:
        """The clearance that a curve must have for a transit to join it."""
        return self.required_m + MARGIN_M + JOINABLE_M

    def run_on_m(self, speed_mps: float) -> float:
        """How far it goes straight on: the reaction time and the braking distance, v·t + v²/2a."""
        return speed_mps * (REACTION_S + speed_mps / (2.0 * self.pace.acceleration_mps2))

    def rise_m(self, standoff_m: float) -> float:
        """The most that a turn at this stand-off climbs."""
        return self.camera.rise_m(standoff_m, self.mission.inspection.overlap)

    def half_m(self, standoff_m: float) -> float:
        """How far above and below a camera at this stand-off a wall is in the picture."""
        return self.camera.footprint_m(standoff_m)[1] / 2

    def pace_at(self, standoff_m: float, ahead_m: float) -> Limits:
        """The limits for sharp pictures at this stand-off, and for coming to rest within `ahead_m`.

        Straight on for the reaction time and the braking distance: v·t + v²/2a.
        """
        braking = self.pace.acceleration_mps2
        sharp_mps = sharpness_of(self.mission, self.camera)(standoff_m)
        free_m = max(0.1, ahead_m - self.mission.vehicle.radius_m - STOPPING_MARGIN_M)
        stopping_mps = math.sqrt((braking * REACTION_S) ** 2 + 2.0 * braking * free_m) - braking * REACTION_S
        return replace(self.pace, speed_mps=min(self.pace.speed_mps, sharp_mps, stopping_mps))


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """Something to fly along, roughly from `entry_enu_m` to `exit_enu_m`.

    `planned(name, start_enu_m)` is its curve, begun near where the one before ends.
    """

    word: str
    entry_enu_m: FloatArray
    exit_enu_m: FloatArray
    planned: Callable[[str, FloatArray], Piece]
