"""On-site alignment: the shift has the right sign, is bounded, is asked for, and nothing moves without it."""

import numpy as np
import pytest
from fake_flight import HOME, PLAN_ORIGIN, VEHICLE_ORIGIN, fly, make_session, texts

from mavspiral.flight.outcome import SessionConfig, State
from mavspiral.frames import GeoPoint, LocalFrame

STANDS_ENU_M = LocalFrame(PLAN_ORIGIN).to_vehicle(GeoPoint(*VEHICLE_ORIGIN)).position_enu_m(HOME)
OFF_M = np.array([2.0, -1.5, 0.0])


def aligning(off_m=OFF_M, **kwargs):
    """The place where it stands is `off_m` away from where the plan has it."""
    return make_session(align_at_enu_m=STANDS_ENU_M - off_m, **kwargs)


def test_it_averages_on_the_ground_then_waits_for_a_word_and_does_not_arm_without(px4):
    session = aligning()
    fly(session, px4, until=lambda: session.alignment.question)
    assert session.alignment.shift_enu_m == pytest.approx(OFF_M, abs=0.02)
    assert "2.00 m east and 1.50 m south" in session.alignment.question
    with pytest.raises(AssertionError, match="APPROVE"):
        fly(session, px4, limit_s=30.0)
    session.stop()
    fly(session, px4)
    assert session.outcome.reason == "stopped before take-off" and not px4.armed


def test_approved_the_whole_flight_lies_elsewhere_by_the_shift(px4):
    """Its log is of the plan as planned; the vehicle, in its own frame, was so far away from there."""
    session = aligning()
    fly(session, px4, until=lambda: session.alignment.question)
    session.approve()
    fly(session, px4)
    assert session.outcome.ok, session.outcome
    log = session.log()
    on_it = log.on_leg("inspection")
    planned_enu_m = session.trajectory(log.path_t_s[on_it]).position_enu_m
    assert np.allclose(log.reference_position_enu_m[on_it], planned_enu_m, atol=1e-3)
    sent_ned_m = np.array([(m.x, m.y, m.z) for _, m in px4.setpoints])
    to_vehicle = LocalFrame(PLAN_ORIGIN).to_vehicle(GeoPoint(*VEHICLE_ORIGIN))
    nearest_m = [
        np.linalg.norm(to_vehicle.position_enu_m(sent_ned_m) - (place + OFF_M), axis=1).min()
        for place in planned_enu_m[::100]
    ]
    assert max(nearest_m) < 0.2


def test_a_wrong_corner_is_refused_on_the_ground(px4):
    session = aligning(np.array([4.0, 3.1, 0.0]))
    fly(session, px4)
    assert session.outcome.exit_code == 1 and not px4.armed
    assert "stands 5.1 m from there" in session.outcome.reason and "at most 5 m" in session.outcome.reason


def test_heights_are_told_and_not_shifted(px4):
    session = aligning(np.array([1.0, 0.0, -3.0]))
    fly(session, px4, until=lambda: session.alignment.question)
    assert session.alignment.shift_enu_m[2] == 0.0
    assert "3.0 m below that place" in texts(session)


def test_a_vehicle_that_is_being_carried_is_refused(px4):
    session = aligning()

    def carried(_):
        if session.state is State.MEASURE:
            px4.position[0] += 0.004

    fly(session, px4, each=carried)
    assert "wanders" in session.outcome.reason and not px4.armed


def test_a_dry_run_measures_and_does_not_arm(px4):
    session = aligning(config=SessionConfig(dry_run=True))
    fly(session, px4, until=lambda: session.alignment.question)
    session.approve()
    fly(session, px4)
    assert session.outcome.ok and "aligned: the plan is shifted" in texts(session) and not px4.armed


def test_without_a_place_nothing_is_measured(px4):
    session = make_session()
    fly(session, px4)
    assert session.alignment is None and "aligned" not in texts(session)
