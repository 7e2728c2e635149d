"""The commander alone, over a body that does what it is told at once."""

import math
from dataclasses import replace

import numpy as np
import pytest
from obedient import NAN3, ORIGIN, Flight

from sitl.orders import Arm, Disarm, Mode, Reposition, SwitchMode, TakeOff, Verdict
from sitl.signals import Setpoint, Sticks
from sitl.status import Landed


def setpoint(position=NAN3, velocity=NAN3, acceleration=NAN3, yaw=math.nan):
    return Setpoint(position, velocity, acceleration, yaw, math.nan)


def texts(flight):
    return [notice.text for notice in flight.commander.take_notices()]


def test_it_boots_into_hold_and_knows_home_as_soon_as_its_place():
    flight = Flight()
    flight.body.ok = False
    flight.live(0.1)
    assert (flight.status.mode, flight.status.home, flight.status.ready) == (Mode.HOLD, None, False)
    flight.body.ok = True
    flight.live(0.1)
    assert flight.status.home.point.alt_amsl_m == pytest.approx(2240.0)


def test_arming_is_refused_until_the_vehicle_knows_its_place_unless_forced():
    flight = Flight()
    flight.body.ok = False
    assert flight.obey(Arm()) is Verdict.NOT_NOW
    assert texts(flight) == ["Arming denied: Resolve system health failures first"]
    assert flight.obey(Arm(force=True)) is Verdict.ACCEPTED


@pytest.mark.parametrize("mode", [Mode.LAND, Mode.RETURN])
def test_arming_is_refused_in_modes_that_end_on_the_ground(mode):
    flight = Flight()
    flight.live(0.1)
    flight.obey(SwitchMode(mode))
    assert flight.obey(Arm()) is Verdict.NOT_NOW


def test_armed_without_take_off_it_disarms_after_eleven_and_a_half_seconds():
    flight = Flight()
    flight.live(0.1)
    flight.obey(Arm())
    assert all(demand.idle for demand in flight.live(11.4))
    assert flight.status.armed
    flight.live(0.2)
    assert not flight.status.armed


def test_take_off_spools_climbs_and_holds():
    flight = Flight()
    flight.live(0.1)
    flight.obey(TakeOff(ORIGIN.alt_amsl_m + 10.0))
    assert flight.status.mode is Mode.TAKEOFF
    flight.obey(Arm())
    assert all(demand.idle for demand in flight.live(0.95))
    states = set()
    speeds = []
    while flight.status.mode is Mode.TAKEOFF:
        flight.live(0.01)
        states.add(flight.status.landed)
        speeds.append(-flight.body.velocity[2])
    assert Landed.TAKING_OFF in states
    assert max(speeds) == pytest.approx(1.5, abs=0.05)
    flight.live(10.0)
    assert flight.status.landed is Landed.IN_AIR
    assert flight.body.position == pytest.approx([0.0, 0.0, -10.0], abs=0.01)


def test_take_off_without_a_height_goes_to_the_usual_one():
    flight = Flight(MIS_TAKEOFF_ALT=4.0)
    flight.live(0.1)
    flight.obey(TakeOff(math.nan))
    flight.obey(Arm())
    flight.live(20.0)
    assert flight.body.position[2] == pytest.approx(-4.0, abs=0.01)


def test_take_off_to_below_the_ground_is_accepted_and_stays_down():
    flight = Flight()
    flight.live(0.1)
    flight.obey(Arm())
    assert flight.obey(TakeOff(ORIGIN.alt_amsl_m - 5.0)) is Verdict.ACCEPTED
    assert all(demand.idle for demand in flight.live(5.0))


def test_take_off_in_flight_never_descends():
    flight = Flight().airborne(20.0)
    flight.obey(TakeOff(ORIGIN.alt_amsl_m + 5.0))
    flight.live(10.0)
    assert flight.body.position[2] == pytest.approx(-20.0, abs=0.05)


def test_disarming_in_the_air_is_refused_unless_forced():
    flight = Flight().airborne()
    assert flight.obey(Disarm()) is Verdict.NOT_NOW
    assert flight.status.armed
    assert flight.obey(Disarm(force=True)) is Verdict.ACCEPTED
    assert not flight.commander.command(flight.body).armed


