"""PX4's Position mode under a ground station's joystick: MANUAL_CONTROL."""

import math

import pytest
from px4_client import messages

POSITION = (176, 1, 3)
AUXILIARY = [f"aux{number}" for number in range(1, 7)]


def sticks(client, forward=0, right=0, up=500, clockwise=0, target=1):
    rest = dict.fromkeys(("buttons", "buttons2", "enabled_extensions", "s", "t", *AUXILIARY), 0)
    client.say("MANUAL_CONTROL", target=target, x=forward, y=right, z=up, r=clockwise, **rest)


def fly(client, seconds, **deflected):
    client.live(seconds, lambda: sticks(client, **deflected), every_us=40_000)


def place_m(client):
    return client.simulator.truth.position_ned_m.tolist()


def yaw_deg(client):
    w, x, y, z = client.simulator.truth.q_ned_frd.tolist()
    return math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def results(heard):
    return [ack.result for ack in messages(heard, "COMMAND_ACK")]


@pytest.fixture
def aloft(new_client):
    return new_client().airborne()


@pytest.fixture
def led(aloft):
    """In POSITION, its sticks let go."""
    fly(aloft, 0.2)
    aloft.command(*POSITION)
    fly(aloft, 0.5)
    assert aloft.flight.mode.name == "POSITION"
    return aloft


def test_without_sticks_it_stays_where_it_is(aloft):
    aloft.heartbeat()
    aloft.command(*POSITION)
    assert results(aloft.live(0.1)) == [0, 0]
    before = place_m(aloft)
    aloft.live(20.0, aloft.heartbeat, every_us=500_000)
    assert aloft.flight.mode.name == "POSITION" and not aloft.flight.failsafe
    assert math.dist(place_m(aloft), before) < 0.3


def test_sticks_that_have_gone_do_not_let_it_arm(client):
    client.until(lambda: client.flight.ready, 10.0)
    fly(client, 0.2)
    client.live(2.0)
    client.command(*POSITION)
    client.command(400, 1, 0)
    assert 1 in results(client.live(0.1))
    assert client.flight.mode.name == "POSITION" and not client.flight.armed
    fly(client, 0.2)
    client.command(400, 1, 0)
    client.live(0.1)
    assert client.flight.armed


def test_it_flies_where_the_sticks_lead_and_stays_where_they_are_let_go(led):
    north_m, east_m, down_m = place_m(led)
    fly(led, 4.0, forward=400)
    assert place_m(led)[0] > north_m + 6.0
    fly(led, 6.0)
    stood = place_m(led)
    fly(led, 6.0)
    assert math.dist(place_m(led), stood) < 0.3
    assert stood[1:] == pytest.approx([east_m, down_m], abs=0.5)
    fly(led, 3.0, up=1000)
    assert place_m(led)[2] < down_m - 4.0
    fly(led, 4.0, right=-400)
    assert place_m(led)[1] < east_m - 6.0


def test_the_sticks_lead_from_the_noses_point_of_view(led):
    fly(led, 2.0, clockwise=370)  # 0.3 of 150 deg/s beyond the dead zone
    fly(led, 3.0)
    assert yaw_deg(led) == pytest.approx(90.0, abs=4.0)
    north_m, east_m, _ = place_m(led)
    fly(led, 4.0, forward=400)
    assert place_m(led)[1] > east_m + 6.0
    assert place_m(led)[0] == pytest.approx(north_m, abs=1.5)


def test_up_on_the_ground_takes_off_and_down_lands(client):
    client.until(lambda: client.flight.ready, 10.0)
    fly(client, 0.2)
    client.command(*POSITION)
    client.command(400, 1, 0)
    fly(client, 3.0)
    assert client.flight.armed and place_m(client)[2] > -0.1
    fly(client, 4.0, up=900)
    assert place_m(client)[2] < -3.0
    fly(client, 25.0, up=0)
    assert not client.flight.armed and place_m(client)[2] == pytest.approx(0.0, abs=0.05)


def test_sticks_that_stay_away_bring_it_home_and_come_back_to_lead_it(led):
    fly(led, 3.0, forward=600)
    led.live(0.4)
    assert led.flight.mode.name == "POSITION"
    led.live(0.3)
    assert (led.flight.mode.name, led.flight.failsafe) == ("RETURN", True)
    fly(led, 0.2)
    assert (led.flight.mode.name, led.flight.failsafe) == ("POSITION", False)


@pytest.mark.parametrize(("name", "value"), [("COM_RC_IN_MODE", 0), ("COM_RC_IN_MODE", 4)])
def test_com_rc_in_mode_forbids_a_joystick(aloft, name, value):
    aloft.simulator._craft.set_parameter(name, value)
    aloft.command(*POSITION)
    before = place_m(aloft)
    fly(aloft, 3.0, forward=400)
    assert aloft.flight.mode.name == "POSITION" and math.dist(place_m(aloft), before) < 0.3


@pytest.mark.parametrize("wrong", [{"target": 7}, {"forward": 2000}, {"right": 32767}])
def test_sticks_of_another_vehicle_or_beyond_their_ends_are_no_sticks(aloft, wrong):
    aloft.command(*POSITION)
    before = place_m(aloft)
    fly(aloft, 3.0, **({"forward": 400} | wrong))
    assert aloft.flight.mode.name == "POSITION" and math.dist(place_m(aloft), before) < 0.3


def test_a_led_flight_goes_on_from_a_snapshot_bit_by_bit(led):
    fly(led, 1.0, forward=500, clockwise=100)
    snapshot, now_us = led.simulator.snapshot(), led.now_us
    fly(led, 2.0, forward=500, clockwise=100)
    once = place_m(led)
    led.simulator.restore(snapshot)
    led.now_us = now_us
    fly(led, 2.0, forward=500, clockwise=100)
    assert place_m(led) == once
