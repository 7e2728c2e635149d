"""Away from the walls first."""

import numpy as np
import pytest

from mavspiral.survey.solids import Solids
from mavspiral.tour.retreat import FARTHEST_M, retreat


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
