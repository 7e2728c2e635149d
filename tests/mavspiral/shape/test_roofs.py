import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.roofs import roof_grid, roofs_of

FRAME = LocalFrame(GeoPoint(48.0, 10.0, 400.0))


def site(heights, cell_m=0.25, building=None):
    heights = np.asarray(heights, dtype=float)
    return Site(
        HeightMap(heights, cell_m, FRAME, np.array([5.0, -3.0])),
        heights > 0 if building is None else building,
    )


def test_coarse_cells_hold_the_highest_and_lie_where_they_lay():
    heights = np.zeros((80, 120))
    heights[20:60, 30:90] = 6.0
    heights[41, 55] = 25.0  # an aerial, thinner than a coarse cell
    fine = site(heights)
    grid = roof_grid(fine, reach_m=8.0)
    assert grid.cell_m == 0.5
    assert grid.height_agl_m.max() == 25.0
    row, col = np.argwhere(grid.height_agl_m == 25.0)[0]
    corner = grid.origin_enu_m + np.array([col, row]) * 0.5
    aerial = fine.heights.origin_enu_m + np.array([55, 41]) * 0.25
    assert ((corner <= aerial) & (aerial < corner + 0.5)).all()
    assert grid.building.sum() * 0.25 == pytest.approx(10 * 15, rel=0.1)
    assert grid.height_agl_m[:14].max() == 0.0


def test_neighbours_stand_on_the_grid_and_are_no_roofs():
    heights = np.zeros((60, 60))
    heights[10:30, 10:30], heights[10:30, 40:50] = 6.0, 9.0
    grid = roof_grid(site(heights, 1.0, np.where(heights == 6.0, True, False)), reach_m=15.0)
    assert grid.height_agl_m.max() == 9.0
    (roof,) = roofs_of(grid, step_m=2.0, least_m2=4.0)
    assert (roof.high_m, roof.cells.sum()) == (6.0, 400)


def test_a_gable_is_one_roof_a_tower_another_and_a_chimney_none():
    row, col = np.mgrid[:60, :80]
    heights = np.where((abs(row - 30) < 14) & (col > 20) & (col < 70), 6.0 + 0.5 * (14 - abs(row - 30)), 0.0)
    heights[25:35, 10:21] = 30.0
    heights[30, 50] = 20.0
    tower, nave = roofs_of(roof_grid(site(heights, 0.5), reach_m=8.0), step_m=2.0, least_m2=4.0)
    assert (tower.high_m, nave.high_m) == (30.0, 13.0)
    assert nave.cells.sum() == 27 * 49 - 1


def test_signed_distance_is_to_the_edge_of_the_cells():
    grid = roof_grid(site(np.where(np.pad(np.ones((20, 30)), 20) > 0, 5.0, 0.0), 0.5), reach_m=6.0)
    distance_m = grid.distance_m(grid.building)
    assert distance_m[~grid.building].min() == pytest.approx(0.25)
    assert distance_m.min() == pytest.approx(-4.75)
    assert np.isinf(grid.distance_m(np.zeros_like(grid.building))).all()


def test_slopes_are_those_among_the_roofs_own_cells():
    row, col = np.mgrid[:40, :40]
    heights = np.where((abs(row - 20) < 10) & (abs(col - 20) < 12), 5.0 + 0.4 * col, 0.0)
    grid = roof_grid(site(heights, 0.5), reach_m=5.0)
    slope = grid.slope_enu(grid.building)
    assert slope[:, 0] == pytest.approx(0.8)
    assert slope[:, 1] == pytest.approx(0.0)
