import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.autopilot.position import constrained
from sitl.autopilot.velocity import thrust_for
from sitl.geo import GRAVITY_MPS2

pair = st.tuples(st.floats(-20, 20), st.floats(-20, 20))
few = settings(max_examples=150, deadline=None)
HOVER, LEAST, MOST, MARGIN, TILT = 0.5, 0.12, 1.0, 0.3, math.radians(45.0)


@few
@given(pair, pair, st.floats(0.5, 15.0))
def test_the_first_velocity_has_the_right_of_way(first, second, limit):
    x, y = constrained(first, second, limit)
    assert math.hypot(x, y) <= limit * (1.0 + 1e-9)
    total = math.hypot(first[0] + second[0], first[1] + second[1])
    if total <= limit:
        assert (x, y) == (first[0] + second[0], first[1] + second[1])
    elif math.hypot(*first) < limit:
        left = x - first[0], y - first[1]  # what remains of the second: along it, shorter
        assert math.hypot(x, y) == pytest.approx(limit, rel=1e-6)
        assert abs(left[0] * second[1] - left[1] * second[0]) < 1e-5
        assert left[0] * second[0] + left[1] * second[1] >= -1e-6


def thrust(acceleration):
    given_, _ = thrust_for(np.array(acceleration), HOVER, LEAST, MOST, MARGIN, GRAVITY_MPS2 * math.tan(TILT))
    return np.array(given_)


def test_no_acceleration_is_hover_thrust_straight_up():
    np.testing.assert_allclose(thrust((0.0, 0.0, 0.0)), (0.0, 0.0, -HOVER), atol=1e-12)


def test_small_accelerations_are_made_exactly():
    np.testing.assert_allclose(
        thrust((1.0, -2.0, 0.0)) / HOVER * GRAVITY_MPS2, (1.0, -2.0, -GRAVITY_MPS2), atol=1e-12
    )


@few
@given(st.tuples(*[st.floats(-60.0, 60.0)] * 3))
def test_thrust_keeps_within_length_and_tilt_and_leaves_the_horizontal_its_margin(acceleration):
    t = thrust(acceleration)
    across, up = math.hypot(t[0], t[1]), -t[2]
    assert math.hypot(across, up) <= MOST + 1e-9
    assert math.hypot(across, up) >= LEAST - 1e-9
    assert across <= up * math.tan(TILT) + 1e-9
    if math.hypot(acceleration[0], acceleration[1]) > 5.0 and acceleration[2] < -30.0:
        assert across >= min(MARGIN, up * math.tan(TILT)) - 1e-9
