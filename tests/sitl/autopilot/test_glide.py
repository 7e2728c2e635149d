"""Gliding setpoints: they arrive, they keep their limits, they do not overshoot."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.autopilot.glide import Glide, GlideLimits, step_glide, stopping_point
from sitl.autopilot.homecoming import return_height_m

LIMITS = GlideLimits(5.0, 3.0, 1.5, 3.0, 4.0, math.radians(60.0))
DT_S = 0.01


def resting(place=0j, down=0.0, yaw=0.0):
    return Glide(place, 0j, 0j, down, 0.0, 0.0, yaw, 0.0)


def glides(glide, place, down, yaw, seconds):
    for _ in range(round(seconds / DT_S)):
        glide = step_glide(glide, place, down, yaw, LIMITS, DT_S)
        yield glide


@given(
    st.complex_numbers(max_magnitude=80.0), st.floats(-40.0, 40.0), st.floats(-3.0, 3.0), st.floats(-7.0, 7.0)
)
@settings(max_examples=15, deadline=None)
def test_it_arrives_within_its_limits_and_does_not_overshoot(place, down, yaw, goal_yaw):
    before = resting(yaw=yaw)
    for glide in glides(before, place, down, goal_yaw, 50.0):
        assert abs(glide.velocity_mps) <= 5.0 * 1.01
        assert -3.0 * 1.01 <= glide.down_speed_mps <= 1.5 * 1.01
        assert abs(glide.acceleration_mps2) <= 3.0 + 1e-9
        assert abs(glide.acceleration_mps2 - before.acceleration_mps2) <= 4.0 * DT_S + 1e-9
        assert abs(glide.yaw_rate_ned_radps) <= LIMITS.yaw_rate_radps + 1e-9
        assert abs(glide.position_m) <= abs(place) + 0.02
        assert abs(glide.down_m) <= abs(down) + 0.02
        before = glide
    assert before.position_m == pytest.approx(place, abs=1e-3)
    assert before.down_m == pytest.approx(down, abs=1e-3)
    assert math.remainder(before.yaw_ned_rad - goal_yaw, math.tau) == pytest.approx(0.0, abs=1e-6)


@given(st.complex_numbers(max_magnitude=8.0), st.floats(-3.0, 3.0))
@settings(max_examples=15, deadline=None)
def test_it_stops_where_it_says(velocity, down_speed):
    start = Glide(0j, velocity, 0j, 0.0, down_speed, 0.0, 0.0, 0.0)
    place, down = stopping_point(start, LIMITS.acceleration_mps2)
    furthest = max(abs(glide.position_m) for glide in glides(start, place, down, 0.0, 20.0))
    assert furthest <= abs(place) + 0.1


PARAMS = {"RTL_RETURN_ALT": 30.0, "NAV_ACC_RAD": 2.0, "RTL_CONE_ANG": 45, "RTL_MIN_DIST": 10.0}


@pytest.mark.parametrize(
    ("distance_m", "height_m", "expected_m"),
    [
        (50.0, 5.0, 30.0),
        (50.0, 42.0, 42.0),
        (8.0, 3.0, 8.0),
        (3.0, 3.0, 4.0),
        (1.0, 0.5, 2.0),
        (1.0, 12.0, 12.0),
    ],
)
def test_the_way_home_is_high_far_out_and_low_near(distance_m, height_m, expected_m):
    assert return_height_m(distance_m, height_m, PARAMS) == pytest.approx(expected_m)


def test_without_a_cone_the_way_home_is_always_high():
    assert return_height_m(1.0, 0.5, {**PARAMS, "RTL_CONE_ANG": 0}) == 30.0
