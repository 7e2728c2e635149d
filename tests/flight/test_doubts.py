"""Beside a wall a position that is not to be trusted ends the inspection."""

import math

import numpy as np
import pytest
from fake_flight import fly, leaving_first, make_session, split
from fake_px4 import OFFBOARD

from mavspiral.flight.doubts import Doubts
from mavspiral.flight.messages import GpsFix, LocalPosition
from mavspiral.flight.outcome import State


def until_path(session, t_s):
    return lambda: session.path_t_s > t_s


def fly_on(session, px4, each=None, until=None):
    now_us, received = px4.track[-1][0], b""
    while not session.outcome and not (until and until()):
        now_us += 20_000
        if each:
            each(now_us)
        received = b"".join(px4.step(now_us, split(session.step(now_us, received).send)))
        assert now_us < 600e6, session.events[-5:]


def telling(doubts, seconds, *, speed_mps=3.0, beside=lambda t_s: 0.0, hz=50, begin_s=0.0):
    """North at that speed, and what the estimate is beside it."""
    for k in range(round(seconds * hz)):
        t_s = begin_s + k / hz
        doubts.moved(
            LocalPosition(round(1000 * t_s), speed_mps * t_s + beside(t_s), 0.0, 0.0, speed_mps, 0.0, 0.0)
        )
        if (said := doubts.jumped()) is not None:
            return t_s, said
    return None


def test_what_its_speed_explains_is_no_doubt():
    assert telling(Doubts(1.5), 60) is None
    assert telling(Doubts(1.5), 60, beside=lambda t_s: 0.1 * t_s) is None, "1 m in 10 s is allowed"


def test_a_jump_is_told_at_once_and_once():
    doubts = Doubts(1.5)
    t_s, said = telling(doubts, 60, beside=lambda t_s: 5.0 * (t_s >= 20))
    assert t_s == 20.0 and "jumped by 5.0 m" in said
    assert doubts.jumped() is None


def test_a_creep_is_told_once_it_is_more_than_allowed():
    t_s, said = telling(Doubts(1.5), 60, beside=lambda t_s: 0.3 * max(0.0, t_s - 20))
    assert 25.0 <= t_s <= 25.6 and "otherwise than its speed says" in said


def test_with_rtk_half_of_it_is_too_much():
    for fix_type, doubted in ((3, False), (4, False), (5, True), (6, True)):
        doubts = Doubts(1.5)
        telling(doubts, 1.0)
        doubts.fixed(GpsFix(fix_type, 19.0, -99.0))
        assert (telling(doubts, 8, begin_s=1.0, beside=lambda t_s: 1.0 * (t_s > 2)) is not None) is doubted


def test_a_silence_is_no_jump():
    doubts = Doubts(1.5)
    assert telling(doubts, 10) is None
    assert telling(doubts, 10, begin_s=15.0, beside=lambda t_s: 4.0) is None


@pytest.mark.parametrize("loss", [2, 5, 10])
def test_lost_packets_on_a_circle_are_no_doubt(loss):
    doubts = Doubts(1.5)
    for k in range(0, 6000, loss):
        turn = 3.0 * k / 50 / 10.0
        place, speed = (10 * math.cos(turn), 10 * math.sin(turn)), (-3 * math.sin(turn), 3 * math.cos(turn))
        doubts.moved(LocalPosition(20 * k, *place, 0.0, *speed, 0.0))
        assert doubts.jumped() is None


def test_a_vehicle_that_never_had_a_fix_flies_by_something_else():
    doubts = Doubts(1.5)
    for k in range(20):
        telling(doubts, 0.5, begin_s=0.5 * k)
        doubts.fixed(GpsFix(0, 0.0, 0.0))
        assert doubts.fault is None


def test_fixes_that_stand_still_are_a_fault_only_while_it_moves():
    standing, moving = Doubts(1.5), Doubts(1.5)
    for k in range(10):
        telling(standing, 0.5, begin_s=0.5 * k, speed_mps=0.0)
        telling(moving, 0.5, begin_s=0.5 * k)
        standing.fixed(GpsFix(3, 19.0, -99.0))
        moving.fixed(GpsFix(3, 19.0, -99.0))
    assert standing.fault is None and moving.fault == "its GPS repeats itself"
    assert moving.misleads and not standing.misleads


def test_without_a_fix_it_leaves_at_once_and_is_home_when_it_comes_down(px4):
    session = make_session()
    fly(session, px4, until=until_path(session, 30))
    px4.fix_type = 1
    begin_us = px4.track[-1][0]
    fly_on(session, px4, until=lambda: session.state is State.RETURN)
    assert px4.track[-1][0] - begin_us < 1.6e6
    fly_on(session, px4)
    assert session.outcome.reason.startswith(
        "landed, disarmed (its GPS has no fix: away from the wall and home"
    )
    assert session.outcome.exit_code == 1 and not px4.armed


def test_a_receiver_that_falls_silent_is_as_good_as_none(px4):
    session = make_session()
    fly(session, px4, until=until_path(session, 30))
    px4._send_gps_raw_int = lambda: None
    begin_us = px4.track[-1][0]
    fly_on(session, px4)
    told = next(event for event in session.events if "its GPS is silent" in event.text)
    assert 1.0e6 < told.t_us - begin_us < 1.6e6 and session.outcome.exit_code == 1


