"""SET_POSITION_TARGET_GLOBAL_INT in OFFBOARD, by PX4's rules."""

from __future__ import annotations

import math

import pytest

from sitl.geo import geodetic_of_ned
from sitl.orders import Mode

POSITION, VELOCITY = 0xFF8, 0xFC7
PLACE_AND_YAW = 0xBF8
GLOBAL, GLOBAL_INT, RELATIVE_INT, TERRAIN_INT = 0, 5, 6, 11


def target(client, ned_m=(0.0, 0.0), alt_m=0.0, velocity=(0.0, 0.0, 0.0), mask=POSITION, frame=5, **more):
    """A target so far north and east of the estimate's origin."""
    origin = client.simulator.report.origin
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    lat_deg, lon_deg, _ = geodetic_of_ned(anchor, (*ned_m, 0.0))
    fields = {
        "time_boot_ms": 0,
        "lat_int": round(lat_deg * 1e7),
        "lon_int": round(lon_deg * 1e7),
        "alt": alt_m,
        **dict(zip(("vx", "vy", "vz"), velocity, strict=True)),
        **dict.fromkeys(("afx", "afy", "afz", "yaw", "yaw_rate"), 0.0),
        "type_mask": mask,
        "target_system": 1,
        "target_component": 1,
        "coordinate_frame": frame,
    }
    client.say("SET_POSITION_TARGET_GLOBAL_INT", **(fields | more))


def offboard(client, stream):
    client.live(0.5, stream)
    client.command(176, 1, 6)
    client.live(0.1, stream)


def here(client):
    return client.simulator.report.estimate.position_ned_m.tolist()


def test_a_place_above_the_sea_is_flown_to(client):
    client.airborne(10.0)
    alt_m = client.simulator.report.origin.alt_amsl_m + 14.0

    def stream():
        target(client, (6.0, -5.0), alt_m, mask=PLACE_AND_YAW, yaw=1.0)

    offboard(client, stream)
    assert client.flight.mode is Mode.OFFBOARD
    client.live(8.0, stream)
    assert here(client) == pytest.approx([6.0, -5.0, -14.0], abs=0.5)
    w, x, y, z = client.simulator.truth.q_ned_frd.tolist()
    assert math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(1.0, abs=0.1)


def test_a_relative_height_has_homes_offset_from_the_origin_the_wrong_way_round_as_px4_has(client):
    client.airborne(10.0)
    origin = client.simulator.report.origin
    client.command(179, 0, 0, 0, 0, origin.lat_deg, origin.lon_deg, origin.alt_amsl_m + 3.0)
    client.live(0.1)

    def stream():
        target(client, (0.0, 0.0), 16.0, frame=RELATIVE_INT)

    offboard(client, stream)
    client.live(8.0, stream)
    assert client.flight.home.point.alt_amsl_m == pytest.approx(origin.alt_amsl_m + 3.0)
    assert here(client)[2] == pytest.approx(3.0 - 16.0, abs=0.5)


def test_a_velocity_needs_no_frame(client):
    client.airborne(10.0)

    def stream():
        target(client, velocity=(1.5, 0.0, 0.0), mask=VELOCITY, frame=TERRAIN_INT)

    offboard(client, stream)
    client.live(4.0, stream)
    assert client.simulator.truth.velocity_ned_mps[0] == pytest.approx(1.5, abs=0.3)


@pytest.mark.parametrize(
    "bad",
    [
        {"frame": GLOBAL},
        {"frame": TERRAIN_INT},
        {"mask": 0xFFF},
        {"mask": POSITION | 1},
        {"mask": 0x207},
        {"target_system": 9},
    ],
    ids=["frame 0", "above terrain", "nothing told", "place told in part", "force", "another vehicle"],
)
def test_what_px4_refuses_is_no_stream(client, bad):
    client.airborne(10.0)
    offboard(client, lambda: target(client, (5.0, 0.0), 2250.0, **bad))
    assert client.flight.mode is Mode.HOLD
