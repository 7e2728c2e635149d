"""SET_ATTITUDE_TARGET in OFFBOARD: attitude and thrust, or body rates and thrust, by PX4's rules."""

from __future__ import annotations

import math

import pytest

from sitl.orders import Mode
from sitl.rotation import from_euler

RATES_IGNORED, ATTITUDE_IGNORED, THRUST_IGNORED = 0b111, 128, 64
NAN = math.nan


def target(client, q=(1.0, 0.0, 0.0, 0.0), rates=(0.0, 0.0, 0.0), thrust=0.5, mask=RATES_IGNORED, **who):
    names = ("body_roll_rate", "body_pitch_rate", "body_yaw_rate")
    to = {"target_system": 1, "target_component": 1} | who
    fields = dict(zip(names, rates, strict=True)) | to
    client.say("SET_ATTITUDE_TARGET", time_boot_ms=0, q=tuple(q), thrust=thrust, type_mask=mask, **fields)


def tilt(client):
    """Roll and pitch, truly."""
    w, x, y, z = client.simulator.truth.q_ned_frd.tolist()
    return math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), math.asin(2 * (w * y - x * z))


def offboard(client, stream):
    client.live(0.5, stream)
    client.command(176, 1, 6)
    client.live(0.1, stream)
    assert client.flight.mode is Mode.OFFBOARD


def test_the_vehicle_takes_the_attitude_and_flies_where_it_leans(client, pick):
    client.airborne(20.0)
    hover = client.simulator.report.instruments.thrust
    q = from_euler(math.radians(5.0), math.radians(-8.0), 0.0)
    offboard(client, lambda: target(client, q, thrust=hover))
    client.heard.clear()
    heard = client.live(1.5, lambda: target(client, q, thrust=hover))
    assert tilt(client) == pytest.approx((math.radians(5.0), math.radians(-8.0)), abs=math.radians(1.5))
    north_mps, east_mps, _ = client.simulator.truth.velocity_ned_mps.tolist()
    assert north_mps > 1.0
    assert east_mps > 0.5
    assert pick(heard, "ATTITUDE_TARGET")[-1].q == pytest.approx(q, abs=1e-6)
    assert pick(heard, "ATTITUDE_TARGET")[-1].thrust == pytest.approx(hover, abs=1e-6)


def test_more_thrust_climbs_and_less_sinks(client):
    client.airborne(20.0)
    hover = client.simulator.report.instruments.thrust
    offboard(client, lambda: target(client, thrust=1.2 * hover))
    client.live(1.0, lambda: target(client, thrust=1.2 * hover))
    assert client.simulator.truth.velocity_ned_mps[2] < -0.8
    client.live(3.0, lambda: target(client, thrust=0.85 * hover))
    assert client.simulator.truth.velocity_ned_mps[2] > 0.5


def test_the_yaw_rate_turns_it_about_down(client):
    client.airborne(20.0)
    hover = client.simulator.report.instruments.thrust

    def stream():
        target(client, client.simulator.report.estimate.q_ned_frd.tolist(), (9.0, 9.0, 0.5), hover, mask=0)

    offboard(client, stream)
    client.live(1.5, stream)
    assert client.simulator.truth.rate_frd_radps[2] == pytest.approx(0.5, abs=0.15)
    assert abs(tilt(client)[0]) < 0.1


def test_body_rates_alone_are_followed(client):
    client.airborne(40.0)
    hover = client.simulator.report.instruments.thrust

    def stream():
        target(client, (NAN,) * 4, (0.3, 0.0, 0.4), hover, mask=ATTITUDE_IGNORED)

    offboard(client, stream)
    client.live(1.2, stream)  # torque about the yaw axis is low-passed
    assert client.simulator.truth.rate_frd_radps == pytest.approx([0.3, 0.0, 0.4], abs=0.1)


@pytest.mark.parametrize(
    "bad",
    [
        {"mask": RATES_IGNORED | ATTITUDE_IGNORED},
        {"mask": RATES_IGNORED | THRUST_IGNORED},
        {"q": (NAN, 0.0, 0.0, 0.0)},
        {"q": (0.0, 0.0, 0.0, 0.0)},
        {"thrust": math.inf},
        {"rates": (NAN, 0.0, 0.0), "mask": ATTITUDE_IGNORED},
        {"target_system": 2},
        {"target_component": 42},
    ],
)
def test_what_lacks_attitude_or_thrust_is_no_stream(client, bad):
    client.airborne()
    client.live(0.5, lambda: target(client, **bad))
    client.command(176, 1, 6)
    client.live(0.1, lambda: target(client, **bad))
    assert client.flight.mode is Mode.HOLD


def test_position_setpoints_take_over_again(client):
    client.airborne(20.0)
    hover = client.simulator.report.instruments.thrust
    q = from_euler(0.0, math.radians(-10.0), 0.0)
    offboard(client, lambda: target(client, q, thrust=hover))
    client.live(1.0, lambda: target(client, q, thrust=hover))
    client.live(10.0, lambda: client.setpoint((0.0, 0.0, -20.0)))
    assert client.simulator.truth.position_ned_m == pytest.approx([0.0, 0.0, -20.0], abs=0.5)
