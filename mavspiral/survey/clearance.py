"""How far a flight stays from everything solid, and how far it must."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.motion.trajectory import TrajectoryState
from mavspiral.survey.solids import Solids

__all__ = ["Clearance", "ClearanceBudget", "Nearest", "measure_clearance", "run_on_m"]


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


class Nearest(NamedTuple):
    """The least of distances along a flight: 0 inside a box, infinity where there is none."""

    distance_m: float
    at_t_s: float
    at_enu_m: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """How near a flight through these places, straight from each to the next, comes to anything solid.

    `straight_on` is how near anything comes if the vehicle no longer follows the curve: it goes straight on for the
    reaction time and then brakes to a stand.
    """

    t_s: FloatArray
    position_enu_m: FloatArray
    solids: Solids
    nearest: Nearest
    straight_on: Nearest

    def __post_init__(self) -> None:
        """Locks the places."""
        self.t_s.setflags(write=False)
        self.position_enu_m.setflags(write=False)

    @property
    def distance_m(self) -> FloatArray:
        """For each place the distance of the straight way on to the next; worked out anew at every call."""
        return self.solids.distance_m(self.position_enu_m, _onward_m(self.position_enu_m))


def measure_clearance(
    state: TrajectoryState, solids: Solids, *, reaction_s: float, braking_mps2: float
) -> Clearance:
    """The clearance of a sampled flight from everything that stands on its site.

    Each distance is that of the whole straight way to the next sample, so nothing slips between two.
    """
    place_enu_m = state.position_enu_m

    def nearest(ways_enu_m: FloatArray) -> Nearest:
        distance_m, k = solids.least(place_enu_m, ways_enu_m)
        east, north, up = place_enu_m[k].tolist()
        return Nearest(distance_m, float(state.t_s[k]), (east, north, up))

    run_on_enu_m = run_on_m(state.velocity_enu_mps, reaction_s, braking_mps2)
    return Clearance(state.t_s, place_enu_m, solids, nearest(_onward_m(place_enu_m)), nearest(run_on_enu_m))


def run_on_m(velocity_enu_mps: FloatArray, reaction_s: float, braking_mps2: float) -> FloatArray:
    """The way `(…, 3)` straight on at this velocity for the reaction time and then braking to a stand."""
    speed_mps = np.sqrt((velocity_enu_mps**2).sum(axis=-1, keepdims=True))
    return np.asarray(velocity_enu_mps * (reaction_s + speed_mps / (2 * braking_mps2)))


def _onward_m(place_enu_m: FloatArray) -> FloatArray:
    return np.diff(place_enu_m, axis=0, append=place_enu_m[-1:])
