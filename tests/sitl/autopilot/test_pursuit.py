import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.autopilot.pursuit import GOAL, LIMITS_N, PURSUIT_N, TARGET, TURN, angle_between, pursue_on, turn_on
from sitl.autopilot.shaping import pursue, shape_yaw
from sitl.clock import FRAME_S

LIMITS = np.array([5.0, 2.5, 5.0, 3.0, 2.0, 4.0, 1.5, 2.0, 4.0, 0.2, 2.0, 1.0, 0.25])
LEVEL, UP, DOWN, NOSE = map(tuple, LIMITS[:12].reshape(4, 3).tolist())
assert len(LIMITS) == LIMITS_N
MOVING = [3.0, -4.0, -20.0, 1.0, 2.0, 0.5, 0.1, -0.2, 0.3, 3.0, -0.4]
WANTED = [30.0, 40.0, -25.0, 2.0, 0.5, -0.2, 0.0, 0.4, -0.1, -9.0, 0.3]


def pursuit(*, left_rad=0.0, pace_radps=0.0):
    return np.array([*MOVING, *WANTED, left_rad, pace_radps])


def motion_of(setpoint):
    north, east, down, v_north, v_east, v_down, a_north, a_east, a_down, *_ = setpoint
    level = complex(north, east), complex(v_north, v_east), complex(a_north, a_east)
    return *level, down, v_down, a_down


def one_by_one(numbers, *, late=False, to_place=True, along=False):
    """The same frame by the laws one after another, and Python's own remainder."""
    target, goal = numbers[TARGET].tolist(), numbers[GOAL].tolist()
    left, pace = numbers[TURN].tolist()
    if late:
        goal[3:9], goal[10] = [0.0] * 6, 0.0
    moved, wanted = pursue(motion_of(target), motion_of(goal), to_place, LEVEL, UP, DOWN, FRAME_S)
    most = FRAME_S * min(pace or NOSE[2], NOSE[2])
    turn = min(max(left, -most), most)
    goal_yaw = goal[9] + goal[10] * FRAME_S + turn
    yaw, rate = goal_yaw, goal[10]
    if along:
        yaw, rate = target[9], 0.0
        if abs(moved[1]) > LIMITS[12]:
            yaw = math.atan2(moved[1].imag, moved[1].real)
            rate = (moved[1].conjugate() * moved[2]).imag / abs(moved[1]) ** 2
    nose_rate = shape_yaw(math.remainder(yaw - target[9], math.tau), rate, target[10], NOSE, FRAME_S)
    nose = math.remainder(target[9] + nose_rate * FRAME_S, math.tau)
    return (*moved, nose, nose_rate), (*wanted, goal_yaw, goal[10]), left - turn


@pytest.mark.parametrize("left_rad", [0.0, 1e-3, -2.0])
@pytest.mark.parametrize("pace_radps", [0.0, 0.5, 9.0])
@pytest.mark.parametrize("manner", [{}, {"late": True}, {"to_place": False}, {"along": True}])
def test_a_frame_is_the_laws_one_after_another(manner, left_rad, pace_radps):
    numbers = pursuit(left_rad=left_rad, pace_radps=pace_radps)
    flags = {"late": False, "to_place": True, "along": False, **manner}
    for _ in range(300):
        target, goal, left = one_by_one(numbers, **manner)
        pursue_on(numbers, LIMITS, flags["late"], flags["to_place"], flags["along"], FRAME_S)
        assert (*motion_of(numbers[TARGET]), *numbers[9:11]) == target
        assert (*motion_of(numbers[GOAL]), *numbers[20:22]) == goal
        assert numbers[TURN].tolist() == [left, pace_radps]


def test_in_a_take_off_the_nose_alone_turns_and_comes_to_the_goals_heading():
    numbers = pursuit(left_rad=1.0)
    numbers[21] = 0.0  # the goal does not turn by itself
    for _ in range(3000):
        turn_on(numbers, LIMITS, FRAME_S)
    assert numbers[:9].tolist() == MOVING[:9]
    assert numbers[11:20].tolist() == WANTED[:9]
    assert math.remainder(numbers[9] - (WANTED[9] + 1.0), math.tau) == pytest.approx(0.0, abs=1e-6)
    assert numbers[22] == 0.0
    assert len(numbers) == PURSUIT_N


@given(st.floats(-1e6, 1e6) | st.integers(-9, 9).map(lambda halves: halves * math.pi))
def test_angles_are_wrapped_as_python_does_it(angle):
    wrapped = angle_between(angle, 0.0)
    assert (wrapped, math.copysign(1.0, wrapped)) == (
        math.remainder(angle, math.tau),
        math.copysign(1.0, math.remainder(angle, math.tau)),
    )
