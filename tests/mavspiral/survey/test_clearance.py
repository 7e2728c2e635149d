import dataclasses
import math

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.survey.clearance import ClearanceBudget, measure_clearance, run_on_m
from mavspiral.survey.solids import Solids

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)


@pytest.fixture
def solids():
    """A building 10 m high on x, y in [20, 30]; a mast of 30 m on the cell x in [0, 1], y in [40, 41]."""
    heights = np.zeros((64, 64))
    heights[20:30, 20:30] = 10.0
    heights[40, 0] = 30.0
    return Solids.of(heights, 1.0, (0.0, 0.0))


def fly(start, end):
    path, gaze = LinePath(start, end), TurnGaze(0.0, 0.0)
    return Trajectory((Leg("leg", path, gaze, fastest_law(path, gaze, LIMITS)),)).sampled(0.01)


def least_along(solids, place_enu_m, sweep_enu_m):
    """The slow way: everything's distance at 41 places of every straight way."""
    share = np.linspace(0.0, 1.0, 41)[:, None, None]
    return solids.distance_m((place_enu_m + share * sweep_enu_m).reshape(-1, 3)).min()


def test_each_sample_has_its_distance_to_building_and_obstacle(solids):
    clearance = measure_clearance(fly([0, 15, 5], [60, 15, 5]), solids, reaction_s=0.5, braking_mps2=2.0)
    x = clearance.position_enu_m[:, 0]
    onward = np.append(x[1:], x[-1])  # each sample's distance is that of the way to the next
    aside = np.maximum(np.maximum(20 - onward, x - 30), 0.0)
    expected = np.minimum(np.hypot(aside, 5.0), np.hypot(np.maximum(x - 1, 0), 25.0))
    np.testing.assert_allclose(clearance.distance_m, expected, atol=1e-9)


def test_over_a_roof_only_height_counts(solids):
    clearance = measure_clearance(fly([25, 22, 13], [25, 28, 13]), solids, reaction_s=0.5, braking_mps2=2.0)
    np.testing.assert_allclose(clearance.distance_m, 3.0, atol=1e-12)
    assert clearance.nearest.distance_m == pytest.approx(3.0)


def test_the_nearest_is_the_least_of_all_samples_and_their_ways(solids):
    for start, end in (
        ([0, 15, 5], [60, 15, 5]),
        ([-20, 45, 12], [35, 12, 31]),
        ([40, 40, 12], [-9, 42, 28]),
    ):
        state = fly(start, end)
        clearance = measure_clearance(state, solids, reaction_s=0.5, braking_mps2=2.0)
        place, near, ahead = state.position_enu_m, clearance.nearest, clearance.straight_on
        assert near.distance_m == pytest.approx(clearance.distance_m.min(), abs=1e-12)
        assert near.distance_m == pytest.approx(
            least_along(solids, place, np.diff(place, axis=0, append=place[-1:])), abs=1e-3
        )
        ways = run_on_m(state.velocity_enu_mps, 0.5, 2.0)
        assert ahead.distance_m <= least_along(solids, place, ways) + 1e-12
        assert ahead.distance_m == pytest.approx(least_along(solids, place, ways), abs=0.03)
        for nearest in (near, ahead):
            row = int(np.searchsorted(state.t_s, nearest.at_t_s))
            assert nearest.at_enu_m == tuple(place[row])


def test_straight_on_is_the_reaction_and_the_braking_way(solids):
    state = fly([-40, 25, 5], [10, 25, 5])  # at the west wall, stopping 10 m before it
    clearance = measure_clearance(state, solids, reaction_s=0.5, braking_mps2=2.0)
    speed = state.velocity_enu_mps[:, 0]
    ahead = 20.0 - (state.position_enu_m[:, 0] + 0.5 * speed + speed**2 / 4.0)
    worst = int(np.argmin(ahead))
    assert clearance.straight_on.distance_m == pytest.approx(ahead[worst], abs=1e-6)
    assert clearance.straight_on.at_t_s == pytest.approx(state.t_s[worst], abs=0.011)
    assert clearance.straight_on.distance_m < clearance.nearest.distance_m == pytest.approx(10.0)


def test_the_budget_shows_its_terms():
    budget = ClearanceBudget(
        vehicle_radius_m=0.4, map_sigma_m=0.5, navigation_sigma_m=0.3, tracking_sigma_m=0.1
    )
    assert budget.total_m == pytest.approx(0.4 + 3 * math.sqrt(0.25 + 0.09 + 0.01))
    assert budget.required_m(4.0) == 4.0
    assert budget.required_m(1.0) == budget.total_m
    with pytest.raises(ValueError, match="map_sigma_m is -1"):
        dataclasses.replace(budget, map_sigma_m=-1.0)
