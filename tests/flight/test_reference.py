import math

import numpy as np
import pytest
from fake_flight import PLAN_ORIGIN, VEHICLE_ORIGIN
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.flight.messages import Target
from mavspiral.flight.reference import BRAKE_MPS2, Reference, braking_s
from mavspiral.frames import GeoPoint, LocalFrame

STILL = (0.0, 0.0, 0.0)


@pytest.fixture
def to_vehicle():
    return LocalFrame(PLAN_ORIGIN).to_vehicle(GeoPoint(*VEHICLE_ORIGIN))


@pytest.fixture
def reference(trajectory, to_vehicle):
    return Reference.of(trajectory, to_vehicle)


def test_it_is_the_trajectory_turned_into_ned(reference, trajectory, to_vehicle):
    for t_s in np.random.default_rng(1).uniform(0, trajectory.duration_s, 300):
        state, target = trajectory(t_s), reference.at(t_s)
        e, n, u = to_vehicle.position_enu_m(target.position_ned_m)
        assert np.allclose((e, n, u), state.position_enu_m, atol=2e-6)
        for got, want, within in (
            (target.velocity_ned_mps, state.velocity_enu_mps, 1e-4),
            (target.acceleration_ned_mps2, state.acceleration_enu_mps2, 1e-2),
        ):
            assert got == pytest.approx((want[1], want[0], -want[2]), abs=within)
        assert math.cos(target.yaw_ned_rad) == pytest.approx(math.sin(state.yaw_enu_rad), abs=1e-6)
        assert math.sin(target.yaw_ned_rad) == pytest.approx(math.cos(state.yaw_enu_rad), abs=1e-6)
        assert target.yaw_rate_ned_radps == pytest.approx(-state.yaw_rate_enu_radps, abs=1e-5)


def test_knots_are_met_exactly(reference):
    for k in (0, 17, 1000, len(reference.values) - 1):
        target = reference.at(k * reference.knot_s)
        assert target.position_ned_m == pytest.approx(tuple(reference.values[k, :3]), abs=1e-9)
        assert target.velocity_ned_mps == pytest.approx(tuple(reference.rates[k, :3]), abs=1e-8)
        assert target.acceleration_ned_mps2 == pytest.approx(tuple(reference.accelerations[k, :3]), abs=1e-6)


@settings(max_examples=40, deadline=None)
@given(phase=st.floats(0.05, 0.95), rate=st.floats(0.0, 1.0), change=st.floats(-0.5, 0.5))
def test_velocity_and_acceleration_are_the_derivatives_of_what_is_commanded(phase, rate, change):
    """Central differences in the vehicle's time, in which path time runs at `rate` and speeds up."""
    begin = Target((0.0, 10.0, -5.0), STILL, STILL, 3.0, 0.0)
    end = Target((4.0, 2.0, -9.0), STILL, STILL, -2.5, 0.0)
    move = Reference.move(begin, end, speed_mps=2.0, yaw_rate_radps=0.4)
    h, t = 1e-4, phase * move.duration_s

    def at(dt):
        return move.at(t + rate * dt + change * dt**2 / 2, rate + change * dt, change)

    before, now, after = at(-h), at(0.0), at(h)
    velocity = (np.array(after.position_ned_m) - before.position_ned_m) / (2 * h)
    acceleration = (np.array(after.velocity_ned_mps) - before.velocity_ned_mps) / (2 * h)
    assert now.velocity_ned_mps == pytest.approx(velocity, abs=1e-5)
    assert now.acceleration_ned_mps2 == pytest.approx(acceleration, abs=1e-5)
    turned = (after.yaw_ned_rad - before.yaw_ned_rad + math.pi) % (2 * math.pi) - math.pi
    assert now.yaw_rate_ned_radps == pytest.approx(turned / (2 * h), abs=1e-5)


def test_it_rests_beyond_its_ends(reference):
    for t_s in (-1.0, 0.0, reference.duration_s, reference.duration_s + 9.0):
        target = reference.at(t_s)
        assert target.velocity_ned_mps == pytest.approx(STILL, abs=1e-6)
        end = reference.values[0 if t_s <= 0 else -1]
        assert target.position_ned_m == pytest.approx(tuple(end[:3]), abs=1e-9)


