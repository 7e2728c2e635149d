"""A pilot's sticks on an ArduCopter: RC_CHANNELS_OVERRIDE and MANUAL_CONTROL, as tutorials send them."""

from __future__ import annotations

import math

import pytest
from copter_client import GUIDED, LOITER, Client, mavlink, new_simulator, pick, texts, yaw_deg

STABILIZE, ALT_HOLD, POSHOLD = 0, 2, 16
AS_IT_WAS = 65535


def override(client, roll=AS_IT_WAS, pitch=AS_IT_WAS, throttle=AS_IT_WAS, yaw=AS_IT_WAS, system=1):
    channels = roll, pitch, throttle, yaw, *(AS_IT_WAS,) * 4
    client.say(mavlink.MAVLink_rc_channels_override_message(system, 1, *channels))


def held(client, seconds, **pulses):
    client.live(seconds, lambda: override(client, **pulses), every_us=100_000)


def speed(client):
    return client.simulator.truth.velocity_ned_mps.tolist()


def tilt_deg(client):
    w, x, y, z = client.simulator.truth.q_ned_frd.tolist()
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return math.degrees(roll), math.degrees(math.asin(2 * (w * y - x * z)))


def ready_in(mode):
    client = Client(new_simulator())
    assert client.ask(176, 1, mode) == 0
    client.live(max(0.0, 41.5 - client.now_s))
    return client


@pytest.mark.parametrize("mode", [LOITER, POSHOLD])
def test_where_a_place_is_kept_the_stick_asks_for_a_speed_and_the_middle_stops_it(aloft, mode):
    assert aloft.ask(176, 1, mode) == 0
    held(aloft, 6.0, pitch=1250, roll=1500)
    north_mps, east_mps, _ = speed(aloft)
    assert north_mps == pytest.approx(12.5 * 230 / 480, rel=0.1)
    assert abs(east_mps) < 0.4
    held(aloft, 6.0, pitch=1500, roll=1700)
    assert abs(speed(aloft)[0]) < 0.4
    assert speed(aloft)[1] == pytest.approx(12.5 * 180 / 480, rel=0.1)
    held(aloft, 6.0, pitch=1500, roll=1500)
    assert math.hypot(*speed(aloft)) < 0.3


@pytest.mark.parametrize("mode", [STABILIZE, ALT_HOLD])
def test_where_no_place_is_kept_the_stick_asks_for_a_lean(aloft, mode):
    assert aloft.ask(176, 1, mode) == 0
    down_m = aloft.here[2]
    held(aloft, 1.5, pitch=1260, roll=1500, throttle=1500)
    assert tilt_deg(aloft)[1] == pytest.approx(-30.0 * 220 / 480, abs=1.5)
    held(aloft, 2.0, pitch=1500, roll=1500, throttle=1500)
    assert tilt_deg(aloft) == pytest.approx((0.0, 0.0), abs=1.0)
    assert speed(aloft)[0] > 1.5, "it drifts on"
    assert aloft.here[2] == pytest.approx(down_m, abs=0.4)


def test_throttle_climbs_and_sinks_and_its_middle_is_wide(aloft):
    assert aloft.ask(176, 1, ALT_HOLD) == 0
    held(aloft, 4.0, throttle=2000)
    assert speed(aloft)[2] == pytest.approx(-2.5, abs=0.2)
    held(aloft, 4.0, throttle=1590)
    assert abs(speed(aloft)[2]) < 0.15
    held(aloft, 2.0, throttle=1200)
    assert speed(aloft)[2] == pytest.approx(1.25, abs=0.25)


def test_the_yaw_stick_turns_it_as_fast_as_it_can_and_it_stops_where_it_is_let_go(aloft):
    assert aloft.ask(176, 1, LOITER) == 0
    before = yaw_deg(aloft)
    held(aloft, 2.0, yaw=1620)
    rate_dps = 202.5 * 100 / 480
    turned = (yaw_deg(aloft) - before) % 360.0
    assert turned == pytest.approx(2.0 * rate_dps, abs=25.0)
    held(aloft, 2.0, yaw=1500)
    rest = yaw_deg(aloft)
    held(aloft, 1.0, yaw=1500)
    assert yaw_deg(aloft) == pytest.approx(rest, abs=1.5)


