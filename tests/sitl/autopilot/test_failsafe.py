"""What the commander does by itself, over a body that does what it is told at once."""

import math

import numpy as np
import pytest
from obedient import Flight

from sitl.orders import Mode, SwitchMode, Verdict
from sitl.signals import Setpoint

NAN = math.nan


def hover(down_m=-20.0):
    return Setpoint((0.0, 0.0, down_m), (0.0, 0.0, 0.0), (NAN, NAN, NAN), 0.0, NAN)


def texts(flight):
    return [notice.text for notice in flight.commander.take_notices()]


@pytest.fixture
def offboard():
    flight = Flight().airborne().offboard(hover())
    texts(flight)
    return flight


def test_without_a_position_it_sinks_level_as_auto_land_and_takes_up_offboard_when_it_is_back(offboard):
    offboard.body.ok = False
    blind = offboard.live(2.0, hover())[-1].setpoint
    assert offboard.status.mode is Mode.LAND and offboard.status.failsafe
    assert texts(offboard) == ["Failsafe activated: Autopilot disengaged, switching to Descend"]
    assert np.isnan(blind.position_ned_m).all() and np.isnan(blind.velocity_ned_mps[:2]).all()
    assert blind.velocity_ned_mps[2] == pytest.approx(0.7)  # MPC_LAND_SPEED
    assert blind.acceleration_ned_mps2[:2] == (0.0, 0.0)
    offboard.body.ok = True
    again = offboard.live(1.0, hover())[-1].setpoint
    assert offboard.status.mode is Mode.OFFBOARD and not offboard.status.failsafe
    assert again.position_ned_m == (0.0, 0.0, -20.0)


def test_without_a_position_it_sinks_to_the_ground_and_disarms(offboard):
    offboard.body.ok = False
    offboard.live(40.0, hover())
    assert not offboard.status.armed
    assert offboard.body.position[2] == pytest.approx(0.0)


def test_a_low_battery_is_only_told_of(offboard):
    offboard.body.charge_left = 0.14
    offboard.live(10.0, hover())
    assert offboard.status.mode is Mode.OFFBOARD and not offboard.status.failsafe
    assert texts(offboard) == ["Low battery level, return advised"]


@pytest.mark.parametrize(
    ("action", "left", "mode", "advice"),
    [
        (3, 0.06, Mode.RETURN, "Critical battery level, land now"),
        (3, 0.04, Mode.LAND, "Emergency battery level, land immediately"),
        (2, 0.06, Mode.LAND, "Critical battery level, land now"),
        (1, 0.04, Mode.RETURN, "Emergency battery level, land immediately"),
    ],
)
def test_a_critical_battery_holds_for_com_fail_act_t_and_then_acts_by_com_low_bat_act(
    action, left, mode, advice
):
    flight = Flight(COM_LOW_BAT_ACT=action).airborne().offboard(hover())
    texts(flight)
    flight.body.charge_left = left
    flight.live(4.9, hover())
    assert flight.status.mode is Mode.HOLD and flight.status.failsafe
    flight.live(0.3, hover())
    assert flight.status.mode is mode and flight.status.failsafe
    assert texts(flight) == [advice, "Failsafe activated: entering Hold for 5 seconds", "Failsafe activated"]


def test_com_low_bat_act_0_warns_only():
    flight = Flight(COM_LOW_BAT_ACT=0).airborne().offboard(hover())
    flight.body.charge_left = 0.02
    flight.live(10.0, hover())
    assert flight.status.mode is Mode.OFFBOARD
    assert texts(flight)[-1] == "Emergency battery level, land immediately"


def test_whoever_switches_the_mode_takes_over_until_it_gets_worse(offboard):
    offboard.body.charge_left = 0.06
    offboard.live(6.0, hover())
    assert offboard.status.mode is Mode.RETURN
    assert offboard.obey(SwitchMode(Mode.HOLD)) is Verdict.ACCEPTED
    offboard.live(10.0)
    assert offboard.status.mode is Mode.HOLD and not offboard.status.failsafe
    offboard.body.charge_left = 0.04
    offboard.live(6.0)
    assert offboard.status.mode is Mode.LAND


def test_a_battery_that_was_low_at_arming_does_not_end_the_flight():
    flight = Flight()
    flight.body.charge_left = 0.06
    flight.airborne()
    flight.live(10.0)
    assert flight.status.mode is Mode.HOLD and not flight.status.failsafe


def test_the_gravest_reason_counts(offboard):
    """Setpoints lost, which asks for Return, and an emergency battery, which asks for Land."""
    offboard.body.charge_left = 0.04
    offboard.live(2.0)
    assert offboard.status.mode is Mode.RETURN
    offboard.live(4.0)
    assert offboard.status.mode is Mode.LAND
