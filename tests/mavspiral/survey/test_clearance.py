import dataclasses
import math

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.survey.clearance import ClearanceBudget, measure_clearance

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)


@pytest.fixture
def site():
    """A building 10 m high on x, y in [20, 30]; a mast of 30 m on the cell x in [0, 1], y in [40, 41]."""
    heights, building = np.zeros((64, 64)), np.zeros((64, 64), dtype=bool)
    heights[20:30, 20:30] = 10.0
    building[20:30, 20:30] = True
    heights[40, 0] = 30.0
    frame = LocalFrame(GeoPoint(19.4, -99.1, 2240.0))
    return Site(HeightMap(heights, 1.0, frame, np.zeros(2)), building)


def fly(start, end):
    path, gaze = LinePath(start, end), TurnGaze(0.0, 0.0)
    return Trajectory((Leg("leg", path, gaze, fastest_law(path, gaze, LIMITS)),)).sampled(0.01)


def test_each_sample_has_its_distance_to_building_and_obstacle(site):
    clearance = measure_clearance(fly([0, 15, 5], [60, 15, 5]), site, reaction_s=0.5, braking_mps2=2.0)
    x = clearance.position_enu_m[:, 0]
    onward = np.append(x[1:], x[-1])  # each sample's distance is that of the way to the next
    aside = np.maximum(np.maximum(20 - onward, x - 30), 0.0)
    np.testing.assert_allclose(clearance.building_m, np.hypot(aside, 5.0), atol=1e-9)
    np.testing.assert_allclose(clearance.obstacle_m, np.hypot(np.maximum(x - 1, 0), 25.0), atol=1e-9)
    np.testing.assert_array_equal(
        clearance.distance_m, np.minimum(clearance.building_m, clearance.obstacle_m)
    )


def test_over_a_roof_only_height_counts(site):
    clearance = measure_clearance(fly([25, 22, 13], [25, 28, 13]), site, reaction_s=0.5, braking_mps2=2.0)
    np.testing.assert_allclose(clearance.building_m, 3.0, atol=1e-12)


def test_straight_on_is_the_reaction_and_the_braking_way(site):
    state = fly([-40, 25, 5], [10, 25, 5])  # at the west wall, stopping 10 m before it
    clearance = measure_clearance(state, site, reaction_s=0.5, braking_mps2=2.0)
    speed = state.velocity_enu_mps[:, 0]
    ahead = 20.0 - (state.position_enu_m[:, 0] + 0.5 * speed + speed**2 / 4.0)
    near = state.position_enu_m[:, 0] > 5.0  # nearer than the mast
    np.testing.assert_allclose(clearance.straight_on_m[near], np.maximum(ahead, 0.0)[near], atol=1e-6)
    assert clearance.straight_on_m.min() < clearance.distance_m.min() == pytest.approx(10.0)


def test_the_budget_shows_its_terms():
    budget = ClearanceBudget(
        vehicle_radius_m=0.4, map_sigma_m=0.5, navigation_sigma_m=0.3, tracking_sigma_m=0.1
    )
    assert budget.total_m == pytest.approx(0.4 + 3 * math.sqrt(0.25 + 0.09 + 0.01))
    assert budget.required_m(4.0) == 4.0
    assert budget.required_m(1.0) == budget.total_m
    with pytest.raises(ValueError, match="map_sigma_m is -1"):
        dataclasses.replace(budget, map_sigma_m=-1.0)
