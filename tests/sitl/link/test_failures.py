"""MAV_CMD_INJECT_FAILURE: refused unless SYS_FAILURE_EN is set, then done, ended, and remembered by snapshots."""

from __future__ import annotations

import math

import pytest

GPS, MOTOR, BARO = 4, 101, 3
OK, OFF, STUCK = 0, 1, 2


@pytest.fixture
def failing(new_client):
    return new_client(params={"SYS_FAILURE_EN": 1})


def inject(client, pick, unit, kind, instance=0.0):
    client.command(420, unit, kind, instance)
    return [ack.result for ack in pick(client.live(0.1), "COMMAND_ACK")]


def test_it_is_refused_until_it_is_allowed(client, pick):
    client.airborne()
    assert inject(client, pick, GPS, OFF) == [2]
    client.live(7.0)
    assert client.simulator.report.estimate.position_ok


def test_a_gps_that_is_off_gives_no_fix_until_it_is_well(failing, pick):
    failing.airborne()
    assert inject(failing, pick, GPS, OFF) == [0]
    failing.live(1.0)
    assert failing.simulator.report.instruments.gps is None
    assert inject(failing, pick, GPS, OK) == [0]
    failing.live(1.0)
    assert failing.simulator.report.instruments.gps is not None


def test_a_motor_that_is_off_brings_it_down(failing, pick):
    failing.airborne(20.0)
    assert inject(failing, pick, MOTOR, OFF, 2) == [0]
    failing.live(3.0)
    assert failing.simulator.truth.position_ned_m[2] > -15.0


@pytest.mark.parametrize(
    ("unit", "kind", "instance"),
    [
        (BARO, OFF, 0),
        (MOTOR, OFF, 9),
        (MOTOR, OFF, -1),
        (GPS, STUCK, 3),
        (math.nan, OFF, 0),
        (GPS, math.inf, 0),
    ],
)
def test_what_cannot_fail_here_is_unsupported(failing, pick, unit, kind, instance):
    assert inject(failing, pick, unit, kind, instance) == [3]


def test_a_barometer_that_is_stuck_says_the_same_until_it_is_well(failing, pick):
    failing.live(1.0)

    def heights():
        return {failing.live(0.1) and failing.simulator.report.instruments.baro.alt_amsl_m for _ in range(10)}

    assert len(heights()) > 5
    assert inject(failing, pick, BARO, STUCK) == [0]
    assert len(heights()) == 1
    assert inject(failing, pick, BARO, OK) == [0]
    assert len(heights()) > 5


def test_a_battery_that_is_off_is_empty(failing, pick):
    failing.live(1.0)
    assert inject(failing, pick, 100, OFF) == [0]
    failing.live(1.0)
    assert failing.simulator.report.instruments.battery.remaining < 0.01


def test_a_failure_survives_a_snapshot(failing, pick):
    failing.airborne()
    inject(failing, pick, GPS, OFF)
    failing.live(0.5)
    state = failing.simulator.snapshot()
    inject(failing, pick, GPS, OK)
    failing.live(0.5)
    failing.simulator.restore(state)
    failing.simulator.exchange(failing.simulator.time_us + 500_000, (b"",))
    assert failing.simulator.report.instruments.gps is None