def silent_after(*, positions_kept=1.0, every_s=0.2):
    """How long after its last word a receiver of one word `every_s` counts as silent, where that share of the positions comes."""
    doubts = Doubts(1.5)
    for k in range(6000):
        t_s = k / 50
        if (0.37 * k) % 1.0 < positions_kept:
            doubts.moved(LocalPosition(20 * k, 3.0 * t_s, 0.0, 0.0, 3.0, 0.0, 0.0))
        if t_s < 60.0 and k % round(50 * every_s) == 0:
            doubts.fixed(GpsFix(3, 19.0 + 1e-5 * t_s, -99.0))
        if doubts.fault:
            return t_s - 60.0
    return None


def test_a_receiver_is_silent_sooner_on_a_link_that_loses_nothing():
    assert silent_after() == pytest.approx(1.0, abs=0.6)
    assert silent_after(positions_kept=0.7) == pytest.approx(2.4, abs=0.6), "so many words may be lost"
    assert silent_after(every_s=1.0) == pytest.approx(2.0, abs=0.7), "one word a second is no silence"


def test_fixes_that_stand_still_land_it_soon_and_away_from_the_wall(px4):
    session = make_session(way_home=leaving_first)
    fly(session, px4, until=until_path(session, 30))
    px4.frozen_place, begin_us = px4.origin, px4.track[-1][0]
    fly_on(session, px4, until=lambda: session.state is State.LEAVE)
    assert 0.9e6 < px4.track[-1][0] - begin_us < 1.8e6
    east_m = px4.position[1]
    fly_on(session, px4, until=lambda: session.state is State.LAND)
    assert px4.position[1] > east_m + 4.0 and px4.track[-1][0] - begin_us < 7.0e6
    fly_on(session, px4)
    assert "its GPS repeats itself, which leads it astray" in session.outcome.reason and not px4.armed


def test_without_fixes_for_longer_than_it_can_reckon_it_comes_down(px4):
    session = make_session()
    fly(session, px4, until=until_path(session, 20))
    px4.fix_type = 1
    fly_on(session, px4, until=lambda: session.state is State.RETURN)
    begin_us = px4.track[-1][0]
    fly_on(session, px4, until=lambda: session.state is State.LAND)
    assert 5.0e6 <= px4.track[-1][0] - begin_us < 5.3e6
    fly_on(session, px4)
    assert "no longer knows where it is" in session.outcome.reason


def test_a_jump_is_not_flown_after(px4):
    session = make_session()
    fly(session, px4, until=until_path(session, 30))
    px4.estimate_off_ne_m[0] = 4.0
    stops_m = math.hypot(*px4.velocity) ** 2 / 6.0
    now_us = px4.track[-1][0] + 20_000
    received = b"".join(px4.step(now_us, []))
    while session.state is not State.RETURN:
        now_us += 20_000
        received = b"".join(px4.step(now_us, split(session.step(now_us, received).send)))
    px4.step(now_us + 20_000, split(session.step(now_us + 20_000, received).send))
    m = px4.setpoints[-1][1]
    believed = np.array(px4.position) + np.array([*px4.estimate_off_ne_m, 0.0])
    assert px4.mode == OFFBOARD
    assert np.linalg.norm(np.array([m.x, m.y, m.z]) - believed) < stops_m + 0.3, (
        "from where it is now, and can stop; not back to where it was meant to be"
    )
    fly_on(session, px4, each=lambda us: px4.estimate_off_ne_m.__setitem__(1, 3.0 * (us > now_us + 2e6)))
    assert "going on home from there" in " ".join(event.text for event in session.events)
    assert [event.text for event in session.events].count("return") == 1, "the way home is not begun again"
    steps_m = np.diff([m.y for _, m in px4.setpoints])
    assert np.count_nonzero(steps_m > 2.5) == 1, (
        "it is shifted by what jumped, so that the vehicle stays on it"
    )
    assert "its position jumped by 4.0 m" in session.outcome.reason and not px4.armed


def test_a_vehicle_that_tells_no_position_is_landed_within_seconds(px4):
    session = make_session()
    fly(session, px4, until=until_path(session, 30))
    begin_us, px4._send_local_position_ned = px4.track[-1][0], lambda: None
    fly_on(session, px4, until=lambda: session.state is State.LAND)
    assert 5.0e6 < px4.track[-1][0] - begin_us < 6.5e6
    fly_on(session, px4)
    assert "does not tell where it is" in session.outcome.reason


def test_a_vehicle_that_has_to_be_waited_for_too_long_in_all_flies_home(px4):
    session = make_session()
    fly(session, px4, until=until_path(session, 20))

    def sticks(now_us):
        px4.stuck = now_us % 20_000_000 < 15_000_000  # each wait is shorter than what lands it

    fly_on(session, px4, each=sticks, until=lambda: session.state is State.BRAKE)
    px4.stuck = False
    fly_on(session, px4)
    assert "it had to be waited for 120 s in all; flying home" in session.outcome.reason
    assert not px4.armed
