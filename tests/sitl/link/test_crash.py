"""What a vehicle that has lost a motor says of itself, and where it lies."""

import math

import pytest
from copter_client import Client as Copter
from copter_client import new_simulator, texts

from sitl.faults import parse_fault


def inverted(simulator):
    _, x, y, _ = simulator.truth.q_ned_frd
    return 1.0 - 2.0 * (x * x + y * y) < -0.9


def height_m(simulator):
    """Above where it stood, of the body's centre."""
    return -float(simulator.truth.position_ned_m[2])


def px4_texts(client, pick):
    return [text.text.decode() for text in pick([m for _, _, m in client.heard], "STATUSTEXT")]


@pytest.fixture
def flying(new_client):
    """A client whose PX4 loses its motor 1 at the given time; armed at 7 s."""

    def fly(fault):
        client = new_client()
        client.simulator.inject(parse_fault(fault))
        client.heartbeat()
        client.live(6.0)
        client.command(22)
        client.live(0.1)
        client.command(400, 1.0)
        return client

    return fly


def test_a_vehicle_that_fell_over_lies_on_the_ground_and_not_in_it(flying, x500):
    client = flying("motor=1:0@22s")
    client.live(30.0)
    assert inverted(client.simulator)
    hubs_m = x500.ground.leg_height_m + x500.rotors.position_frd_m[0, 2]
    assert height_m(client.simulator) == pytest.approx(-hubs_m, abs=0.02)
    assert float((client.simulator.truth.velocity_ned_mps**2).sum()) < 1e-3


def test_px4_tells_of_an_attitude_failure_in_flight_and_flies_on(flying, pick):
    client = flying("motor=1:0@22s")
    client.live(20.0)
    told = px4_texts(client, pick)
    assert "Preflight Fail: Attitude failure (roll)" in told and "Failsafe activated" in told
    assert client.simulator.report.flight.armed and client.simulator.report.flight.failsafe


def test_px4_disarms_who_tips_over_right_after_take_off_and_does_not_arm_it_again(flying, pick):
    client = flying("motor=1:0@8.5s")
    client.live(10.0)
    assert not client.simulator.report.flight.armed and "Disarmed by failsafe" in px4_texts(client, pick)
    client.heard.clear()
    client.command(400, 1.0)
    client.live(0.5)
    assert [ack.result for ack in pick([m for _, _, m in client.heard], "COMMAND_ACK")] == [1]
    assert not client.simulator.report.flight.armed


def test_px4_with_flight_termination_allowed_stops_its_motors(flying):
    client = flying("motor=1:0@22s")
    client.simulator._craft.set_parameter("CBRK_FLIGHTTERM", 0)
    client.live(20.0)
    assert not client.simulator.report.flight.armed


def test_arducopter_disarms_who_crashed_and_does_not_arm_who_lies_on_its_back():
    client = Copter(new_simulator(faults=(parse_fault("motor=1:0@62s"),))).airborne()
    heard = client.live(max(0.0, 75.0 - client.now_s))
    assert any(text.startswith("Crash: Disarming") for text in texts(heard))
    assert not client.flight.armed and inverted(client.simulator)
    assert height_m(client.simulator) > -0.2
    client.command(400, 1)
    heard = client.live(0.5)
    assert "Arm: Leaning" in texts(heard) and not client.flight.armed


def test_arducopter_takes_off_until_it_is_up_and_is_then_in_the_air():
    client = Copter(new_simulator()).airborne()
    assert client.flight.landed.name == "IN_AIR"
    client.command(511, 245, 100_000)
    states = {m.landed_state for m in client.live(1.0) if m.get_type() == "EXTENDED_SYS_STATE"}
    assert states == {2}
    assert math.isclose(-client.here[2] + client.flight.home.position_ned_m[2], 10.0, abs_tol=0.5)
