"""What a setpoint's acceleration makes up for, and how the drag is learned."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mavspiral.flight.feedforward import DRAG_MAX_PER_S, damped_gain, learned_drag


def test_the_share_that_is_taken_off_is_put_on_top_and_an_absurd_one_is_bounded():
    assert damped_gain(0.2) == 1.2
    assert damped_gain(0.0) == damped_gain(-3.0) == 1.0
    assert damped_gain(50.0) == 1.5


@pytest.mark.parametrize("true_drag", [0.0, 0.05, 0.15, 0.25])
def test_the_drag_is_found_from_the_lag_that_it_leaves(true_drag):
    """PX4's cascade lags by (d - k)·v / (P_pos·P_vel) = (d - k)·v / 1.7."""
    k = 0.1
    for _ in range(6000):
        k = learned_drag(k, (true_drag - k) * 5.0 / 1.7, 5.0, 0.02)
    assert k == pytest.approx(true_drag, abs=0.005)


@given(st.floats(0, DRAG_MAX_PER_S), st.floats(-50, 50), st.floats(0, 20), st.floats(-5, 5))
def test_it_stays_within_bounds_and_slow_flight_teaches_nothing(k, lag_m, speed_mps, dt_s):
    found = learned_drag(k, lag_m, speed_mps, dt_s)
    assert 0.0 <= found <= DRAG_MAX_PER_S
    if speed_mps < 1.0 or not 0.0 < dt_s < 1.0:
        assert found == k