def test_landing_slows_towards_the_ground_and_disarms_two_seconds_after():
    flight = Flight().airborne(20.0)
    flight.obey(SwitchMode(Mode.LAND))
    speeds = {}
    while not flight.body.on_ground:
        (demand,) = flight.live(0.01)
        assert math.isnan(demand.setpoint.position_ned_m[2])
        speeds[round(-flight.body.position[2])] = flight.body.velocity[2]
        assert flight.body.on_ground or flight.status.landed is Landed.LANDING
    assert speeds[12] == pytest.approx(1.5, abs=0.02)
    assert speeds[3] == pytest.approx(0.7, abs=0.02)
    flight.live(1.9)
    assert flight.status.armed
    flight.live(0.2)
    assert not flight.status.armed
    assert flight.status.mode is Mode.HOLD


def test_offboard_disarmed_without_a_stream_is_accepted_and_then_arming_is_refused():
    flight = Flight()
    flight.live(0.1)
    assert flight.obey(SwitchMode(Mode.OFFBOARD)) is Verdict.ACCEPTED
    assert flight.status.mode is Mode.OFFBOARD
    assert flight.obey(Arm()) is Verdict.NOT_NOW


def test_offboard_in_flight_without_a_stream_is_refused():
    flight = Flight().airborne()
    assert flight.obey(SwitchMode(Mode.OFFBOARD)) is Verdict.NOT_NOW
    assert flight.status.mode is Mode.HOLD


def test_setpoints_are_obeyed_in_offboard_only():
    flight = Flight().airborne(20.0)
    there = setpoint([3.0, 4.0, -20.0])
    flight.live(1.0, there)
    assert flight.body.position[:2] == pytest.approx([0.0, 0.0], abs=0.01)
    flight.offboard(there)
    assert flight.body.position == pytest.approx([3.0, 4.0, -20.0])


def test_lost_setpoints_are_chased_for_a_second_and_then_the_vehicle_goes_home():
    flight = Flight().airborne(20.0)
    drift = setpoint(velocity=[3.0, 0.0, 0.0])
    flight.offboard(drift)
    begin = flight.body.position[0]
    flight.live(1.03)
    assert flight.status.mode is Mode.OFFBOARD
    assert flight.body.position[0] - begin == pytest.approx(3.09, abs=0.02)
    flight.live(0.05)
    assert flight.status.mode is Mode.RETURN
    assert flight.status.failsafe
    assert "Failsafe activated" in texts(flight)


def test_setpoints_that_come_back_bring_it_back_to_offboard():
    flight = Flight().airborne(20.0)
    drift = setpoint(velocity=[3.0, 0.0, 0.0])
    flight.offboard(drift)
    flight.live(2.0)
    assert flight.status.mode is Mode.RETURN
    flight.live(0.1, drift)
    assert flight.status.mode is Mode.OFFBOARD
    assert not flight.status.failsafe


def test_another_mode_ends_the_failsafe_for_good():
    flight = Flight().airborne(20.0)
    drift = setpoint(velocity=[3.0, 0.0, 0.0])
    flight.offboard(drift)
    flight.live(2.0)
    flight.obey(SwitchMode(Mode.HOLD))
    flight.live(1.0, drift)
    assert flight.status.mode is Mode.HOLD
    assert not flight.status.failsafe


@pytest.mark.parametrize(
    ("rate_hz", "mode"), [(0.95, Mode.OFFBOARD), (3.0, Mode.OFFBOARD), (0.8, Mode.RETURN)]
)
def test_a_slow_stream_holds_offboard_down_to_just_below_one_hertz(rate_hz, mode):
    flight = Flight().airborne(20.0)
    here = setpoint([0.0, 0.0, -20.0])
    flight.offboard(here)
    seen = set()
    for _ in range(4):
        flight.commander.steer(here, flight.body)
        for _ in range(round(100 / rate_hz)):
            flight.live(0.01)
            seen.add(flight.status.mode)
    assert (Mode.RETURN in seen) is (mode is Mode.RETURN)


