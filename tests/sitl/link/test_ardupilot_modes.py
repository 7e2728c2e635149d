"""ArduCopter's CIRCLE mode: where it circles, how fast, and where it looks; and the modes that are not there."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from copter_client import mavlink, pick, texts, yaw_deg

CIRCLE = 7


def begun(client, **parameters):
    for name, value in parameters.items():
        client.say(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, 9))
    client.live(0.1)
    assert client.ask(176, 1, CIRCLE) == 0
    return client


def rounds(client, seconds):
    """Place from second to second, and the nose."""
    seen = []
    for _ in range(seconds):
        client.live(1.0)
        north_m, east_m, down_m = client.simulator.truth.position_ned_m.tolist()
        seen.append((complex(north_m, east_m), down_m, yaw_deg(client)))
    return seen


def test_it_circles_clockwise_about_what_lies_before_its_nose_and_looks_at_it(aloft):
    before_m, nose = complex(*aloft.simulator.truth.position_ned_m.tolist()[:2]), math.radians(yaw_deg(aloft))
    centre_m = before_m + 10.0 * complex(math.cos(nose), math.sin(nose))
    begun(aloft).live(4.0)
    seen = rounds(aloft, 18)
    for place_m, down_m, nose_deg in seen:
        assert abs(place_m - centre_m) == pytest.approx(10.0, abs=0.8)
        assert down_m == pytest.approx(seen[0][1], abs=0.4)
        inwards = centre_m - place_m
        off = math.remainder(nose_deg - math.degrees(math.atan2(inwards.imag, inwards.real)), 360.0)
        assert abs(off) < 8.0
    turns = [(b[0] - centre_m) / (a[0] - centre_m) for a, b in pairwise(seen)]
    assert [math.degrees(math.atan2(t.imag, t.real)) for t in turns] == pytest.approx([20.0] * 17, abs=2.0)


def test_the_other_way_round_and_no_faster_than_wpnav_accel_allows(aloft):
    begun(aloft, CIRCLE_RATE=-90.0).live(8.0)
    north_mps, east_mps, _ = aloft.simulator.truth.velocity_ned_mps.tolist()
    assert math.hypot(north_mps, east_mps) == pytest.approx(math.sqrt(0.5 * 2.5 * 10.0), abs=0.3)
    rate = aloft.simulator.truth.rate_frd_radps[2]
    assert rate == pytest.approx(-math.sqrt(0.5 * 2.5 / 10.0), abs=0.1)


def test_without_a_radius_it_turns_where_it_is(aloft):
    place_m = aloft.here.tolist()
    begun(aloft, CIRCLE_RADIUS=0.0).live(6.0)
    assert math.dist(aloft.here.tolist(), place_m) < 0.5
    assert aloft.simulator.truth.rate_frd_radps[2] == pytest.approx(math.radians(20.0), abs=0.05)


def test_it_tells_seven_and_cannot_be_armed_in(copter):
    copter.live(42.0)
    assert copter.ask(176, 1, CIRCLE) == 0
    assert pick(copter.live(1.1), "HEARTBEAT")[-1].custom_mode == CIRCLE
    copter.command(400, 1)
    heard = copter.live(0.1)
    assert pick(heard, "COMMAND_ACK")[-1].result == 4
    assert "Arm: CIRCLE mode not armable" in texts(heard)


@pytest.mark.parametrize(
    ("number", "said"),
    [(1, "Mode change to ACRO failed: not simulated"), (99, "No such mode 99")],
    ids=["what an ArduCopter has", "what none has"],
)
def test_a_mode_that_is_not_there_is_refused_and_named(copter, number, said):
    copter.live(4.0)
    copter.command(176, 1, number)
    heard = copter.live(0.1)
    assert pick(heard, "COMMAND_ACK")[-1].result == 4
    assert texts(heard) == [said]
