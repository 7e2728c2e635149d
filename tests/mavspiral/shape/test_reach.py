import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.reach import arcs_of, reach_at
from mavspiral.shape.slicing import obstacle_distance, solid_distance

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))
SLAB = (50, 40, 90, 52, 24.0)


def reach(*neighbours, height_m=4.0):
    """Round a slab of 40 × 12 m at 7 m, with 4 m of clearance from neighbours of which 3.6 are required."""
    heights = np.zeros((200, 280))
    for west, south, east, north, height in (*neighbours, SLAB):
        heights[2 * south : 2 * north, 2 * west : 2 * east] = height
    building = np.zeros_like(heights, dtype=bool)
    building[80:104, 100:180] = True
    site = Site(HeightMap(heights, 0.5, FRAME, np.zeros(2)), building)
    solid = solid_distance(site, reach_m=18.0)
    others = obstacle_distance(site, solid)
    assert others is not None
    found = reach_at(
        solid,
        others,
        height_m=height_m,
        standoff_m=7.0,
        clearance_m=4.0,
        required_m=3.6,
        anchor_enu_m=np.array([70.0, 46.0]),
    )
    assert found is not None
    return found, solid, others


def test_far_neighbours_leave_the_whole_turn_at_the_stand_off():
    found, _, _ = reach((50, 64, 90, 70, 20.0))
    assert found.free and found.accessible.all()
    np.testing.assert_allclose(np.median(found.wall_m), 7.0, atol=0.05)
    assert [len(arc) for arc in arcs_of(found)] == [len(found.accessible)]


def test_before_a_neighbour_nearer_than_that_the_line_draws_in():
    found, _, others = reach((50, 61, 90, 70, 20.0))  # 9 m off the north side
    assert found.accessible.all() and not found.free
    north = (found.points_enu_m[:, 1] > 52) & (np.abs(found.points_enu_m[:, 0] - 70) < 12)
    np.testing.assert_allclose(found.wall_m[north], 5.0, atol=0.1)
    assert others(found.points_enu_m).min() >= 3.9


@pytest.mark.parametrize("gap_m", [0, 3, 6])
def test_a_gap_too_narrow_or_a_party_wall_leaves_an_arc_round_the_rest(gap_m):
    found, solid, others = reach((20, 35, 50 - gap_m, 57, 20.0))
    (arc,) = arcs_of(found)
    points = found.points_enu_m[arc]
    assert solid(points).min() >= 3.6 and others(points).min() >= 3.6
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 1.0
    assert points[:, 0].max() > 96.0  # round the east end
    for y in (33.0, 59.0):  # and along both long sides
        side = np.abs(points[:, 1] - y) < 0.2
        assert np.ptp(points[side, 0]) > 30.0
    assert not (np.abs(points[:, 1] - 46.0) < 5.0)[points[:, 0] < 60.0].any()


def test_a_house_between_party_walls_has_two_arcs_that_look_at_it():
    found, _, _ = reach((20, 40, 50, 52, 22.0), (90, 40, 120, 52, 26.0))
    arcs = arcs_of(found)
    assert len(arcs) == 2
    for arc in arcs:
        points, yaw = found.points_enu_m[arc], found.yaw_enu_rad[arc]
        middle = len(arc) // 2
        ahead = points[middle, :2] + 7.0 * np.array([np.cos(yaw[middle]), np.sin(yaw[middle])])
        assert 49.0 < ahead[0] < 91.0 and 39.5 < ahead[1] < 52.5


def test_above_a_neighbour_there_is_room():
    low, _, _ = reach((20, 35, 48, 57, 10.0), height_m=4.0)
    above, _, _ = reach((20, 35, 48, 57, 10.0), height_m=14.2)
    assert not low.accessible.all()
    assert above.accessible.all() and above.free