@pytest.mark.parametrize(
    ("params", "mode"),
    [
        ({"COM_OBL_RC_ACT": 4}, Mode.LAND),
        ({"COM_OBL_RC_ACT": 5}, Mode.HOLD),
        ({"NAV_RCL_ACT": 3}, Mode.LAND),
        ({"NAV_RCL_ACT": 1}, Mode.HOLD),
    ],
)
def test_the_parameters_choose_what_follows_the_loss(params, mode):
    flight = Flight(**params).airborne(20.0)
    flight.offboard(setpoint([0.0, 0.0, -20.0]))
    flight.live(1.2)
    assert flight.status.mode is mode


@pytest.mark.parametrize(
    "bad",
    [
        setpoint([1.0, math.nan, -20.0]),
        setpoint([1.0, 2.0, math.nan]),
        setpoint(velocity=[math.nan, 1.0, 0.0]),
        setpoint([math.nan, math.nan, -20.0]),
    ],
)
def test_an_axis_without_a_command_stops_the_vehicle_in_offboard(bad):
    flight = Flight().airborne(20.0)
    flight.offboard(setpoint(velocity=[2.0, 0.0, 0.0]))
    flight.live(7.0, bad)
    stopped = flight.body.position.copy()
    demands = flight.live(2.0, bad)
    assert all(np.isfinite(demand.setpoint.position_ned_m).all() for demand in demands)
    assert flight.status.mode is Mode.OFFBOARD
    assert flight.body.position == pytest.approx(stopped, abs=0.01)
    assert texts(flight)[-1] != "Failsafe activated"


def test_return_climbs_first_flies_home_and_lands_there():
    flight = Flight().airborne(20.0)
    flight.offboard(setpoint(velocity=[5.0, 0.0, 0.0]))
    flight.live(10.0, setpoint(velocity=[5.0, 0.0, 0.0]))
    far_m = flight.body.position[0]
    assert flight.obey(SwitchMode(Mode.RETURN)) is Verdict.ACCEPTED
    path = []
    while flight.status.armed:
        flight.live(0.1)
        path.append(flight.body.position.copy())
    north, _east, down = np.array(path).T
    assert down.min() == pytest.approx(-30.0, abs=0.1)
    assert north[down > -29.0].max() < far_m + 10.0
    assert (down[(north > 5.0) & (north < far_m - 1.0)] < -28.0).all()
    assert path[-1] == pytest.approx([0.0, 0.0, 0.0], abs=0.05)


def test_reposition_flies_there_and_holds():
    flight = Flight().airborne(20.0)
    goal = Reposition(19.4351, math.nan, 2265.0, math.nan, math.nan)
    assert flight.obey(replace(goal, lon_deg=-99.146)) is Verdict.ACCEPTED
    flight.live(20.0)
    assert flight.body.position == pytest.approx([11.07, 0.0, -25.0], abs=0.05)
    flight.obey(goal)
    flight.live(5.0)
    assert flight.body.position == pytest.approx([11.07, 0.0, -25.0], abs=0.05)


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.LAND, Mode.RETURN, Mode.TAKEOFF, Mode.POSITION])
def test_no_mode_begins_with_a_step(mode):
    flight = Flight().airborne(20.0)
    flight.commander.parameters.set("COM_RC_LOSS_T", 20.0)
    flight.commander.hear_sticks(Sticks(0.0, 0.0, 0.0, 0.0), flight.body.time_us)
    moving = setpoint(velocity=[3.0, -2.0, -1.0])
    flight.offboard(moving)
    flight.live(2.0, moving)
    position, velocity = flight.body.position.copy(), flight.body.velocity.copy()
    assert flight.obey(SwitchMode(mode)) is Verdict.ACCEPTED
    for demand in flight.live(8.0):
        goal, speed = map(np.array, demand.setpoint[:2])
        assert np.linalg.norm(np.nan_to_num(goal - position)) < 0.12
        assert np.linalg.norm(speed - velocity) < 0.05
        position, velocity = goal, speed


def test_a_snapshot_goes_on_as_the_original():
    flight = Flight().airborne(20.0)
    flight.obey(SwitchMode(Mode.RETURN))
    flight.live(0.5)
    state, body = flight.commander.snapshot(), replace(flight.body)
    first = repr([d.setpoint for d in flight.live(1.0)])
    flight.commander.restore(state)
    flight.body = body
    assert repr([d.setpoint for d in flight.live(1.0)]) == first
