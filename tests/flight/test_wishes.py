"""What a pilot may wish in flight, and the word before it."""

import pytest
from fake_flight import fly, make_session, split

from mavspiral.errors import LimitError
from mavspiral.flight.messages import Command, MessageId
from mavspiral.flight.outcome import SessionConfig, State
from mavspiral.flight.wishes import Wish

LOITER, OFFBOARD = 4 << 16 | 3 << 24, 6 << 16


def texts(session):
    return [event.text for event in session.events]


def flown_until(session, px4, path_t_s):
    fly(session, px4, until=lambda: session.path_t_s > path_t_s)


def setpoints_in(sent):
    return sum(frame[7] == MessageId.SET_POSITION_TARGET_LOCAL_NED for frame in split(sent))


def on(session, px4, until=None, limit_s=600.0):
    """Go on from where the last `fly` ended."""
    now_us, received = px4.track[-1][0], b""
    for _ in range(int(limit_s * 50)):
        now_us += 20_000
        sent = session.step(now_us, received).send
        received = b"".join(px4.step(now_us, split(sent)))
        if session.outcome or (until and until()):
            return now_us
    raise AssertionError(f"still in {session.state}: {session.events[-5:]}")


def held(px4, path_t_s=30.0):
    session = make_session()
    flown_until(session, px4, path_t_s)
    session.wish(Wish.STOP)
    on(session, px4, until=lambda: session.state is State.HOLD and session._s.follower.pace.rate == 0.0)
    return session


def test_held_it_goes_on_from_there_and_flies_the_rest(px4):
    session = held(px4)
    at_s = session.path_t_s
    session.wish(Wish.GO_ON)
    on(session, px4)
    assert session.outcome.ok, session.outcome
    log = session.log()
    inspected_s = log.path_t_s[log.on_leg("inspection")]
    assert (inspected_s[1:] - inspected_s[:-1]).max() < 0.05, "nothing is left out, nothing flown twice"
    assert at_s > 30.0 and f"going on: {State.STREAM.value}" in texts(session)


def test_held_it_lands_there(px4):
    session = held(px4)
    session.wish(Wish.LAND)
    on(session, px4)
    assert session.outcome.reason == "landed, disarmed (stopped by the user; landing)" and not px4.armed
    assert State.RETURN.value not in texts(session)


def test_handed_over_it_holds_by_itself_and_hears_nothing_more(px4):
    session = held(px4)
    session.wish(Wish.HAND_OVER)
    on(session, px4)
    assert session.outcome.exit_code == 1
    assert session.outcome.reason == "handed over: it holds in AUTO.LOITER; change its mode to fly it"
    assert px4.mode == LOITER and px4.armed
    sent_n = len(px4.setpoints)
    px4.step(px4.track[-1][0] + 20_000, [session.step(px4.track[-1][0] + 20_000, b"").send][:0])
    assert len(px4.setpoints) == sent_n


def test_called_home_at_once_it_does_not_wait_for_anybody(px4):
    session = make_session()
    flown_until(session, px4, 30.0)
    session.wish(Wish.GO_HOME)
    on(session, px4)
    assert session.outcome.reason == "landed, disarmed (stopped by the user; flying home)"
    assert State.HOLD.value not in texts(session) and not px4.armed


def test_what_nobody_has_done_afterwards_the_next_step_does_first(px4):
    session = make_session()
    flown_until(session, px4, 30.0)
    session.wish(Wish.GO_HOME)
    now_us, received, step = px4.track[-1][0], b"", None
    while step is None or step.afterwards is None:
        now_us += 20_000
        step = session.step(now_us, received)
        received = b"".join(px4.step(now_us, split(step.send)))
    assert session.state is State.BRAKE and setpoints_in(step.send) == 1
    again = session.step(now_us + 20_000, received)
    assert session.state is State.RETURN and again.afterwards is None and setpoints_in(again.send) == 1
    step.afterwards()
    assert texts(session).count(State.RETURN.value) == 1, "what is done is done once"


def test_where_no_way_home_is_found_afterwards_it_lands(px4):
    def nowhere(*places):
        raise LimitError("walls on all sides")

    session = make_session(way_home=nowhere)
    flown_until(session, px4, 30.0)
    session.wish(Wish.GO_HOME)
    on(session, px4)
    assert "walls on all sides; landing" in session.outcome.reason and not px4.armed


def test_on_the_way_home_it_can_be_held_and_go_on(px4):
    session = make_session()
    flown_until(session, px4, 30.0)
    session.wish(Wish.GO_HOME)
    on(session, px4, until=lambda: session.state is State.RETURN)
    session.wish(Wish.STOP)
    on(session, px4, until=lambda: session.state is State.HOLD)
    on(session, px4, until=lambda: session._s.follower.pace.rate == 0.0)
    session.wish(Wish.GO_ON)
    on(session, px4)
    assert session.state is State.LAND and not px4.armed


def test_what_changes_nothing_is_answered(px4):
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.LAND)
    session.stop()
    on(session, px4)
    assert session.outcome.ok and any("landing already" in text for text in texts(session))


def test_a_hold_lasts_no_longer_than_the_battery(px4):
    session = held(px4)
    began_us = px4.track[-1][0]

    def drained():
        px4.battery_pct = 90 - int((px4.track[-1][0] - began_us) / 2e6)
        return False

    on(session, px4, until=drained)
    assert "flying home" in session.outcome.reason and not px4.armed
    assert px4.battery_pct > 0


def asking(px4):
    session = make_session(SessionConfig(question="arm it and fly"))
    fly(session, px4, until=lambda: session.question == "arm it and fly")
    return session


def test_the_word_is_asked_after_the_checks_and_before_anything_is_armed(px4):
    session = asking(px4)
    assert State.CHECK.value in texts(session) and not px4.armed
    with pytest.raises(AssertionError, match="CONSENT"):
        on(session, px4, limit_s=120.0)
    assert Command.COMPONENT_ARM_DISARM not in {m.command for _, m in px4.commands}
    session.approve()
    on(session, px4)
    assert session.outcome.ok, session.outcome


def test_without_the_word_nothing_is_armed(px4):
    session = asking(px4)
    session.stop()
    on(session, px4)
    assert session.outcome.reason == "stopped before take-off" and not px4.armed


def test_what_changed_while_nobody_answered_is_checked_anew(px4):
    session = asking(px4)
    px4.battery_pct = 12
    on(session, px4, until=lambda: session._s.vehicle.status.battery_pct == 12)
    session.approve()
    on(session, px4)
    assert "battery at 12 %" in session.outcome.reason and not px4.armed


def test_a_dry_run_asks_nobody(px4):
    session = make_session(SessionConfig(dry_run=True, question="arm it and fly"))
    fly(session, px4)
    assert session.outcome.ok and not px4.armed
