"""What the vehicle does without us: checked, or set for the flight and put back."""

from dataclasses import replace

import pytest
from fake_flight import HOME, VEHICLE_ORIGIN, fly, make_session
from fake_px4 import POSCTL, FakePx4

from mavspiral.flight.journal import JournalWriter, borrowed_in
from mavspiral.flight.outcome import SessionConfig, State

UNSAFE = {
    "COM_OF_LOSS_T": 5.0,
    "COM_OBL_RC_ACT": 0,
    "COM_RCL_EXCEPT": 3,
    "RTL_RETURN_ALT": 20.0,
    "RTL_CONE_ANG": 45,
    "RTL_TYPE": 2,
    "COM_LOW_BAT_ACT": 0,
    "COM_TAKEOFF_ACT": 0,
    "MPC_XY_VEL_D_ACC": 0.2,
}
SAFE = {
    "COM_OF_LOSS_T": 1.0,
    "COM_OBL_RC_ACT": 3,
    "COM_RCL_EXCEPT": 7,
    "RTL_RETURN_ALT": 44.0,
    "RTL_CONE_ANG": 0,
    "RTL_TYPE": 0,
    "COM_LOW_BAT_ACT": 3,
}


@pytest.fixture
def careless(px4):
    px4.parameters |= UNSAFE
    return px4


def sets(**more):
    # Home is 3 m below the plan's ground.
    return SessionConfig(set_failsafes=True, safe_height_enu_m=40.5, **more)


def warnings(session):
    return " | ".join(event.text for event in session.events if event.severity == "warning")


def test_without_being_asked_it_warns_and_sets_nothing(careless):
    session = make_session(SessionConfig(safe_height_enu_m=40.5))
    fly(session, careless)
    assert "COM_OBL_RC_ACT = 0" in warnings(session) and "set it to 44" in warnings(session)
    assert "RTL_CONE_ANG = 45: near home its own Return stays below" in warnings(session)
    assert "RTL_TYPE = 2" in warnings(session) and "COM_LOW_BAT_ACT = 0" in warnings(session)
    assert "COM_RCL_EXCEPT = 3: it leaves OFFBOARD" in warnings(session)
    assert not careless.set_parameters


def test_asked_to_it_sets_what_is_unsafe_and_puts_it_back(careless):
    session = make_session(sets())
    in_flight = {}
    fly(
        session,
        careless,
        each=lambda _: in_flight.update(careless.parameters) if session.state is State.STREAM else None,
    )
    assert {name: in_flight[name] for name in SAFE} == pytest.approx(SAFE)
    assert not warnings(session)
    assert session.outcome.ok
    assert {name: careless.parameters[name] for name in UNSAFE} == pytest.approx(UNSAFE)
    assert "left as set" not in warnings(session)


def test_what_is_safe_already_is_left_alone(careless):
    careless.parameters |= SAFE | {"COM_OBL_RC_ACT": 5}
    session = make_session(sets())
    fly(session, careless)
    assert not careless.set_parameters and session.outcome.ok


def test_a_dry_run_sets_nothing(careless):
    session = make_session(sets(dry_run=True))
    fly(session, careless)
    assert session.outcome.ok and not careless.set_parameters


def test_who_takes_over_is_told_what_is_left_as_set(careless):
    session = make_session(sets())
    fly(session, careless, until=lambda: session.path_t_s > 3)
    careless.mode = POSCTL
    fly(session, careless)
    assert "pilot took over" in session.outcome.reason
    assert "COM_OBL_RC_ACT = 3 (was 0)" in warnings(session)


def test_a_vehicle_that_does_not_take_them_is_not_armed(careless):
    careless._on_param_set = lambda m: None
    session = make_session(sets())
    fly(session, careless)
    assert "does not take the parameters" in session.outcome.reason and not careless.armed


@pytest.mark.parametrize("config", [SessionConfig(), sets()], ids=["not-set", "set"])
def test_that_nothing_guards_a_px4s_climb_is_said_once_before_it_is_armed(careless, config):
    session = make_session(config)
    fly(session, careless, until=lambda: careless.armed)
    said = [event for event in session.events if "hovers above home" in event.text]
    assert [event.severity for event in said] == ["info"]


def test_what_a_failing_battery_does_is_said_and_only_where_it_does_it(px4):
    words = "COM_LOW_BAT_ACT = 3: a battery that fails at once"
    for acts, told in ((3, True), (0, False)):
        px4.parameters["COM_LOW_BAT_ACT"] = acts
        session = make_session(SessionConfig(dry_run=True))
        fly(session, px4)
        said = [event for event in session.events if words in event.text]
        assert [event.severity for event in said] == ["info"] * told


def journaled(path, careless, config, *, until=None):
    """A flight that is written into the journal at `path`."""
    session = make_session(config)
    with path.open("ab") as file:
        writer = JournalWriter(file.write)
        writer.begin({})
        step = session.step

        def noted(now_us, received):
            writer.note(session, taken := step(now_us, received))
            return taken

        session.step = noted
        fly(session, careless, until=until and (lambda: until(session)))
    return session


def stands_at_home_again(px4):
    """The same vehicle after it has come down by itself."""
    later = FakePx4(VEHICLE_ORIGIN, HOME)
    later.parameters = px4.parameters
    return later


@pytest.mark.parametrize("again", [sets(), SessionConfig(safe_height_enu_m=40.5)], ids=["asked", "not-asked"])
def test_what_a_killed_flight_has_set_the_next_one_puts_back(careless, tmp_path, again):
    journaled(tmp_path / "j", careless, sets(), until=lambda session: session.path_t_s > 3)
    assert {name: careless.parameters[name] for name in SAFE} == pytest.approx(SAFE)
    owed = borrowed_in(tmp_path / "j")
    assert owed == {name: pytest.approx((UNSAFE[name], SAFE[name])) for name in SAFE}
    careless = stands_at_home_again(careless)
    session = journaled(tmp_path / "j", careless, replace(again, borrowed=owed))
    assert session.outcome.ok, session.outcome
    assert {name: careless.parameters[name] for name in UNSAFE} == pytest.approx(UNSAFE)
    told = [event.text for event in session.events if "an earlier flight has left" in event.text]
    assert len(told) == 1 and "COM_OBL_RC_ACT = 3 (was 0)" in told[0]
    assert not borrowed_in(tmp_path / "j")


def test_what_somebody_has_changed_since_the_killed_flight_is_left_alone(careless):
    careless.parameters |= SAFE | {"COM_OBL_RC_ACT": 5}
    owed = {"COM_OBL_RC_ACT": (0.0, 3.0), "RTL_TYPE": (2.0, 0.0)}
    session = make_session(sets(borrowed=owed))
    fly(session, careless)
    assert session.outcome.ok
    assert careless.parameters["COM_OBL_RC_ACT"] == 5 and careless.parameters["RTL_TYPE"] == 2


def test_what_a_killed_flight_has_set_and_nobody_can_read_is_told(careless):
    del careless.parameters["RTL_TYPE"]
    session = make_session(SessionConfig(borrowed={"RTL_TYPE": (2.0, 0.0)}))
    fly(session, careless)
    told = [event.text for event in session.events if event.severity == "warning" and "earlier" in event.text]
    assert told == [
        "RTL_TYPE could not be read; an earlier flight has set it to 0 (was 2): put it back yourself"
    ]
