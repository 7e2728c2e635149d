"""Which stretches are flown again: those round the shots that nobody has, joined where home is farther."""

from __future__ import annotations

import numpy as np
import pytest

from mavspiral.tour.missed import stretches_left
from mavspiral.tour.sorties import OVERLAP_SHOTS_N

SHOTS_S = np.arange(101.0)


def left(*missed, ways_s=5.0):
    had = np.ones(len(SHOTS_S), dtype=bool)
    for first, last in missed:
        had[first : last + 1] = False
    return stretches_left(had, SHOTS_S, end_s=100.0, ways_s=ways_s)


def test_nothing_is_left_when_all_were_taken():
    assert left() == ()


def test_all_is_left_when_none_was():
    assert left((0, 100)) == ((0.0, 100.0),)


def test_the_rest_begins_some_shots_before():
    assert left((50, 100)) == ((49.0 - OVERLAP_SHOTS_N, 100.0),)
    assert left((2, 100)) == ((0.0, 100.0),)


def test_a_gap_is_flown_with_an_overlap_on_both_sides():
    assert left((40, 49)) == ((39.0 - OVERLAP_SHOTS_N, 50.0 + OVERLAP_SHOTS_N),)
    assert left((96, 98)) == ((95.0 - OVERLAP_SHOTS_N, 100.0),)


@pytest.mark.parametrize(("ways_s", "count"), [(5.0, 2), (60.0, 1)])
def test_two_gaps_are_one_flight_where_home_is_farther_than_the_next(ways_s, count):
    stretches = left((20, 22), (60, 100), ways_s=ways_s)
    assert len(stretches) == count
    assert stretches[0][0] == 19.0 - OVERLAP_SHOTS_N and stretches[-1][1] == 100.0
