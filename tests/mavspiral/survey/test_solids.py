import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.survey.solids import Solids

CELL_M = 0.5
ORIGIN_M = np.array([-4.0, 3.0])


def slow_distance_m(heights, point):
    """Every box in turn; it goes on below the ground."""
    rows, cols = np.nonzero(heights > 0)
    low = np.column_stack([ORIGIN_M[0] + cols * CELL_M, ORIGIN_M[1] + rows * CELL_M, 0.0 * cols])
    high = low + np.column_stack([0.0 * cols + CELL_M, 0.0 * cols + CELL_M, heights[rows, cols]])
    low[:, 2] = -np.inf
    return np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0), axis=1).min(initial=np.inf)


def drawn_map(seed, shape, share):
    rng = np.random.default_rng(seed)
    heights = np.where(rng.uniform(size=shape) < share, rng.uniform(0.5, 9.0, shape), 0.0)
    points = np.column_stack([rng.uniform(-12, 12, 30), rng.uniform(-6, 20, 30), rng.uniform(-3, 14, 30)])
    return heights, points, rng.uniform(-6, 6, (30, 3))


maps = st.builds(
    drawn_map,
    st.integers(0, 2**32),
    st.tuples(st.integers(1, 23), st.integers(1, 23)),
    st.sampled_from([0.02, 0.1, 0.5, 1.0]),
)


@settings(max_examples=60, deadline=None)
@given(maps)
def test_distances_of_points_are_those_of_the_slow_way(drawn):
    heights, points, _ = drawn
    expected = [slow_distance_m(heights, point) for point in points]
    np.testing.assert_allclose(
        Solids.of(heights, CELL_M, ORIGIN_M).distance_m(points), expected, rtol=1e-12, atol=1e-12
    )


@settings(max_examples=25, deadline=None)
@given(maps)
def test_distances_of_straight_ways_are_the_least_along_them(drawn):
    heights, points, sweeps = drawn
    points, sweeps = points[:8], sweeps[:8]
    found = Solids.of(heights, CELL_M, ORIGIN_M).distance_m(points, sweeps)
    steps = np.linspace(0.0, 1.0, 301)
    for point, sweep, least in zip(points, sweeps, found, strict=True):
        sampled = min(slow_distance_m(heights, point + s * sweep) for s in steps)
        assert sampled - np.linalg.norm(sweep) / 600 - 1e-9 <= least <= sampled + 1e-9


@settings(max_examples=60, deadline=None)
@given(maps)
def test_the_least_is_the_least_of_the_distances(drawn):
    heights, points, sweeps = drawn
    solids = Solids.of(heights, CELL_M, ORIGIN_M)
    for ways in (sweeps, np.zeros_like(sweeps)):
        distance_m = solids.distance_m(points, ways)
        least_m, row = solids.least(points, ways)
        assert least_m == pytest.approx(distance_m.min(), rel=1e-14)
        assert distance_m[row] == pytest.approx(least_m, rel=1e-14)


def test_a_way_that_crosses_a_thin_wall_touches_it():
    heights = np.zeros((9, 9))
    heights[:, 4] = 5.0
    solids = Solids.of(heights, CELL_M, ORIGIN_M)
    from_west, over = np.array([[-10.0, 5.0, 2.0]]), np.array([[-10.0, 5.0, 6.5]])
    assert solids.distance_m(from_west, [[20.0, 0.0, 0.0]]) == pytest.approx(0.0, abs=1e-6)
    assert solids.distance_m(from_west, [[7.0, 0.0, 0.0]]) == pytest.approx(1.0)
    assert solids.distance_m(over, [[20.0, 0.0, 0.0]]) == pytest.approx(1.5)


def test_without_boxes_nothing_is_near():
    assert Solids.of(np.zeros((3, 4)), CELL_M, ORIGIN_M).distance_m([[0.0, 0.0, 1.0]]) == np.inf


def test_inside_a_box_the_distance_is_zero():
    solids = Solids.of([[3.0]], CELL_M, ORIGIN_M)
    np.testing.assert_array_equal(solids.distance_m([[-3.9, 3.1, 2.9], [-3.9, 3.1, 3.5]]), [0.0, 0.5])


def test_a_wall_goes_on_below_the_maps_ground():
    heights = np.zeros((4, 4))
    heights[1, 1] = 6.0
    solids = Solids.of(heights, 1.0, (0.0, 0.0))
    below = np.array([[5.0, 1.5, -40.0], [5.0, 1.5, 3.0]])
    np.testing.assert_allclose(solids.distance_m(below), [3.0, 3.0])


def test_clear_is_what_the_distance_says():
    rng = np.random.default_rng(12)
    heights = np.where(rng.uniform(size=(30, 40)) < 0.1, rng.uniform(1, 20, (30, 40)), 0.0)
    solids = Solids.of(heights, 0.5, (-10.0, -7.5))
    place, sweep = rng.uniform(-15, 25, (500, 3)), rng.uniform(-20, 20, (500, 3))
    distance_m = solids.distance_m(place, sweep)
    for least_m in (0.5, 3.0, 8.0):
        clear = solids.clear(place, sweep, least_m)
        assert 0 < clear.sum() < len(clear)
        np.testing.assert_array_equal(clear, distance_m >= least_m)
    assert Solids.of(np.zeros((4, 4)), 1.0, (0.0, 0.0)).clear(place, sweep, 100.0).all()


def test_the_way_that_is_nearest_is_named_wherever_it_stands_in_the_row():
    heights = np.zeros((9, 9))
    heights[4, 4] = 5.0
    solids = Solids.of(heights, CELL_M, ORIGIN_M)
    for nearest in range(40):
        away_m = 1.0 + np.abs(np.arange(40.0) - nearest)
        places = np.column_stack([away_m, np.full(40, 5.2), np.ones(40)])
        assert solids.least(places, np.zeros(3))[1] == nearest
