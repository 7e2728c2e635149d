import pytest

from mavspiral.flight.follower import Follower
from mavspiral.flight.governor import GovernorLimits
from mavspiral.flight.messages import Target
from mavspiral.flight.reference import Reference

STILL = (0.0, 0.0, 0.0)
MOVE = Reference.move(
    Target(STILL, STILL, STILL, 0.0, 0.0),
    Target((30.0, 0.0, 0.0), STILL, STILL, 0.0, 0.0),
    speed_mps=3.0,
    yaw_rate_radps=1.0,
)


def follow(follower, begin_us, seconds, error_m=0.0, hold=False):
    for k in range(1, round(seconds * 50) + 1):
        now_us = begin_us + k * 20_000
        target = follower.advance(now_us, longest_s=0.1, hold=hold)
        north, east, down = follower.due[:3]
        follower.heard(now_us, (north, east + error_m, down))
    return Target.of(target)


def test_the_error_is_taken_against_the_reference_of_that_moment():
    follower = Follower(MOVE, GovernorLimits(), 0.0)
    follow(follower, 0, 8.0)
    then = MOVE.at(7.8)
    follower.heard(7.8e6, then.position_ned_m)
    assert follower.error_m == pytest.approx(0.0, abs=1e-6)
    follower.heard(8.0e6, then.position_ned_m)
    assert follower.error_m == pytest.approx(0.2 * then.velocity_ned_mps[0], rel=0.1)


def test_the_setpoint_leads_and_what_is_due_does_not():
    follower = Follower(MOVE, GovernorLimits(), 0.0, lead_s=0.1)
    target = follow(follower, 0, 6.0)
    assert target.position_ned_m == MOVE.at(follower.pace.path_t_s + 0.1).position_ned_m
    assert follower.due[:3] == MOVE.at(follower.pace.path_t_s).position_ned_m


def test_a_vehicle_clock_that_begins_anew_is_followed_without_a_leap():
    follower = Follower(MOVE, GovernorLimits(), 100e6)
    follow(follower, 100_000_000, 4.0)
    assert follower.pace.path_t_s == pytest.approx(4.0)
    follow(follower, 0, 1.0)
    assert follower.pace.path_t_s == pytest.approx(5.0, abs=0.021)


def test_an_error_as_large_as_the_reserve_stops_it_and_its_end_lets_it_go():
    limits = GovernorLimits(reserve_m=1.0)
    follower = Follower(MOVE, limits, 0.0)
    follow(follower, 0, 5.0)
    follow(follower, 5_000_000, 4.0, error_m=1.0)
    assert follower.pace.rate == 0.0
    stood_s = follower.pace.path_t_s
    target = follow(follower, 9_000_000, 1.0, error_m=1.0)
    assert follower.pace.path_t_s == stood_s and target.velocity_ned_mps == pytest.approx(STILL)
    follow(follower, 10_000_000, 30.0)
    assert follower.finished
