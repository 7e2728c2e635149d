"""The nose: a step in yaw as ArduCopter's own SITL turns, and CONDITION_YAW in GUIDED."""

import math

import numpy as np
import pytest
from copter_client import Client, new_simulator
from pymavlink.dialects.v20 import ardupilotmega as mavlink


def true_yaw_deg(client):
    w, x, y, z = client.simulator.truth.q_ned_frd
    return math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def turning(client, seconds=6.0):
    """The heading's change, unwrapped, every 10 ms."""
    begin_deg, seen = true_yaw_deg(client), []
    for _ in range(round(seconds * 100)):
        client.live(0.01)
        seen.append(true_yaw_deg(client) - begin_deg)
    return np.degrees(np.unwrap(np.radians(seen)))


def stepped(client, step_deg):
    """How far it overshoots, and when it is within 1° for good."""
    here = [float(value) for value in client.here]
    client.target(p=here, yaw=0.0)
    client.live(4.0)
    client.target(p=here, yaw=math.radians(step_deg))
    off_deg = turning(client) - step_deg
    return off_deg.max(), 0.01 * (1 + np.flatnonzero(np.abs(off_deg) > 1.0).max())


@pytest.fixture
def hovering():
    return Client(new_simulator()).airborne()


@pytest.mark.parametrize("step_deg", [30.0, 90.0])
def test_a_step_in_yaw_overshoots_by_about_10_degrees_as_arducopters_own_sitl_was_tuned_to(
    hovering, step_deg
):
    """ArduPilot's pull request 24973 shows some 10° at corners of 90°, where it had been more than 30°."""
    over_deg, settled_s = stepped(hovering, step_deg)
    assert 5.0 < over_deg < 13.0
    assert settled_s < 4.0


def test_a_yaw_rate_loop_that_is_tuned_stiffer_overshoots_by_a_third_of_that(hovering):
    for name, value in ((b"ATC_RAT_YAW_P", 1.0), (b"ATC_RAT_YAW_I", 0.1)):
        hovering.say(mavlink.MAVLink_param_set_message(1, 1, name, value, 9))
    over_deg, settled_s = stepped(hovering, 30.0)
    assert over_deg < 5.0
    assert settled_s < 2.0


def test_condition_yaw_turns_a_copter_that_has_just_taken_off(hovering):
    assert hovering.ask(115, 30.0, 0.0, 1.0, 1.0) == 0
    assert turning(hovering)[-1] == pytest.approx(30.0, abs=2.0)


@pytest.mark.parametrize(("way", "turned_deg"), [(1.0, 90.0), (-1.0, -270.0), (0.0, 90.0)])
def test_condition_yaw_comes_to_its_heading_the_way_round_that_it_says(hovering, way, turned_deg):
    hovering.target(p=[float(value) for value in hovering.here], yaw=0.0)
    hovering.live(4.0)
    assert hovering.ask(115, 90.0, 0.0, way, 0.0) == 0
    assert turning(hovering, 10.0)[-1] == pytest.approx(turned_deg, abs=2.0)
    assert hovering.ask(115, 90.0, 0.0, way, 0.0) == 0
    assert turning(hovering)[-1] == pytest.approx(0.0, abs=2.0)


def test_condition_yaw_turns_at_its_rate(hovering):
    assert hovering.ask(115, 60.0, 10.0, -1.0, 1.0) == 0
    turned_deg = turning(hovering, 5.0)
    assert turned_deg[400] - turned_deg[200] == pytest.approx(-20.0, abs=3.0)


@pytest.mark.parametrize("params", [(361.0, 0, 1, 0), (-1.0, 0, 1, 1), (math.nan, 0, 1, 0), (90.0, 0, 1, 2)])
def test_condition_yaw_beyond_a_circle_fails(hovering, params):
    assert hovering.ask(115, *params) == 4
