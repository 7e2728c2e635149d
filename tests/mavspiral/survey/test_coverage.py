import math
import runpy
from pathlib import Path

import numpy as np
import pytest

from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.survey.coverage import Demand, measure_coverage
from mavspiral.survey.patches import patches_of
from mavspiral.survey.shots import Shots

looks = runpy.run_path(str(Path(__file__).with_name("slow_sight.py")))["looks"]
ANY = Demand(1.0, math.radians(89.9), 1)
HOUSE = [(20, 20, 40, 30, 10)]


def patch_at(patches, x, y, z):
    """The patch whose centre is nearest."""
    return int(np.argmin(np.linalg.norm(patches.centre_enu_m - (x, y, z), axis=1)))


def cover(trial, camera, shots, demand=ANY, building=HOUSE, obstacles=()):
    site = trial.site_of(building, obstacles)
    return measure_coverage(patches_of(site), shots, site, camera, demand)


def test_a_wall_straight_ahead_shows_its_rectangle_at_one_gsd(trial, camera):
    coverage = cover(trial, camera, trial.shots_at((30, 12, 5, 90, 0)))  # 8 m before the south wall
    seen = coverage.seen
    centres = coverage.patches.centre_enu_m[seen]
    assert (coverage.patches.side[seen] == 3).all()
    assert np.allclose(centres[:, 1], 20.0)
    # The picture is 12 m wide and 8 m high there: centres from 24.5 to 35.5 and from 1.5 to 8.5.
    assert centres[:, 0].min() == 24.5
    assert centres[:, 0].max() == 35.5
    assert centres[:, 2].min() == 1.5
    assert centres[:, 2].max() == 8.5
    assert seen.sum() == 12 * 8
    assert np.allclose(coverage.best_gsd_m[seen], 8 / 4000)
    at = patch_at(coverage.patches, 32.5, 20, 5.5)
    assert coverage.incidence_rad[at] == pytest.approx(math.atan(math.hypot(2.5, 0.5) / 8))
    assert coverage.walls == pytest.approx(96 / (2 * (20 + 10) * 10))
    assert coverage.roof == 0.0
    assert coverage.gsd_p95_m == pytest.approx(0.002)


def test_a_slanting_look_stretches_the_pixel_by_the_cosine_in_the_middle_of_the_picture(trial, camera):
    far = 8 * math.tan(math.radians(50))
    coverage = cover(trial, camera, trial.shots_at((30.5 - far, 12, 5.5, 40, 0)))
    at = patch_at(coverage.patches, 30.5, 20, 5.5)
    range_m = 8 / math.cos(math.radians(50))
    assert coverage.incidence_rad[at] == pytest.approx(math.radians(50))
    assert coverage.best_gsd_m[at] == pytest.approx(range_m / 4000 / math.cos(math.radians(50)))


def test_each_demand_counts(trial, camera):
    shots = trial.shots_at((30, 12, 5, 90, 0))
    assert cover(trial, camera, shots, Demand(0.00201, 1.5, 1)).seen.sum() == 96
    assert cover(trial, camera, shots, Demand(0.00199, 1.5, 1)).seen.sum() == 0
    assert cover(trial, camera, shots, Demand(1.0, 1.5, 2)).seen.sum() == 0
    steep = cover(trial, camera, shots, Demand(1.0, math.radians(20), 1))
    place = steep.patches.centre_enu_m
    assert (
        steep.seen
        == (
            (np.hypot(place[:, 0] - 30, place[:, 2] - 5) < 8 * math.tan(math.radians(20)))
            & (place[:, 1] == 20)
        )
    ).all()


def test_a_neighbour_hides_what_it_stands_before(trial, camera):
    """A wall 4 m before the camera, east of x = 30 and without end: east of 30 nothing is seen. A low one hides the foot."""
    shots = trial.shots_at((30, 10, 5, 90, 0))
    free = cover(trial, camera, shots)
    half = cover(trial, camera, shots, obstacles=[(30, 14, 60, 15, 30)])
    x = free.patches.centre_enu_m[:, 0]
    assert (half.seen == (free.seen & (x < 30))).all()
    # Its far upper edge is 2 m up at y = 15: from 5 m up at y = 10, what is below 5 − 3·2 = -1 m on the wall at 20 m.
    low = cover(trial, camera, shots, obstacles=[(0, 14, 64, 15, 2)])
    assert (low.seen == free.seen).all()
    # 4 m: the near edge at y = 14 hides below 5 − 1·10/4 = 2.5 m, the far one at 15 m below 5 − 1·10/5 = 3 m.
    low = cover(trial, camera, shots, obstacles=[(0, 14, 64, 15, 4)])
    assert (low.seen == (free.seen & (free.patches.centre_enu_m[:, 2] > 3.0))).all()


