"""What the vehicle does without us: checked, or set for the flight and put back."""

import pytest
from fake_flight import fly, make_session
from fake_px4 import POSCTL

from mavspiral.flight.outcome import SessionConfig, State

UNSAFE = {
    "COM_OF_LOSS_T": 5.0,
    "COM_OBL_RC_ACT": 0,
    "COM_RCL_EXCEPT": 3,
    "RTL_RETURN_ALT": 20.0,
    "RTL_CONE_ANG": 45,
    "RTL_TYPE": 2,
    "COM_LOW_BAT_ACT": 0,
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


def test_what_a_failing_battery_does_is_said_and_only_where_it_does_it(px4):
    words = "COM_LOW_BAT_ACT = 3: a battery that fails at once"
    for acts, told in ((3, True), (0, False)):
        px4.parameters["COM_LOW_BAT_ACT"] = acts
        session = make_session(SessionConfig(dry_run=True))
        fly(session, px4)
        said = [event for event in session.events if words in event.text]
        assert [event.severity for event in said] == ["info"] * told