def test_yaw_on_the_wire_is_wrapped(reference):
    yaws = [reference.at(t).yaw_ned_rad for t in np.linspace(0, reference.duration_s, 500)]
    assert -math.pi <= min(yaws) < -3 and 3 < max(yaws) < math.pi
    assert reference.values[:, 3].min() < -2 * math.pi, "the helix turns twice"


def test_a_move_takes_the_short_way_round_within_its_speeds():
    begin = Target((0.0, 0.0, -20.0), STILL, STILL, 3.0, 0.0)
    end = Target((1.0, -2.0, -21.0), STILL, STILL, -3.0, 0.0)
    move = Reference.move(begin, end, speed_mps=0.5, yaw_rate_radps=0.2)
    targets = [move.at(t) for t in np.linspace(0, move.duration_s, 400)]
    assert targets[0].position_ned_m == pytest.approx(begin.position_ned_m)
    assert targets[-1].position_ned_m == pytest.approx(end.position_ned_m)
    assert targets[-1].yaw_ned_rad == pytest.approx(-3.0)
    assert max(math.hypot(*t.velocity_ned_mps) for t in targets) == pytest.approx(0.5, abs=1e-3)
    assert all(0 <= t.yaw_rate_ned_radps <= 0.2 + 1e-9 for t in targets)


def test_extremes_are_those_of_the_plan(reference, trajectory):
    v = trajectory(np.linspace(0, trajectory.duration_s, 20_000)).velocity_enu_mps
    worst = reference.extremes()
    assert worst.horizontal_mps == pytest.approx(np.hypot(v[:, 0], v[:, 1]).max(), rel=1e-4)
    assert worst.climb_mps == pytest.approx(v[:, 2].max(), rel=1e-4)
    assert worst.descent_mps == pytest.approx(-v[:, 2].min(), rel=1e-4)


def test_begun_in_flight_it_goes_on_at_that_speed_and_is_the_same_motion_once_that_is_gone(reference):
    velocity = np.array([3.0, -2.0, 1.0])
    begun, span_s = reference.begun_in_flight(tuple(velocity)), braking_s(tuple(velocity))
    t_s = np.linspace(0.0, span_s, 400)
    places = np.array([begun.at(t).position_ned_m for t in t_s])
    speeds = np.array([begun.at(t).velocity_ned_mps for t in t_s])
    beside = speeds - [reference.at(t).velocity_ned_mps for t in t_s]
    assert places[0] == pytest.approx(reference.values[0, :3] - velocity * span_s / 2, abs=1e-9)
    assert speeds[0] == pytest.approx(velocity, abs=1e-9)
    assert np.gradient(places, t_s, axis=0)[1:-1] == pytest.approx(speeds[1:-1], abs=2e-3)
    assert np.linalg.norm(np.gradient(beside, t_s, axis=0), axis=1).max() == pytest.approx(
        BRAKE_MPS2, rel=0.01
    )
    for t in (span_s, span_s + 3.0, reference.duration_s):
        assert begun.at(t).position_ned_m == pytest.approx(reference.at(t).position_ned_m, abs=1e-5)
        assert begun.at(t).velocity_ned_mps == pytest.approx(reference.at(t).velocity_ned_mps, abs=1e-4)


def test_begun_at_rest_it_is_the_motion_itself(reference):
    assert reference.begun_in_flight(STILL) is reference


def test_shifted_it_is_the_same_motion_elsewhere(reference):
    there = reference.shifted(2.0, -3.0, 1.0)
    for t_s in (0.0, 7.0, 50.0):
        was, now = reference.at(t_s), there.at(t_s)
        assert np.subtract(now.position_ned_m, was.position_ned_m) == pytest.approx(
            (2.0, -3.0, 1.0), abs=1e-9
        )
        assert now.velocity_ned_mps == pytest.approx(was.velocity_ned_mps)
        assert now[3:] == pytest.approx(was[3:])
