"""How far a flight stays from everything solid, and how far it must."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.motion.trajectory import TrajectoryState
from mavspiral.shape.heightmap import Site
from mavspiral.survey.solids import Solids

__all__ = ["Clearance", "ClearanceBudget", "measure_clearance", "run_on_m"]


@dataclass(frozen=True, slots=True)
class ClearanceBudget:
    """What may go wrong between a curve and a wall: the vehicle's size and three 1-σ errors.

    Raises:
        ValueError: a term is negative or not finite.
    """

    vehicle_radius_m: float
    map_sigma_m: float
    navigation_sigma_m: float
    tracking_sigma_m: float

    def __post_init__(self) -> None:
        """Checks the fields."""
        for term in fields(self):
            value = getattr(self, term.name)
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{term.name} is {value}, wanted zero or more")

    @property
    def total_m(self) -> float:
        """Radius + 3·√(σ_map² + σ_navigation² + σ_tracking²)."""
        sigma_m = math.hypot(self.map_sigma_m, self.navigation_sigma_m, self.tracking_sigma_m)
        return self.vehicle_radius_m + 3 * sigma_m

    def summary(self, clearance_m: float) -> dict[str, float]:
        """The terms, their sum, what was asked for and what is required, as `--json` has them."""
        values = {term.name: getattr(self, term.name) for term in fields(self)}
        values |= {
            "total_m": self.total_m,
            "asked_m": clearance_m,
            "required_m": self.required_m(clearance_m),
        }
        return {name: round(value, 3) for name, value in values.items()}

    def required_m(self, clearance_m: float) -> float:
        """The clearance to demand where `clearance_m` was asked for: the larger of the two."""
        return max(clearance_m, self.total_m)


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """Distances along a flight to the nearest solid box: 0 inside one, infinity where there is none.

    `straight_on_m` is how near anything comes if the vehicle, from here, no longer follows the curve:
    it goes straight on for the reaction time and then brakes to a stand.
    """

    t_s: FloatArray
    position_enu_m: FloatArray
    building_m: FloatArray
    obstacle_m: FloatArray
    straight_on_m: FloatArray

    def __post_init__(self) -> None:
        """Locks the fields."""
        for column in fields(self):
            getattr(self, column.name).setflags(write=False)

    @property
    def distance_m(self) -> FloatArray:
        """Distance along the flight to the nearest of building and obstacles."""
        return np.minimum(self.building_m, self.obstacle_m)


def measure_clearance(
    state: TrajectoryState, site: Site, *, reaction_s: float, braking_mps2: float
) -> Clearance:
    """The clearance of a sampled flight from the building and the obstacles of `site`.

    Each distance is that of the whole straight way to the next sample, so nothing slips between two.
    """
    everything = Solids.of_map(site.heights)
    run_on_enu_m = run_on_m(state.velocity_enu_mps, reaction_s, braking_mps2)
    place_enu_m = state.position_enu_m
    onward_enu_m = np.diff(place_enu_m, axis=0, append=place_enu_m[-1:])
    building_m, obstacle_m = (
        np.full(len(place_enu_m), np.inf) if part is None else part.distance_m(place_enu_m, onward_enu_m)
        for part in _building_and_obstacles(everything, site)
    )
    return Clearance(
        t_s=state.t_s,
        position_enu_m=place_enu_m,
        building_m=building_m,
        obstacle_m=obstacle_m,
        straight_on_m=everything.distance_m(place_enu_m, run_on_enu_m),
    )


def run_on_m(velocity_enu_mps: FloatArray, reaction_s: float, braking_mps2: float) -> FloatArray:
    """The way `(…, 3)` straight on at this velocity for the reaction time and then braking to a stand."""
    speed_mps = np.linalg.norm(velocity_enu_mps, axis=-1, keepdims=True)
    return np.asarray(velocity_enu_mps * (reaction_s + speed_mps / (2 * braking_mps2)))


def _building_and_obstacles(everything: Solids, site: Site) -> tuple[Solids | None, Solids | None]:
    """The solids of the building, and all others; None where there are none."""
    col, row = np.rint((everything.origin_enu_m - site.heights.origin_enu_m) / everything.cell_m).astype(int)
    rows, cols = everything.height_agl_m.shape
    mask = site.building[row : row + rows, col : col + cols]
    both = (np.where(own, everything.height_agl_m, 0.0) for own in (mask, ~mask))
    building, others = (
        Solids.of(heights_m, everything.cell_m, everything.origin_enu_m) if heights_m.any() else None
        for heights_m in both
    )
    return (everything if others is None else building), others
