"""Away from the walls first."""

import numpy as np
import pytest

from mavspiral.survey.solids import Solids
from mavspiral.tour.retreat import FARTHEST_M, comes_down_aside, retreat


def tower(size=20, height_m=30.0):
    heights = np.zeros((60, 60))
    heights[20 : 20 + size, 20 : 20 + size] = height_m
    return Solids.of(heights, 1.0, (0.0, 0.0))


@pytest.mark.parametrize(
    ("place", "outward"), [((15, 30, 5), (-1, 0)), ((30, 45, 5), (0, 1)), ((44, 44, 5), (0.7, 0.7))]
)
def test_it_leads_straight_away_from_the_wall(place, outward):
    place = np.array(place, dtype=float)
    away = retreat(tower(), place) - place
    assert np.hypot(*away[:2]) == pytest.approx(FARTHEST_M) and away[2] == 0.0
    assert away[:2] @ outward / FARTHEST_M > 0.98


def test_between_two_walls_it_stops_in_the_middle_or_stays():
    heights = np.zeros((60, 60))
    heights[:, 20:25] = heights[:, 35:40] = 30.0
    lane = Solids.of(heights, 1.0, (0.0, 0.0))
    found = retreat(lane, np.array([28.0, 30.0, 5.0]))
    assert found[0] == pytest.approx(30.0, abs=0.5)
    assert (retreat(lane, np.array([30.0, 30.0, 5.0])) == [30.0, 30.0, 5.0]).all()


def test_above_a_roof_there_is_nowhere_better_beside():
    place = np.array([30.0, 30.0, 36.0])
    assert (retreat(tower(), place) == place).all()


def test_where_nothing_stands_it_stays():
    place = np.array([30.0, 30.0, 5.0])
    assert (retreat(Solids.of(np.zeros((4, 4)), 1.0, (0.0, 0.0)), place) == place).all()


def roofed():
    """A podium of 12 m, and a tower of 30 m on it."""
    heights = np.zeros((80, 80))
    heights[20:60, 20:60] = 12.0
    heights[34:46, 34:46] = 30.0
    return Solids.of(heights, 1.0, (0.0, 0.0))


@pytest.mark.parametrize("inside_m", [-1.5, 0.5, 3.0, 5.5])
def test_over_a_roofs_edge_it_leads_to_where_the_ground_is_below(inside_m):
    solids, place = roofed(), np.array([40.0, 60.0 - inside_m, 16.0])
    before_m = float(solids.distance_m(place[None, :])[0])
    found = retreat(solids, place)
    assert found[2] == 16.0 and found[0] == pytest.approx(40.0, abs=0.5)
    assert found[1] == pytest.approx(min(66.0, place[1] + 9.0), abs=0.5)
    down = np.array([0.0, 0.0, -16.0])
    assert solids.distance_m(found[None, :], down)[0] >= 3.0, "clear of the roof all the way down"
    assert solids.distance_m(place[None, :], found - place)[0] >= before_m - 0.05


def test_too_far_inside_a_roof_for_that_it_leads_away_from_the_tower():
    wide = np.full((120, 120), 12.0)
    wide[40:60, 40:60] = 40.0
    found = retreat(Solids.of(wide, 1.0, (0.0, 0.0)), np.array([50.0, 62.0, 20.0]))
    assert found == pytest.approx([50.0, 68.0, 20.0], abs=0.5)


@pytest.mark.parametrize(("inside_m", "aside"), [(-1.5, True), (3.0, True), (5.5, True), (7.0, False)])
def test_whether_it_comes_down_beside_a_roof_hangs_on_how_far_inside_it_is(inside_m, aside):
    assert comes_down_aside(roofed(), np.array([40.0, 60.0 - inside_m, 16.0])) is aside


def test_off_the_roof_never_leads_towards_a_neighbour():
    heights = np.zeros((80, 80))
    heights[20:60, 20:60] = 12.0
    heights[65:, :] = 30.0
    alley = Solids.of(heights, 1.0, (0.0, 0.0))
    place = np.array([40.0, 58.0, 16.0])
    assert (retreat(alley, place) == place).all(), "the alley is too narrow to come down in"
