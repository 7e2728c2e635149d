import math

import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.show.scene import AZIMUTH_DEG, Scene
from mavspiral.show.skin import UNSEEN_RGB, Skin, gsd_rgb
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import Demand, measure_coverage
from mavspiral.survey.patches import patches_of
from mavspiral.survey.shots import Shots


@pytest.fixture
def site():
    """A house on x in [10, 30], y in [10, 20], 10 m high, its tower [10, 14] × [10, 14] of 16 m; a wall north-east."""
    heights, building = np.zeros((40, 40)), np.zeros((40, 40), dtype=bool)
    heights[10:20, 10:30] = 10.0
    heights[10:14, 10:14] = 16.0
    building[10:20, 10:30] = True
    heights[30, 20:30] = 4.0
    return Site(HeightMap(heights, 1.0, LocalFrame(GeoPoint(19.4, -99.1, 0.0)), np.zeros(2)), building)


def test_each_point_of_the_picture_is_a_place_on_a_face_that_looks_at_the_eye(site):
    scene = Scene(site)
    west, east, low, high = scene.extent_m()
    rng = np.random.default_rng(1)
    picture = rng.uniform((west, low), (east, high), (4000, 2))
    place = scene.first_met(picture)
    met = np.isfinite(place[:, 0])
    assert 0.3 < met.mean() < 0.9
    np.testing.assert_allclose(scene._picture(place[met]), picture[met], atol=1e-6)
    cell, side = scene.faces_at(place[met])
    heights = site.heights.height_agl_m[cell[:, 0], cell[:, 1]]
    assert set(np.unique(side)) == {2, 3, 4}  # the eye is in the south-west
    np.testing.assert_allclose(place[met][side == 4, 2], heights[side == 4], atol=1e-6)
    np.testing.assert_allclose(place[met][side == 2, 0], cell[side == 2, 1], atol=1e-6)
    np.testing.assert_allclose(place[met][side == 3, 1], cell[side == 3, 0], atol=1e-6)
    assert (place[met][side < 4, 2] <= heights[side < 4]).all()
    # Nothing stands between the place and the eye.
    assert scene._visible(place[met] + 1e-3 * scene._eye_enu + [0, 0, 1e-6]).mean() > 0.99


def test_walls_take_the_colour_of_their_pixels_and_the_unseen_is_red(site):
    camera = Camera(0.010, (0.015, 0.010), (6000, 4000), 0.0005, 0.7, True)
    shots = Shots([0.0], [[20.0, 2.0, 5.0]], [math.pi / 2], [0.0])  # 8 m before the south wall
    demand = Demand(0.004, math.radians(60), 1)
    skin = Skin(site, measure_coverage(patches_of(site), shots, site, camera, demand), roofs=False)
    scene = Scene(site)
    seen, unseen, roof = skin._colours(
        np.array([[20.5, 10.0, 5.5], [10.0, 12.5, 5.5], [20.5, 15.5, 10.0]]), scene
    )

    def same_hue(a, b):
        return np.allclose(a / np.linalg.norm(a), b / np.linalg.norm(b), atol=1e-6)

    assert same_hue(seen, gsd_rgb(np.array(0.5)))
    assert same_hue(unseen, UNSEEN_RGB)
    assert not same_hue(roof, UNSEEN_RGB)
    roofs = Skin(site, skin.coverage, roofs=True)
    assert same_hue(roofs._colours(np.array([[20.5, 15.5, 10.0]]), scene)[0], UNSEEN_RGB)


def test_a_house_is_shown_from_where_most_of_its_walls_is_in_sight(site):
    def azimuth_deg(site):
        camera = Camera(0.010, (0.015, 0.010), (6000, 4000), 0.0005, 0.7, True)
        shots = Shots([0.0], [[20.0, 2.0, 5.0]], [math.pi / 2], [0.0])
        demand = Demand(0.004, math.radians(60), 1)
        coverage = measure_coverage(patches_of(site), shots, site, camera, demand)
        return Skin(site, coverage, roofs=False).azimuth_deg()

    assert azimuth_deg(site) == AZIMUTH_DEG  # free-standing: the usual side
    heights = site.heights.height_agl_m.copy()
    heights[:30, :9] = heights[2:5, :] = 30.0  # what stands west and south of it hides that
    hidden = Site(HeightMap(heights, 1.0, site.heights.frame, np.zeros(2)), site.building)
    assert azimuth_deg(hidden) in {0.0, 30.0, 60.0, 90.0}
