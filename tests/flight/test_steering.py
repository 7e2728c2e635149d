"""The kernels of a step equal plain Python, and are there before the flight needs them."""

from __future__ import annotations

import math

from fake_flight import fly, make_session
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.flight.governor import GovernorLimits
from mavspiral.flight.messages import Target
from mavspiral.flight.outcome import State
from mavspiral.flight.reference import Reference
from mavspiral.flight.steering import paced, setpoint_at, steered, wanted_rate

LIMITS = GovernorLimits()
STILL = (0.0, 0.0, 0.0)
MOVE = Reference.move(
    Target(STILL, STILL, STILL, 3.0, 0.0),
    Target((30.0, -20.0, -4.0), STILL, STILL, -2.0, 0.0),
    speed_mps=3.0,
    yaw_rate_radps=1.0,
)
lead_s, change_per_s = st.floats(0.0, 0.5), st.floats(-5.0, 5.0)


def slow_twin(
    pace, dt_s, error_m, speed_mps, lead_s, tilt_lead_s, turn_lead_s, gain, drag_per_s
) -> tuple[tuple[float, float, float], Target, Target]:
    """By the reference's own `at`: pace, what is due, what is sent."""
    t_s, before, change = pace
    if dt_s > 0.0:
        slow_m, stop_m = 0.4 * 1.5, 0.8 * 1.5
        wanted = min(1.0, max(0.0, (stop_m - error_m) / (stop_m - slow_m)))
        most = dt_s / max(speed_mps, 0.5)
        rate = max(wanted, before - 3.0 * most) if wanted < before else min(wanted, before + 1.0 * most)
        t_s, change = t_s + dt_s * (before + rate) / 2, (rate - before) / dt_s
    else:
        rate = before
    due, later, tilting, turning = (
        MOVE.at(t_s + rate * ahead_s, rate, change) for ahead_s in (0.0, lead_s, tilt_lead_s, turn_lead_s)
    )
    (a_north, a_east, a_down), (v_north, v_east, _) = (
        tilting.acceleration_ned_mps2,
        later.velocity_ned_mps,
    )
    sent = later._replace(
        acceleration_ned_mps2=(
            gain * a_north + drag_per_s * v_north,
            gain * a_east + drag_per_s * v_east,
            a_down,
        ),
        yaw_rate_ned_radps=turning.yaw_rate_ned_radps,
    )
    return (t_s, rate, change), due, sent


@given(
    st.tuples(st.floats(-1.0, 60.0), st.floats(0.0, 1.0), change_per_s),
    st.floats(-0.1, 0.3),
    st.floats(0.0, 3.0) | st.just(math.inf),
    st.floats(0.0, 8.0),
    st.tuples(lead_s, lead_s, lead_s),
    st.floats(1.0, 1.5),
    st.floats(0.0, 0.3),
)
@settings(max_examples=300, deadline=None)
def test_a_step_is_bit_for_bit_what_plain_python_makes_of_it(
    pace, dt_s, error_m, speed_mps, leads_s, gain, drag_per_s
):
    ways = LIMITS.slow_m, LIMITS.stop_m, speed_mps, LIMITS.brake_mps2, LIMITS.recover_mps2
    numbers = steered(MOVE.coefficients, MOVE.knot_s, *pace, dt_s, error_m, *ways, *leads_s, gain, drag_per_s)
    after, due, sent = slow_twin(pace, dt_s, error_m, speed_mps, *leads_s, gain, drag_per_s)
    assert numbers[:3] == after
    assert Target.of(numbers[3:14]) == due
    assert Target.of(numbers[14:]) == sent


def test_compiled_and_plain_setpoints_are_equal():
    for k in range(-5, 400):
        args = MOVE.coefficients, MOVE.knot_s, 0.1 * k, 0.7, -0.3
        assert setpoint_at(*args) == setpoint_at.py_func(*args)


def test_nothing_compiles_once_it_is_armed(px4):
    """A kernel that is met with other types would compile for a second, and the stream would stand."""
    kernels, session, known = (paced, setpoint_at, steered, wanted_rate), make_session(), []

    def noted(frames):
        if session.state is State.ARM and not known:
            known.extend(len(kernel.signatures) for kernel in kernels)
        return frames

    fly(session, px4, down=noted)
    assert session.outcome.ok and known
    assert [len(kernel.signatures) for kernel in kernels] == known
