import numpy as np
import pytest

from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.survey.patches import SIDES_ENU, patches_of


def test_a_box_has_its_four_walls_and_its_roof(trial):
    patches = patches_of(trial.site_of([(20, 20, 40, 30, 10.4)]))
    for side, length_m in enumerate((10, 20, 10, 20)):
        here = patches.side == side
        assert patches.area_m2[here].sum() == pytest.approx(length_m * 10.4)
        assert (patches.normal_enu[here] == SIDES_ENU[side]).all()
        assert here.sum() == length_m * 11
    roof = ~patches.is_wall
    assert patches.area_m2[roof].sum() == 200
    assert (patches.centre_enu_m[roof, 2] == 10.4).all()
    assert (np.diff(patches.centre_enu_m[:, 2]) >= 0).all()
    # The last piece is clipped.
    assert np.unique(patches.height_m[patches.is_wall].round(9)).tolist() == [0.4, 1.0]
    assert (patches.centre_enu_m + 0.5 * patches.height_m[:, None] * [0, 0, 1])[
        patches.is_wall, 2
    ].max() == pytest.approx(10.4)


def test_a_party_wall_is_exposed_above_the_neighbour_only(trial):
    patches = patches_of(trial.site_of([(20, 20, 40, 30, 10)], [(40, 20, 50, 30, 7)]))
    east = patches.side == 0
    assert patches.area_m2[east].sum() == pytest.approx(10 * 3)
    assert (patches.centre_enu_m[east, 2] > 7).all()
    assert not (patches.centre_enu_m[:, 0] > 40).any()


def test_a_low_step_is_roof_and_no_wall(trial):
    patches = patches_of(trial.site_of([(20, 20, 40, 30, 10), (25, 22, 30, 28, 10.3)]))
    assert patches.centre_enu_m[patches.is_wall, 2].max() < 10


def test_sight_ends_outside_every_cell(trial):
    rng = np.random.default_rng(3)
    boxes = [
        (x, y, x + rng.integers(1, 9), y + rng.integers(1, 9), rng.uniform(2, 12))
        for x, y in rng.integers(2, 50, (25, 2))
    ]
    site = trial.site_of(boxes)
    patches = patches_of(site)
    assert (site.heights.sample(patches.before_enu_m) <= patches.before_enu_m[:, 2]).all()
    assert np.allclose(np.linalg.norm(patches.normal_enu, axis=1), 1.0)


def test_a_gables_roof_has_the_normals_and_the_area_of_its_slopes(trial):
    site = trial.site_of([(10, 20, 50, 40, 5)], cell_m=0.5)
    row = (np.arange(128) + 0.5) * 0.5
    heights = np.where(site.building, 5.0 + 0.75 * (10 - abs(row[:, None] - 30)), 0.0)
    patches = patches_of(Site(HeightMap(heights, 0.5, None, np.zeros(2)), site.building))
    roof = ~patches.is_wall
    assert patches.area_m2[roof].sum() == pytest.approx(40 * 20 * 1.25, rel=0.03)
    south = roof & (patches.centre_enu_m[:, 1] < 28)
    np.testing.assert_allclose(patches.normal_enu[south], [[0.0, -0.6, 0.8]] * south.sum(), atol=1e-9)


def test_a_low_parapet_tilts_a_flat_roof_but_little_and_only_beside_it(trial):
    patches = patches_of(trial.site_of([(10, 20, 50, 40, 5.4), (11, 21, 49, 39, 5)], cell_m=0.5))
    up = patches.normal_enu[~patches.is_wall, 2]
    assert up.min() > np.cos(np.radians(20))
    assert (up == 1.0).mean() > 0.6
    assert patches.area_m2[~patches.is_wall].sum() == pytest.approx(800, rel=0.01)
