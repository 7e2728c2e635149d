import numpy as np
import pytest

from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.slicing import MAX_LEVELS, solid_distance

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))


def random_blocks(rng, cell_m=0.5, levels=4):
    heights = np.zeros((30, 40))
    for _ in range(levels):
        r, c = rng.integers(0, 20), rng.integers(0, 30)
        heights[r : r + rng.integers(1, 10), c : c + rng.integers(1, 10)] = rng.uniform(1.0, 20.0)
    return Site(HeightMap(heights, cell_m, FRAME, np.array([3.0, -7.0])), heights > 0.0)


def brute_distance(site, points):
    """Distance of each point to every box, in so many words."""
    cell_m = site.heights.cell_m
    rows, cols = np.nonzero(site.building_height_m)
    low = site.heights.origin_enu_m + np.stack([cols, rows], axis=-1) * cell_m
    gap = np.maximum(0.0, np.maximum(low - points[:, None, :2], points[:, None, :2] - low - cell_m))
    rise = np.maximum(0.0, points[:, None, 2] - site.building_height_m[rows, cols])
    return np.sqrt((gap**2).sum(axis=-1) + rise**2).min(axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_distance_is_the_distance_to_the_boxes(seed):
    rng = np.random.default_rng(seed)
    site = random_blocks(rng)
    solid = solid_distance(site, reach_m=10.0)
    points = rng.uniform([-2.0, -12.0, 0.0], [28.0, 13.0, 30.0], (400, 3))
    points = points[brute_distance(site, points) > 1.0]
    rows, cols = solid.plan_m.shape[1:]
    low, high = solid.origin_enu_m, solid.origin_enu_m + np.array([cols - 1, rows - 1]) * 0.5
    points = points[((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)]
    shortfall = brute_distance(site, points) - solid(points)
    assert shortfall.min() > -0.001 * 0.5
    assert shortfall.max() < 0.5 / 3.0
    assert np.percentile(shortfall, 95) < 0.03


def test_plan_distances_are_exact_at_the_corners_of_cells():
    site = random_blocks(np.random.default_rng(7))
    solid = solid_distance(site, reach_m=6.0)
    rows, cols = solid.plan_m.shape[1:]
    x, y = np.meshgrid(np.arange(cols), np.arange(rows))
    nodes = solid.origin_enu_m + np.stack([x, y], axis=-1).reshape(-1, 2) * 0.5
    for level, plan in zip(solid.levels_m, solid.plan_m, strict=True):
        grounded = np.column_stack([nodes, np.full(len(nodes), 0.0)])
        tall = Site(site.heights, site.building_height_m >= level)
        np.testing.assert_allclose(plan.ravel(), brute_distance(tall, grounded), atol=1e-4)


@pytest.mark.parametrize("height_m", [0.0, 4.0, 9.5, 17.0, 23.0])
def test_a_slice_is_what_lies_within_the_distance(height_m):
    site = random_blocks(np.random.default_rng(3))
    solid = solid_distance(site, reach_m=9.0)
    field = solid.excess_m(solid.slice(height_m, 6.0))
    rows, cols = field.shape
    x, y = np.meshgrid(np.arange(cols), np.arange(rows))
    nodes = solid.origin_enu_m + np.stack([x, y], axis=-1).reshape(-1, 2) * 0.5
    truth = brute_distance(site, np.column_stack([nodes, np.full(len(nodes), height_m)])).reshape(rows, cols)
    clear = np.abs(truth - 6.0) > 1e-4
    np.testing.assert_array_equal((field <= 0.0)[clear], (truth <= 6.0)[clear])


def test_slices_between_roofs_are_equal_and_above_one_they_shrink():
    heights = np.zeros((20, 20))
    heights[5:15, 5:15], heights[8:12, 8:12] = 10.0, 30.0
    solid = solid_distance(Site(HeightMap(heights, 1.0, FRAME, np.zeros(2)), heights > 0), reach_m=9.0)
    assert solid.slice(2.0, 6.0) == solid.slice(10.0, 6.0)
    assert solid.slice(16.0, 6.0) == solid.slice(29.0, 6.0)
    radii = [solid.slice(h, 6.0).radii_m[0] for h in (10.0, 12.0, 14.0, 15.9)]
    assert radii == sorted(radii, reverse=True)
    assert solid.slice(15.9, 6.0, 3.0).radii_m[0] == 3.0
    assert solid.slice(40.0, 6.0).levels == ()


def test_many_roof_levels_are_rounded_up():
    heights = np.tile(np.linspace(5.0, 25.0, 120), (20, 1))
    site = Site(HeightMap(heights, 0.5, FRAME, np.zeros(2)), heights > 0)
    solid = solid_distance(site, reach_m=5.0)
    assert len(solid.levels_m) <= MAX_LEVELS
    points = np.random.default_rng(0).uniform([-4.0, -4.0, 2.0], [64.0, 14.0, 29.0], (500, 3))
    points = points[brute_distance(site, points) > 1.0]
    shortfall = brute_distance(site, points) - solid(points)
    assert shortfall.min() > -1e-4
    assert shortfall.max() < 25.0 / MAX_LEVELS + 0.1


def test_nothing_to_fly_around_is_said():
    site = Site(HeightMap(np.ones((3, 3)), 1.0, FRAME, np.zeros(2)), np.zeros((3, 3), bool))
    with pytest.raises(InputError, match="nothing to fly around"):
        solid_distance(site, reach_m=5.0)
