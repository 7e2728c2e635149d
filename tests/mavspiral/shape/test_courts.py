import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.courts import court_ring, courts_of
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.slicing import solid_distance

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))
BLOCK = [(0, 0, 60, 50, 12.0), (0, 40, 60, 50, 16.0), (15, 10, 45, 40, 0.0)]


def solid_of(*boxes):
    heights = np.zeros((100, 120))
    for west, south, east, north, height in boxes:
        heights[int(2 * south) : int(2 * north), int(2 * west) : int(2 * east)] = height
    return solid_distance(Site(HeightMap(heights, 0.5, FRAME, np.zeros(2)), heights > 0), reach_m=20.0)


def test_a_court_has_a_middle_a_width_a_rim_and_a_highest_wall():
    (court,) = courts_of(solid_of(*BLOCK))
    np.testing.assert_allclose(court.place_enu_m, [30.0, 25.0], atol=0.5)
    assert court.half_width_m == pytest.approx(15.0)
    assert (court.floor_m, court.rim_m, court.wall_m) == (0.0, 12.0, 16.0)


def test_a_court_open_on_one_side_is_none():
    assert courts_of(solid_of(*BLOCK, (25, 0, 35, 10, 0.0))) == ()


@pytest.mark.parametrize(("width_m", "shut_m"), [(3, 2.0), (8, 5.0)])
def test_a_court_behind_a_gate_that_counts_as_shut_is_one(width_m, shut_m):
    gate = (30 - width_m / 2, 0, 30 + width_m / 2, 10, 0.0)
    solid = solid_of(*BLOCK, gate)
    assert courts_of(solid) == ()
    (court,) = courts_of(solid, shut_m=(shut_m,), room_m=1.5)
    np.testing.assert_allclose(court.place_enu_m, [30.0, 25.0], atol=2.0)
    assert court.half_width_m == pytest.approx(15.0, abs=0.5)
    assert (court.floor_m, court.rim_m, court.wall_m) == (0.0, 12.0, 16.0)
    assert courts_of(solid, shut_m=(0.4 * width_m,), room_m=1.5) == ()  # the gate is open
    assert courts_of(solid, shut_m=(shut_m,), room_m=14.0) == ()  # the court is too narrow


def test_a_court_over_a_hall_has_the_hall_for_its_floor():
    (court,) = courts_of(solid_of((0, 0, 60, 50, 30.0), (15, 10, 45, 40, 5.0)))
    assert (court.floor_m, court.rim_m) == (5.0, 30.0)


def test_a_hut_in_a_court_makes_no_second_one():
    (court,) = courts_of(solid_of(*BLOCK, (28, 23, 32, 27, 3.0)))
    assert court.floor_m == 0.0
    assert court.half_width_m == pytest.approx(0.5 * (np.hypot(15, 15) - np.hypot(2, 2)), rel=0.3)


def test_several_courts_come_widest_first_and_shafts_not_at_all():
    block = [(0, 0, 60, 50, 12.0), (5, 5, 15, 15, 0.0), (25, 10, 45, 30, 0.0), (50, 40, 51, 41, 0.0)]
    assert [court.half_width_m for court in courts_of(solid_of(*block))] == [10.0, 5.0]


def test_the_ring_inside_keeps_its_distance_and_leaves_the_walls_on_its_left():
    solid = solid_of(*BLOCK)
    (court,) = courts_of(solid)
    ring = court_ring(solid, court, height_m=4.0, standoff_m=9.0, corner_radius_m=3.0)
    points = ring.points_enu_m
    distance = solid(np.column_stack([points, np.full(len(points), 4.0)]))
    assert distance.min() > 8.95
    assert abs(np.median(distance) - 9.0) < 0.1
    x, y = points.T
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) < 0.0
    steps = np.diff(np.vstack([points, points[:2]]), axis=0)
    turn = np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0]))))
    assert np.abs(turn).max() < 1.5 * np.linalg.norm(steps, axis=1).mean() / 3.0
    assert court_ring(solid, court, height_m=4.0, standoff_m=15.5, corner_radius_m=3.0) is None
