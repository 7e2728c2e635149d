import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site, box_of

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))


def small_map() -> HeightMap:
    return HeightMap(np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]), 0.5, FRAME, np.array([10.0, -20.0]))


def test_rows_go_north_and_columns_go_east():
    heights = small_map()
    assert heights.bounds_enu_m == (10.0, -20.0, 11.5, -19.0)
    assert heights.sample([11.2, -19.2]) == 5.0
    np.testing.assert_array_equal(heights.sample([[10.6, -19.9, 99.0], [10.1, -19.3, 99.0]]), [1.0, 3.0])


def test_nothing_stands_outside_the_map():
    np.testing.assert_array_equal(small_map().sample([[9.9, -19.9], [10.1, -18.9], [11.6, -19.9]]), 0.0)
    assert small_map().index([9.9, -20.1]).tolist() == [-1, -1]


def test_every_cell_holds_its_centre():
    heights = small_map()
    east, north = heights.centres_enu_m()
    x, y = np.meshgrid(east, north)
    np.testing.assert_array_equal(heights.sample(np.stack([x, y], axis=-1)), heights.height_agl_m)


def test_values_are_locked_and_copied():
    source = np.ones((2, 2))
    heights = HeightMap(source, 1.0, FRAME, np.zeros(2))
    source[0, 0] = 7.0
    assert heights.height_agl_m[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        heights.height_agl_m[0, 0] = 7.0
    with pytest.raises(ValueError, match="read-only"):
        Site(heights, np.ones((2, 2), bool)).building[0, 0] = False


@pytest.mark.parametrize("cell_m", [0.0, -1.0, np.nan, np.inf])
def test_a_cell_has_a_size(cell_m):
    with pytest.raises(ValueError, match="cell_m"):
        HeightMap(np.ones((2, 2)), cell_m, FRAME, np.zeros(2))


def test_a_hole_is_named():
    with pytest.raises(ValueError, match=r"\(1, 0\)"):
        HeightMap(np.array([[0.0, 1.0], [np.nan, 0.0]]), 1.0, FRAME, np.zeros(2))


def test_padding_moves_nothing():
    heights = small_map()
    site = Site(heights, heights.height_agl_m > 3.5)
    wide = site.padded(1.2)
    assert wide.heights.shape == (2 + 6, 3 + 6)
    points = np.random.default_rng(1).uniform([8.0, -22.0], [13.0, -17.0], (200, 2))
    np.testing.assert_array_equal(wide.heights.sample(points), heights.sample(points))
    assert wide.building.sum() == site.building.sum()
    own = np.where(wide.building, wide.heights.height_agl_m, 0.0)
    np.testing.assert_array_equal(wide.building_height_m, own)


def test_the_box_of_cells_holds_them_all_and_no_more():
    cells = np.zeros((7, 9), dtype=np.bool_)
    assert box_of(cells) == (slice(0, 0), slice(0, 0))
    cells[2, 3] = cells[5, 1] = True
    assert box_of(cells) == (slice(2, 6), slice(1, 4))
