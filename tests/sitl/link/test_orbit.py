"""MAV_CMD_DO_ORBIT and DO_CHANGE_SPEED as commands, CURRENT_MODE."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import development

from sitl.geo import ned_of_geodetic
from sitl.link.codec import Codec
from sitl.link.messages import layout, message_type
from sitl.orders import Mode

NAN = math.nan


def place(client, north_m, east_m):
    home = client.flight.home.point
    return home.lat_deg + north_m / 111_000.0, home.lon_deg + east_m / (
        111_000.0 * math.cos(math.radians(home.lat_deg))
    )


def orbit(client, pick, radius=NAN, speed=NAN, yaw=NAN, at=(NAN, NAN), height_m=NAN):
    alt_amsl_m = client.flight.home.point.alt_amsl_m + height_m
    lat_deg, lon_deg = at if math.isnan(at[0]) else place(client, *at)
    client.command(34, radius, speed, yaw, NAN, lat_deg, lon_deg, alt_amsl_m)
    return [(ack.command, ack.result) for ack in pick(client.live(0.1), "COMMAND_ACK")]


def flown(client, seconds):
    """Truth every 0.1 s: position and velocity (n, 3), and the nose's direction."""
    positions, velocities, yaws = [], [], []
    for _ in range(round(seconds * 10)):
        client.live(0.1)
        truth = client.simulator.truth
        w, x, y, z = truth.q_ned_frd.tolist()
        positions.append(truth.position_ned_m)
        velocities.append(truth.velocity_ned_mps)
        yaws.append(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    return np.array(positions), np.array(velocities), np.array(yaws)


@pytest.mark.parametrize("radius_m", [12.0, -12.0])
def test_it_goes_round_the_place_at_the_radius_and_speed_looking_at_it(client, pick, radius_m):
    client.airborne()
    assert orbit(client, pick, radius_m, 3.0, at=(20.0, 5.0), height_m=14.0) == [(34, 0)]
    client.live(15.0)
    positions, velocities, yaws = flown(client, 30.0)
    centre = np.array(ned_of_geodetic(
        (client.flight.home.point.lat_deg, client.flight.home.point.lon_deg, 0.0), (*place(client, 20.0, 5.0), 0.0)
    ))  # fmt: skip
    arms = (positions - centre)[:, :2]
    assert np.sqrt((arms**2).sum(axis=1)) == pytest.approx(abs(radius_m), abs=0.8)
    assert positions[:, 2] == pytest.approx(-14.0, abs=0.5)
    assert np.sqrt((velocities[:, :2] ** 2).sum(axis=1)) == pytest.approx(3.0, abs=0.3)
    angles = np.unwrap(np.arctan2(arms[:, 1], arms[:, 0]))
    assert angles[-1] - angles[0] == pytest.approx(math.copysign(3.0 / 12.0 * 29.9, radius_m), rel=0.1)
    off = np.abs((yaws - np.arctan2(-arms[:, 1], -arms[:, 0]) + math.pi) % math.tau - math.pi)
    assert off.max() < math.radians(6.0)


def test_it_is_told_in_heartbeat_current_mode_and_orbit_status(client, pick):
    client.airborne()
    orbit(client, pick, 10.0, 2.0, at=(0.0, 15.0))
    heard = client.live(4.0)
    beat = pick(heard, "HEARTBEAT")[-1]
    assert (beat.custom_mode >> 16 & 0xFF, beat.custom_mode >> 24) == (3, 1)
    assert pick(heard, "CURRENT_MODE")[-1].standard_mode == 2
    status = pick(heard, "ORBIT_EXECUTION_STATUS")
    assert len(status) == pytest.approx(8, abs=1)
    lat_deg, lon_deg = place(client, 0.0, 15.0)
    assert (status[-1].x * 1e-7, status[-1].y * 1e-7) == pytest.approx(
        (lat_deg, lon_deg), abs=1e-5
    )  # COMMAND_LONG has floats
    assert status[-1].radius == 10.0
    client.command(176, 1, 4, 3)
    assert pick(client.live(3.0)[10:], "ORBIT_EXECUTION_STATUS") == []
    assert client.flight.mode is Mode.HOLD


@pytest.mark.parametrize(("behaviour", "turn_deg"), [(1, 0.0), (3, 90.0)])
def test_the_nose_keeps_its_heading_or_looks_along_the_circle(client, pick, behaviour, turn_deg):
    client.airborne()
    orbit(client, pick, 8.0, 2.0, behaviour, at=(0.0, 0.0))
    client.live(12.0)
    before = flown(client, 0.1)[2][0]
    positions, _, yaws = flown(client, 10.0)
    if behaviour == 1:
        assert yaws == pytest.approx(before, abs=0.1)
    else:
        outward = np.arctan2(positions[:, 1], positions[:, 0])
        off = np.abs((yaws - outward - math.radians(turn_deg) + math.pi) % math.tau - math.pi)
        assert off.max() < math.radians(12.0)


def test_what_is_left_out_stays_and_too_fast_is_clipped(client, pick):
    client.airborne()
    orbit(client, pick, 9.0, 2.0, at=(0.0, 0.0))
    client.live(2.0)
    orbit(client, pick, speed=50.0)
    run = client.flight.orbit
    assert run.radius_m == 9.0
    client.live(15.0)
    _, velocities, _ = flown(client, 5.0)
    assert np.sqrt((velocities[:, :2] ** 2).sum(axis=1)) == pytest.approx(math.sqrt(2.0 * 9.0), abs=0.5)


def test_on_the_ground_it_is_refused(client, pick):
    client.until(lambda: client.flight.ready, 10.0)
    assert orbit(client, pick, 10.0, 2.0) == [(34, 1)]
    client.command(400, 1.0, 0.0)
    assert orbit(client, pick, 10.0, 2.0)[-1] == (34, 1)
    assert client.flight.mode is Mode.HOLD


def go(client, north_m, east_m):
    lat_deg, lon_deg = place(client, north_m, east_m)
    client.say(
        "COMMAND_INT", param1=-1.0, param2=1.0, param3=0.0, param4=NAN, x=round(lat_deg * 1e7),
        y=round(lon_deg * 1e7), z=NAN, command=192, target_system=1, target_component=1, frame=0, current=0,
        autocontinue=0,
    )  # fmt: skip


@pytest.mark.parametrize("before", [True, False])
def test_a_change_of_speed_holds_for_repositions_until_the_mode_changes(client, pick, before):
    client.airborne()
    if before:
        client.command(178, 1.0, 2.0, -1.0)
    go(client, 60.0, 0.0)
    client.live(1.0)
    if not before:
        client.command(178, 1.0, 2.0, -1.0)
    client.live(5.0)
    assert client.simulator.truth.velocity_ned_mps[0] == pytest.approx(2.0, abs=0.2)
    client.command(176, 1, 4, 3)
    client.command(178, 1.0, -1.0, -1.0)
    go(client, 100.0, 0.0)
    client.live(7.0)
    assert client.simulator.truth.velocity_ned_mps[0] == pytest.approx(5.0, abs=0.4)


@pytest.mark.parametrize(("kind", "speed_mps"), [(2.0, 1.0), (1.0, NAN), (NAN, 3.0)])
def test_a_change_of_speed_that_it_cannot_make_is_denied(client, pick, kind, speed_mps):
    client.command(178, kind, speed_mps)
    assert [ack.result for ack in pick(client.live(0.1), "COMMAND_ACK")] == [2]


def test_an_orbit_survives_a_snapshot(client, pick):
    client.airborne()
    orbit(client, pick, 10.0, 3.0, at=(5.0, 0.0))
    client.live(8.0)
    state, now_us = client.simulator.snapshot(), client.now_us
    client.live(3.0)
    end_m = client.simulator.truth.position_ned_m
    client.simulator.restore(state)
    client.now_us = now_us
    client.live(3.0)
    assert (client.simulator.truth.position_ned_m == end_m).all()


def test_current_mode_is_packed_as_pymavlinks_development_dialect_packs_it():
    kind = message_type("CURRENT_MODE")
    mav = development.MAVLink(None, srcSystem=1, srcComponent=1)
    theirs = development.MAVLink_current_mode_message(2, 3 << 16, 4 << 16).pack(mav)
    assert Codec(1, 1).encode(kind(3 << 16, 4 << 16, 2)) == theirs
    assert layout(436).type is kind
