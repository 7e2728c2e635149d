"""SET_ATTITUDE_TARGET in GUIDED, by ArduCopter's rules: thrust is a rate of climb unless GUID_OPTIONS says otherwise."""

from __future__ import annotations

import math

import pytest
from copter_client import GUIDED, Client, mavlink, new_simulator, yaw_deg

from sitl.rotation import from_euler

RATES_IGNORED, RATE_IGNORED, NO_THRUST, NO_ATTITUDE = 0b111, 0b001, 64, 128
STILL = (0.0, 0.0, 0.0)


def angle(
    client, roll=0.0, pitch=0.0, yaw=0.0, rates=STILL, thrust=0.5, mask=RATES_IGNORED, q=None, system=1
):
    """Degrees."""
    attitude = q or from_euler(math.radians(roll), math.radians(pitch), math.radians(yaw))
    client.say(mavlink.MAVLink_set_attitude_target_message(0, system, 1, mask, attitude, *rates, thrust))


def held(client, seconds, **told):
    client.live(seconds, lambda: angle(client, **told), every_us=50_000)


def tilt_deg(client):
    w, x, y, z = client.simulator.truth.q_ned_frd.tolist()
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return math.degrees(roll), math.degrees(math.asin(2 * (w * y - x * z)))


def speed(client):
    return client.simulator.truth.velocity_ned_mps.tolist()


def test_it_leans_as_told_keeps_its_height_and_flies_that_way(aloft):
    down_m = aloft.here[2]
    held(aloft, 2.0, roll=6.0, pitch=-10.0, yaw=0.0)
    assert tilt_deg(aloft) == pytest.approx((6.0, -10.0), abs=1.5)
    assert aloft.here[2] == pytest.approx(down_m, abs=0.3)
    north_mps, east_mps, _ = speed(aloft)
    assert north_mps > 2.0 and east_mps > 1.0


def test_thrust_climbs_and_sinks_between_the_speeds_of_wpnav(aloft):
    held(aloft, 4.0, thrust=1.0)
    assert speed(aloft)[2] == pytest.approx(-2.5, abs=0.2)
    held(aloft, 4.0, thrust=0.25)
    assert speed(aloft)[2] == pytest.approx(0.75, abs=0.15)


def test_thrust_is_thrust_when_guid_options_say_so(aloft):
    aloft.say(mavlink.MAVLink_param_set_message(1, 1, b"GUID_OPTIONS", 8.0, 9))
    aloft.live(0.1)
    held(aloft, 1.0, thrust=0.9)
    assert speed(aloft)[2] < -4.0


def test_yaw_and_yaw_rate(aloft):
    held(aloft, 4.0, yaw=60.0)
    assert yaw_deg(aloft) == pytest.approx(60.0, abs=3.0)
    held(aloft, 3.0, rates=(0.0, 0.0, math.radians(20.0)), mask=NO_ATTITUDE)
    assert yaw_deg(aloft) == pytest.approx(120.0, abs=8.0)


def test_body_rates_alone_turn_the_attitude_that_it_has(aloft):
    held(aloft, 1.0, rates=(math.radians(10.0), 0.0, 0.0), mask=NO_ATTITUDE)
    assert tilt_deg(aloft)[0] == pytest.approx(10.0, abs=3.0)


def test_after_guid_timeout_it_is_level_and_stays_as_high(aloft):
    held(aloft, 1.0, pitch=-10.0, thrust=0.9)
    aloft.live(2.5)
    assert tilt_deg(aloft)[1] == pytest.approx(-10.0, abs=2.0)
    aloft.live(4.0)
    assert tilt_deg(aloft) == pytest.approx((0.0, 0.0), abs=1.5)
    assert abs(speed(aloft)[2]) < 0.2


@pytest.mark.parametrize(
    "told",
    [{"mask": RATES_IGNORED | NO_THRUST}, {"q": (0.9, 0.0, 0.2, 0.0)}, {"system": 9}, {"thrust": math.nan}],
    ids=["no thrust", "no unit quaternion", "another vehicle", "no number"],
)
def test_what_arducopter_does_not_take_moves_nothing(aloft, told):
    held(aloft, 2.0, **{"pitch": -15.0} | told)
    assert math.hypot(*speed(aloft)) < 0.3


def test_rates_that_are_told_in_part_stop_it(aloft):
    held(aloft, 2.0, pitch=-12.0)
    assert speed(aloft)[0] > 2.0
    held(aloft, 6.0, pitch=-12.0, mask=RATE_IGNORED)
    assert math.hypot(*speed(aloft)) < 0.3


def test_outside_guided_it_is_ignored(aloft):
    assert aloft.ask(176, 1, 5) == 0
    held(aloft, 2.0, pitch=-12.0)
    assert math.hypot(*speed(aloft)) < 0.3


def test_a_place_ends_it(aloft):
    held(aloft, 2.0, pitch=-8.0)
    north_m, east_m, down_m = (float(value) for value in aloft.here)
    aloft.live(8.0, lambda: aloft.target(p=(north_m, east_m, down_m)))
    assert math.dist(aloft.here, (north_m, east_m, down_m)) < 0.5


def test_it_takes_off_by_it_and_not_with_the_thrust_that_holds():
    client = Client(new_simulator())
    assert client.ask(176, 1, GUIDED) == 0
    client.live(max(0.0, 41.5 - client.now_s))
    assert client.ask(400, 1) == 0
    ground_m = float(client.here[2])
    held(client, 3.0, thrust=0.5)
    assert client.here[2] == pytest.approx(ground_m, abs=0.3)
    held(client, 5.0, thrust=0.9)
    assert ground_m - client.here[2] > 3.0