def test_a_roof_is_seen_from_above_only(trial, camera):
    level = trial.shots_at((30, 12, 14, 90, 0))
    down = trial.shots_at((30, 25, 18, 90, -90))
    assert cover(trial, camera, level, Demand(1.0, math.radians(60), 1)).roof == 0.0
    coverage = cover(trial, camera, down)
    # 8 m above it: 12 m across and 8 m along; the picture's up is north.
    assert coverage.roof == pytest.approx(12 * 8 / 200)
    assert np.allclose(coverage.best_gsd_m[coverage.seen], 0.002)


def test_sight_agrees_with_the_slow_road_on_random_sites(camera):
    rng = np.random.default_rng(7)
    total = 0
    for trial_n in range(6):
        heights = np.where(rng.random((12, 14)) < 0.35, rng.uniform(1, 9, (12, 14)), 0.0)
        building = (heights > 0) & (rng.random(heights.shape) < 0.7)
        origin = rng.uniform(-20, 20, 2)
        frame = Site(HeightMap(heights, 0.8, None, origin), building)
        patches = patches_of(frame)
        n = 12
        shots = Shots(
            np.arange(n),
            np.column_stack([rng.uniform(-8, 20, (n, 2)) + origin, rng.uniform(0.5, 14, n)]),
            rng.uniform(-4, 8, n),
            rng.uniform(-1.5, 0.7, n),
        )
        demand = Demand(rng.uniform(0.003, 0.006), math.radians(rng.uniform(50, 85)), 1)
        coverage = measure_coverage(patches, shots, frame, camera, demand)
        views, gsd, incidence = looks(patches, shots, frame, camera, demand)
        np.testing.assert_array_equal(coverage.views, views, err_msg=f"site {trial_n}")
        np.testing.assert_allclose(coverage.best_gsd_m, gsd, rtol=1e-6)
        np.testing.assert_allclose(coverage.incidence_rad, incidence, atol=1e-6)
        total += views.sum()
    assert total > 200


def test_a_wall_at_any_angle_to_the_grid_is_seen_alike(camera):
    """Square to a turned wall's middle: the same area, GSD and incidence as for one along the grid."""
    for turn_deg in (0, 3, 8, 20, 33, 45, 71):
        turn = math.radians(turn_deg)
        n, cell_m = 200, 0.25
        c = (np.arange(n) + 0.5) * cell_m - 25
        east, north = np.meshgrid(c, c)
        along, across = (
            east * math.cos(turn) + north * math.sin(turn),
            north * math.cos(turn) - east * math.sin(turn),
        )
        heights = np.where((abs(along) < 12) & (abs(across) < 6), 20.0, 0.0)
        site = Site(HeightMap(heights, cell_m, None, np.full(2, -25.0)), heights > 0)
        eye = np.array([math.sin(turn) * 14, -math.cos(turn) * 14, 10.0])  # 8 m before the long wall
        shots = Shots([0.0], eye[None], [turn + math.pi / 2], [0.0])
        coverage = measure_coverage(patches_of(site), shots, site, camera, Demand(0.003, math.radians(60), 1))
        seen = coverage.seen
        assert coverage.patches.area_m2[coverage.patches.is_wall].sum() == pytest.approx(72 * 20, rel=0.03), (
            turn_deg
        )
        assert coverage.patches.area_m2[seen].sum() == pytest.approx(12 * 8, rel=0.03), turn_deg
        assert coverage.gsd_p95_m == pytest.approx(0.002, rel=0.12), turn_deg
        middle = np.linalg.norm(coverage.patches.centre_enu_m[seen] - eye, axis=1) < 8.3
        assert np.degrees(coverage.incidence_rad[seen][middle]).max() < 25, turn_deg


def test_nothing_to_see_and_nobody_looking(trial, camera):
    nobody = cover(trial, camera, trial.shots_at())
    assert nobody.walls == 0.0
    figures = nobody.summary()
    assert {kind for kind, value in figures.items() if value is not None} == {"walls", "roof"}
    assert figures["walls"] == figures["roof"] == 0.0
    empty = cover(trial, camera, trial.shots_at((1, 1, 1, 0, 0)), building=[], obstacles=HOUSE)
    assert math.isnan(empty.walls)
    assert empty.summary()["walls"] is None
