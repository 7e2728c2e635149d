from itertools import pairwise

import pytest

from sitl.autopilot.shaping import pursue
from sitl.clock import FRAME_S

MOST = 5.0, 2.5, 5.0
"""Speed, acceleration and jerk."""
REST = 0j, 0j, 0j, 0.0, 0.0, 0.0


def pursuit(goal, seconds, *, to_place=True, target=REST):
    """Target and goal of every frame."""
    moments = []
    for _ in range(round(seconds / FRAME_S)):
        target, goal = pursue(target, goal, to_place, MOST, MOST, MOST, FRAME_S)
        moments.append((target, goal))
    return moments


def test_the_goal_moves_on_by_itself():
    goal = 1 + 2j, 3 - 1j, 0.5j, -10.0, 1.0, 0.2
    _, moved = pursuit(goal, 2.0)[-1]
    assert moved[0] == pytest.approx(1 + 2j + 2.0 * (3 - 1j) + 0.5 * 4.0 * 0.5j)
    assert moved[1] == pytest.approx(3 - 1j + 2.0 * 0.5j)
    assert moved[3:] == pytest.approx((-10.0 + 2.0 + 0.4, 1.4, 0.2))


def test_the_target_comes_to_rest_at_a_place_within_its_limits():
    moments = [target for target, _ in pursuit((30 - 40j, 0j, 0j, -20.0, 0.0, 0.0), 30.0)]
    assert moments[-1][0] == pytest.approx(30 - 40j, abs=1e-2)
    assert moments[-1][3] == pytest.approx(-20.0, abs=1e-2)
    for (_, v, a, _, sink, push), (*_, a_next, _, _, push_next) in pairwise(moments):
        assert max(abs(v), abs(sink)) <= MOST[0] + 0.1
        assert max(abs(a_next - a), abs(push_next - push)) <= MOST[2] * FRAME_S * (1 + 1e-9)


def test_the_vertical_line_is_shaped_as_the_horizontal_plane():
    for to_place in (True, False):
        for target, _ in pursuit((12 + 0j, 1 + 0j, 0j, 12.0, 1.0, 0.0), 10.0, to_place=to_place):
            along = target[:3]
            assert [value.real for value in along] == pytest.approx(target[3:], rel=1e-12)
            assert all(value.imag == 0.0 for value in along)


def test_where_no_place_counts_the_target_takes_the_velocity():
    target, _ = pursuit((99 + 0j, 2 + 1j, 0j, 99.0, -0.5, 0.0), 10.0, to_place=False)[-1]
    assert target[1] == pytest.approx(2 + 1j, abs=1e-3)
    assert target[4] == pytest.approx(-0.5, abs=1e-3)


def test_a_way_down_has_the_limits_of_the_way_down():
    slow = 1.0, 2.5, 5.0
    for down_m, speed_mps in ((50.0, 1.0), (-50.0, 5.0)):
        target, goal, fastest = REST, (0j, 0j, 0j, down_m, 0.0, 0.0), 0.0
        for _ in range(800):
            target, goal = pursue(target, goal, True, MOST, MOST, slow, FRAME_S)
            fastest = max(fastest, abs(target[4]))
        assert fastest == pytest.approx(speed_mps, rel=0.02)
