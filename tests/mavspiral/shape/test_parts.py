import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.parts import parts_of
from mavspiral.shape.slicing import solid_distance

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))
PODIUM_AND_TWO = [(0, 0, 80, 30, 8.0), (0, 0, 15, 15, 40.0), (60, 0, 80, 20, 30.0)]


def parts(*boxes, worth=lambda base_m, top_m: False):
    heights = np.zeros((60, 80))
    for west, south, east, north, height in boxes:
        heights[south:north, west:east] = height
    solid = solid_distance(Site(HeightMap(heights, 1.0, FRAME, np.zeros(2)), heights > 0), reach_m=12.0)
    return parts_of(solid, standoff_m=6.0, worth=worth)


def lone(*boxes):
    (part,) = parts(*boxes)
    return part


def test_a_single_block_leaves_nothing_out():
    found = lone((10, 10, 40, 40, 20.0))
    assert found.left_out == () and found.parent is None and not found.forks
    assert found.top_m == 20.0
    np.testing.assert_allclose(found.anchor_enu_m, [25.0, 25.0], atol=1.0)


def test_of_two_towers_not_worth_a_spiral_the_larger_is_followed_and_the_other_reported():
    found = lone(*PODIUM_AND_TWO)
    np.testing.assert_allclose(found.anchor_enu_m, [70.0, 10.0], atol=1.5)
    assert found.top_m == 30.0
    (other,) = found.left_out
    assert other.bounds_enu_m == (0.0, 0.0, 15.0, 15.0)
    assert (other.base_m, other.top_m) == (8.0, 40.0)


def test_two_towers_worth_it_stand_on_the_podium_that_ends_under_them():
    podium, first, second = parts(*PODIUM_AND_TWO, worth=lambda base_m, top_m: top_m - base_m > 20.0)
    assert (podium.base_m, podium.top_m, podium.forks, podium.parent) == (0.0, 8.0, True, None)
    tops = {(part.base_m, part.top_m, part.forks, part.parent) for part in (first, second)}
    assert tops == {(8.0, 30.0, False, 0), (8.0, 40.0, False, 0)}
    assert all(part.left_out == () for part in (podium, first, second))
    west = first if first.top_m == 40.0 else second
    np.testing.assert_allclose(west.anchor_enu_m, [7.5, 7.5], atol=1.0)


def test_the_one_that_is_worth_it_goes_on_even_when_it_is_the_smaller():
    found = parts(*PODIUM_AND_TWO, worth=lambda base_m, top_m: top_m > 35.0)
    assert [part.top_m for part in found] == [40.0]
    assert [piece.top_m for piece in found[0].left_out] == [30.0]


def test_separate_blocks_are_parts_of_the_same_rank_and_their_towers_stand_on_them():
    blocks = [(0, 0, 50, 20, 6.0), (0, 0, 10, 20, 20.0), (40, 0, 50, 20, 25.0), (70, 40, 80, 50, 12.0)]
    found = parts(*blocks, worth=lambda base_m, top_m: True)
    assert {(part.base_m, part.top_m, part.parent, part.forks) for part in found} == {
        *((0.0, 6.0, None, True), (0.0, 12.0, None, False)),
        *((6.0, 20.0, index, False) for index, part in enumerate(found) if part.forks),
        *((6.0, 25.0, index, False) for index, part in enumerate(found) if part.forks),
    }


def test_of_two_equal_towers_one_is_kept():
    found = lone((0, 0, 10, 10, 30.0), (60, 0, 70, 10, 30.0))
    (other,) = found.left_out
    assert (other.base_m, other.top_m) == (0.0, 30.0)
    kept_west = found.anchor_enu_m[0] < 10.0
    assert other.bounds_enu_m == ((60.0, 0.0, 70.0, 10.0) if kept_west else (0.0, 0.0, 10.0, 10.0))


def test_towers_closer_than_two_standoffs_are_one():
    found = parts((0, 0, 10, 10, 30.0), (20, 0, 30, 10, 30.0), worth=lambda base_m, top_m: True)
    assert len(found) == 1 and found[0].left_out == ()


@pytest.mark.parametrize("mast_m", [20.0, 60.0])
def test_the_top_is_the_highest_of_the_branch(mast_m):
    assert lone((10, 10, 40, 40, 15.0), (25, 25, 26, 26, mast_m)).top_m == mast_m
