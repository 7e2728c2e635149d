"""PX4's geofence in flight: what GF_ACTION does, and how one gets out again."""

import math

import pytest
from conftest import HOME

from sitl.orders import TakePlan
from sitl.plans import PlanItem, PlanKind

METRE_LAT_DEG = math.degrees(1.0 / 6.357e6)
METRE_LON_DEG = METRE_LAT_DEG / math.cos(math.radians(HOME.lat_deg))


def corners(command, *places_m):
    """Corners by metres north and east of home."""
    count = float(len(places_m))
    return tuple(
        PlanItem(command, 0, (count, 0, 0, 0, HOME.lat_deg + n * METRE_LAT_DEG, HOME.lon_deg + e * METRE_LON_DEG, 0.0))
        for n, e in places_m
    )  # fmt: skip


def square(command, half_m, north_m=0.0):
    return corners(
        command, *((north_m + n * half_m, e * half_m) for n, e in ((-1, -1), (-1, 1), (1, 1), (1, -1)))
    )


def fenced(client, *items):
    craft = client.simulator._craft
    craft.obey(TakePlan(PlanKind.FENCE, items))
    return client


def north_m(client):
    return float(client.simulator.truth.position_ned_m[0])


def fly_north(client, seconds, down_m=0.0):
    """Offboard, by speed."""
    stream = lambda: client.setpoint(velocity=(2.0, 0.0, down_m))  # noqa: E731
    client.live(0.2, stream)
    client.command(176, 1, 6)
    client.live(seconds, stream)


@pytest.fixture
def aloft(new_client):
    return new_client().airborne()


@pytest.mark.parametrize(
    ("action", "mode"), [(2, "HOLD"), (3, "RETURN"), (5, "LAND"), (1, "OFFBOARD"), (0, "OFFBOARD")]
)
def test_who_leaves_the_fence_does_what_gf_action_says(aloft, action, mode):
    fenced(aloft, *square(5001, 20.0))
    aloft.simulator._craft.set_parameter("GF_ACTION", action)
    fly_north(aloft, 15.0)
    assert aloft.flight.mode.name == mode
    assert (north_m(aloft) > 26.0) is (mode == "OFFBOARD")


def test_held_at_its_fence_it_may_be_led_out_by_switching_the_mode_again(aloft):
    fenced(aloft, *square(5001, 20.0))
    fly_north(aloft, 15.0)
    assert aloft.flight.mode.name == "HOLD" and aloft.flight.failsafe
    stood_m = north_m(aloft)
    assert 20.0 < stood_m < 26.0
    fly_north(aloft, 4.0)
    assert aloft.flight.mode.name == "OFFBOARD" and north_m(aloft) > stood_m + 5.0


@pytest.mark.parametrize(
    "items",
    [
        square(5002, 8.0, north_m=25.0),
        (PlanItem(5003, 0, (18.0, 0, 0, 0, HOME.lat_deg, HOME.lon_deg, 0.0)),),
        (PlanItem(5004, 0, (6.0, 0, 0, 0, HOME.lat_deg + 25.0 * METRE_LAT_DEG, HOME.lon_deg, 0.0)),),
    ],
)
def test_exclusions_and_circles_are_fences_too(aloft, items):
    fenced(aloft, *items)
    fly_north(aloft, 15.0)
    assert aloft.flight.mode.name == "HOLD" and north_m(aloft) < 25.0


def test_of_two_inclusions_one_is_enough(aloft):
    fenced(aloft, *square(5001, 20.0), *square(5001, 20.0, north_m=30.0))
    fly_north(aloft, 15.0)
    assert aloft.flight.mode.name == "OFFBOARD"


@pytest.mark.parametrize(("name", "down_mps"), [("GF_MAX_HOR_DIST", 0.0), ("GF_MAX_VER_DIST", -2.0)])
def test_distance_and_height_from_home_are_limits_where_they_are_set(aloft, name, down_mps):
    aloft.simulator._craft.set_parameter(name, 18.0)
    fly_north(aloft, 15.0, down_mps)
    assert aloft.flight.mode.name == "HOLD"


def test_gf_action_4_ends_the_flight(aloft):
    fenced(aloft, *square(5001, 20.0))
    aloft.simulator._craft.set_parameter("GF_ACTION", 4)
    fly_north(aloft, 15.0)
    assert not aloft.flight.armed