@pytest.mark.parametrize("mode", [LOITER, ALT_HOLD, STABILIZE])
def test_it_takes_off_by_throttle_and_lands_by_it(mode):
    client = ready_in(mode)
    held(client, 0.5, throttle=1000)
    assert client.ask(400, 1) == 0
    ground_m = float(client.here[2])
    held(client, 3.0, throttle=1500)
    assert client.here[2] == pytest.approx(ground_m, abs=0.3)
    held(client, 5.0, throttle=1800)
    assert ground_m - client.here[2] > 3.0
    held(client, 12.0, throttle=1000)
    assert client.flight.landed.name == "ON_GROUND"
    client.until(lambda: not client.flight.armed, 15.0, lambda: override(client, throttle=1000))


@pytest.mark.parametrize(("mode", "throttle"), [(LOITER, 1800), (STABILIZE, 1500)])
def test_it_does_not_arm_with_a_raised_throttle(mode, throttle):
    client = ready_in(mode)
    held(client, 0.5, throttle=throttle)
    client.command(400, 1)
    heard = client.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [4]
    assert "Arm: Throttle too high" in texts(heard)


def test_sticks_that_are_told_no_more_are_let_go_after_rc_override_time(aloft):
    assert aloft.ask(176, 1, LOITER) == 0
    override(aloft, pitch=1200)
    aloft.live(2.8)
    assert speed(aloft)[0] > 3.0
    aloft.live(6.0)
    assert math.hypot(*speed(aloft)) < 0.3


def test_a_zero_lets_go_at_once(aloft):
    assert aloft.ask(176, 1, LOITER) == 0
    held(aloft, 2.0, pitch=1200)
    override(aloft, pitch=0)
    aloft.live(5.0)
    assert math.hypot(*speed(aloft)) < 0.3


def test_rc_channels_tell_of_them(aloft):
    aloft.command(511, 65, 100_000)
    held(aloft, 0.5, pitch=1234, throttle=1500)
    override(aloft, pitch=1234)
    last = pick(aloft.live(0.2), "RC_CHANNELS")[-1]
    assert (last.chan1_raw, last.chan2_raw, last.chan3_raw, last.chan4_raw) == (1500, 1234, 1500, 1500)
    override(aloft, throttle=0)
    aloft.live(0.2)
    assert pick(aloft.live(0.2), "RC_CHANNELS")[-1].chan3_raw == 1000


def test_a_joystick_flies_it_too(aloft):
    assert aloft.ask(176, 1, LOITER) == 0
    stick = mavlink.MAVLink_manual_control_message(1, 500, 0, 500, 0x7FFF, 0)
    aloft.live(6.0, lambda: aloft.say(stick), every_us=100_000)
    assert speed(aloft)[0] == pytest.approx(12.5 * 230 / 480, rel=0.1)
    assert abs(speed(aloft)[2]) < 0.2


def test_only_the_ground_station_and_only_to_this_vehicle(aloft):
    assert aloft.ask(176, 1, LOITER) == 0
    held(aloft, 2.0, pitch=1200, system=9)
    assert math.hypot(*speed(aloft)) < 0.3
    stranger = Client(aloft.simulator, system=7)
    held(stranger, 2.0, pitch=1200)
    assert math.hypot(*speed(aloft)) < 0.3


def test_guided_does_not_mind_them(aloft):
    held(aloft, 2.0, pitch=1200, throttle=1000)
    assert aloft.flight.mode.name == "GUIDED"
    assert math.hypot(*speed(aloft)) < 0.3
    assert aloft.ask(176, 1, GUIDED) == 0
