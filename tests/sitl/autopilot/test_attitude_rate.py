import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.autopilot.attitude import attitude_for, rates_for
from sitl.autopilot.rate import low_pass
from sitl.rotation import exponential, from_euler, multiply, normalized, rotate

angle = st.floats(-math.pi, math.pi)
tilt = st.floats(-0.7, 0.7)
few = settings(max_examples=80, deadline=None)
P = np.array([4.0, 4.0, 2.8])


@few
@given(st.tuples(tilt, tilt), st.floats(0.1, 1.0), angle)
def test_the_thrust_points_where_it_should_and_the_nose_where_yaw_says(lean, up, yaw):
    thrust = np.array([lean[0] * up, lean[1] * up, -up])
    q = attitude_for(thrust, yaw)
    np.testing.assert_allclose(rotate(q, (0.0, 0.0, -1.0)), thrust / np.linalg.norm(thrust), atol=1e-12)
    nose = rotate(q, (1.0, 0.0, 0.0))
    assert math.cos(math.atan2(nose[1], nose[0]) - yaw) > 1.0 - 1e-9  # body x has no part across the heading


@few
@given(angle, tilt, angle, angle, tilt, angle)
def test_following_the_rates_brings_the_attitude_there(r0, p0, y0, r1, p1, y1):
    q, wanted = from_euler(r0 / 3, p0, y0), from_euler(r1 / 3, p1, y1)
    for _ in range(3000):
        rates = rates_for(q, wanted, P, 0.4)
        q = normalized(multiply(q, exponential(tuple(0.01 * w for w in rates))))
    assert abs(np.dot(q, wanted)) > 1.0 - 1e-6


def test_a_pure_yaw_error_is_answered_with_px4s_yaw_gain():
    error = 0.01
    rates = rates_for((1.0, 0.0, 0.0, 0.0), from_euler(0.0, 0.0, error), P, 0.4)
    np.testing.assert_allclose(rates, (0.0, 0.0, 2.8 * error), atol=1e-6)


def test_tilt_goes_before_yaw():
    rates = rates_for((1.0, 0.0, 0.0, 0.0), from_euler(0.5, 0.0, 0.5), P, 0.4)
    assert math.hypot(rates[0], rates[1]) == pytest.approx(2.0 * 4.0 * math.sin(0.25), rel=0.05)
    assert 0.2 * 2.8 < rates[2] < 0.5 * 2.8


def test_the_gyro_filter_passes_slow_halves_the_power_at_its_corner_and_stops_fast():
    f = low_pass(200.0, 40.0)

    def gain(hz):
        z = np.exp(2j * np.pi * hz / 200.0)
        return abs((f.b0 + f.b1 / z + f.b2 / z**2) / (1.0 + f.a1 / z + f.a2 / z**2))

    assert gain(0.0) == pytest.approx(1.0)
    assert gain(40.0) == pytest.approx(0.5**0.5)
    assert gain(99.0) < 0.01
