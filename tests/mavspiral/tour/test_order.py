from itertools import pairwise, permutations

import numpy as np
import pytest

from mavspiral.motion.limits import Limits
from mavspiral.tour.order import quickest_order

LIMITS = Limits(4.0, 2.0, 1.0, 2.0, 4.0, 0.8, 1.0)
HOME = np.array([-30.0, -30.0, 0.0])


def time_s(order, entries, exits):
    """One way after the other, by hand."""
    places = [(HOME, HOME), *((entries[i], exits[i]) for i in order), (HOME, HOME)]
    total = 0.0
    for (_, start), (end, _) in pairwise(places):
        rise = end[2] - start[2]
        total += np.hypot(*(end - start)[:2]) / 4.0 + max(rise / 2.0, -rise / 1.0)
    return total


def scattered(count, seed):
    rng = np.random.default_rng(seed)
    entries = rng.uniform(0, 100, (count, 3))
    exits = entries + [0, 0, 1] * rng.uniform(0, 40, (count, 1))
    return entries, exits


@pytest.mark.parametrize("seed", range(5))
def test_few_places_are_visited_in_the_very_best_order(seed):
    entries, exits = scattered(5, seed)
    best = min(permutations(range(5)), key=lambda order: time_s(order, entries, exits))
    found = quickest_order(entries, exits, HOME, LIMITS)
    assert time_s(found, entries, exits) == pytest.approx(time_s(best, entries, exits))


def test_many_places_are_all_visited_in_an_order_that_no_turned_stretch_betters():
    entries, exits = scattered(14, 3)
    found = quickest_order(entries, exits, HOME, LIMITS)
    assert sorted(found) == list(range(14))
    taken_s = time_s(found, entries, exits)
    for i in range(14):
        for j in range(i + 2, 15):
            turned = found[:i] + found[i:j][::-1] + found[j:]
            assert time_s(turned, entries, exits) >= taken_s - 1e-6


def test_one_place_is_a_tour():
    assert quickest_order(*scattered(1, 0), HOME, LIMITS) == (0,)
