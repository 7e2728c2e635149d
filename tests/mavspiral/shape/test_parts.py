import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.parts import main_part
from mavspiral.shape.slicing import solid_distance

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))


def part(*boxes):
    heights = np.zeros((60, 80))
    for west, south, east, north, height in boxes:
        heights[south:north, west:east] = height
    solid = solid_distance(Site(HeightMap(heights, 1.0, FRAME, np.zeros(2)), heights > 0), reach_m=12.0)
    return main_part(solid, standoff_m=6.0)


def test_a_single_block_leaves_nothing_out():
    found = part((10, 10, 40, 40, 20.0))
    assert found.left_out == ()
    assert found.top_m == 20.0
    np.testing.assert_allclose(found.anchor_enu_m, [25.0, 25.0], atol=1.0)


def test_of_two_towers_the_larger_is_kept_and_the_other_reported():
    found = part((0, 0, 80, 30, 8.0), (0, 0, 15, 15, 40.0), (60, 0, 80, 20, 30.0))
    np.testing.assert_allclose(found.anchor_enu_m, [70.0, 10.0], atol=1.5)
    assert found.top_m == 30.0
    (other,) = found.left_out
    assert other.bounds_enu_m == (0.0, 0.0, 15.0, 15.0)
    assert (other.base_m, other.top_m) == (8.0, 40.0)


def test_of_two_equal_towers_one_is_kept():
    found = part((0, 0, 10, 10, 30.0), (60, 0, 70, 10, 30.0))
    (other,) = found.left_out
    assert (other.base_m, other.top_m) == (0.0, 30.0)
    kept_west = found.anchor_enu_m[0] < 10.0
    assert other.bounds_enu_m == ((60.0, 0.0, 70.0, 10.0) if kept_west else (0.0, 0.0, 10.0, 10.0))


def test_towers_closer_than_two_standoffs_are_one():
    assert part((0, 0, 10, 10, 30.0), (20, 0, 30, 10, 30.0)).left_out == ()


@pytest.mark.parametrize("mast_m", [20.0, 60.0])
def test_the_top_is_the_highest_of_the_branch(mast_m):
    assert part((10, 10, 40, 40, 15.0), (25, 25, 26, 26, mast_m)).top_m == mast_m
