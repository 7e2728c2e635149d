"""PX4's geofence: what GF_ACTION does in flight, how one gets out again, and which orders it forbids."""

import math

import pytest
from px4_client import HOME

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


def said(client):
    """What it has said since the last call, in whole lines, but for the ground station, which sent one heartbeat."""
    client.live(0.05)
    lines = []
    for _, _, message in client.heard:
        if type(message).__name__ == "STATUSTEXT":
            text = message.text if isinstance(message.text, str) else message.text.decode()
            if message.chunk_seq:
                lines[-1] += text
            else:
                lines.append(text)
    client.heard.clear()
    return [line for line in lines if not line.startswith("Connection")]


def go(client, north):
    """DO_REPOSITION to so many metres north of home."""
    lat_deg = HOME.lat_deg + north * METRE_LAT_DEG
    client.command(192, -1, 1, 0, math.nan, lat_deg, HOME.lon_deg, HOME.alt_amsl_m + 10.0)
    client.live(0.1)


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
    client = new_client().airborne()
    client.heartbeat()
    client.live(0.1)
    client.heard.clear()
    return client


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


def test_of_two_inclusions_both_hold(aloft):
    """As in PX4 since 1.15, whatever its older manuals say: its issue 27099."""
    fenced(aloft, *square(5001, 40.0), *square(5001, 20.0))
    fly_north(aloft, 15.0)
    assert aloft.flight.mode.name == "HOLD" and north_m(aloft) < 26.0


def test_an_area_without_home_is_said_and_does_not_hold(aloft):
    fenced(aloft, *square(5001, 20.0, north_m=60.0), *square(5002, 8.0, north_m=2.0), *square(5001, 90.0))
    told = said(aloft)
    assert told.count("Geofence invalid, doesn't contain Home position") == 2
    fly_north(aloft, 15.0)
    assert aloft.flight.mode.name == "OFFBOARD" and len(aloft.flight.plans.fence) == 12


def test_an_area_without_the_vehicle_in_flight_is_said_and_does_not_hold(aloft):
    fly_north(aloft, 15.0)
    fenced(aloft, *square(5001, 20.0))
    assert said(aloft) == ["Geofence invalid, doesn't contain current vehicle position"]
    aloft.live(1.0, lambda: aloft.setpoint(velocity=(2.0, 0.0, 0.0)))
    assert aloft.flight.mode.name == "OFFBOARD"


def test_held_at_its_fence_it_comes_back_to_where_it_left_it(aloft):
    fenced(aloft, *square(5001, 20.0))
    farthest_m = 0.0
    stream = lambda: aloft.setpoint(velocity=(4.0, 0.0, 0.0))  # noqa: E731
    aloft.live(0.2, stream)
    aloft.command(176, 1, 6)
    for _ in range(250):
        aloft.live(0.1, stream)
        farthest_m = max(farthest_m, north_m(aloft))
    assert said(aloft) == ["Geofence: approaching or outside geofence", "Failsafe activated"]
    assert aloft.flight.mode.name == "HOLD" and 24.0 < farthest_m < 26.0
    assert north_m(aloft) == pytest.approx(20.2, abs=0.4)


def test_a_way_through_a_forbidden_area_ends_at_its_edge(aloft):
    """Held by a failsafe where it was already in Hold."""
    fenced(aloft, *square(5002, 6.0, north_m=25.0))
    go(aloft, 50.0)
    aloft.live(25.0)
    assert aloft.flight.failsafe and north_m(aloft) == pytest.approx(19.2, abs=0.5)


def test_who_is_sent_out_of_the_fence_stays(aloft):
    fenced(aloft, *square(5001, 20.0))
    go(aloft, 15.0)
    go(aloft, 50.0)
    aloft.live(0.1)
    assert said(aloft) == ["Reposition is outside geofence"]
    aloft.live(12.0)
    assert not aloft.flight.failsafe and north_m(aloft) == pytest.approx(15.0, abs=1.0)
    aloft.simulator._craft.set_parameter("GF_ACTION", 1)
    go(aloft, 50.0)
    aloft.live(12.0)
    assert north_m(aloft) > 30.0
    assert said(aloft) == ["Geofence: approaching or outside geofence"]


def waypoint(north, height_m=10.0):
    lat_deg = HOME.lat_deg + north * METRE_LAT_DEG
    return PlanItem(16, 3, (0.0, 0.0, 0.0, math.nan, lat_deg, HOME.lon_deg, height_m))


def mission(client, *items):
    client.simulator._craft.obey(TakePlan(PlanKind.MISSION, items))


def test_a_mission_out_of_the_fence_is_said_and_cannot_be_started(aloft, pick):
    fenced(aloft, *square(5001, 20.0))
    mission(aloft, waypoint(10.0), PlanItem(178, 2, (1.0, 5.0, -1.0, 0, 0, 0, 0)), waypoint(30.0))
    assert said(aloft) == ["Geofence violation for waypoint 3"]
    aloft.command(300, 0, 0)
    assert [ack.result for ack in pick(aloft.live(0.1), "COMMAND_ACK")] == [2]
    assert said(aloft) == ["Mission start denied! No valid mission"]
    aloft.command(176, 1, 4, 4)
    assert [ack.result for ack in pick(aloft.live(0.1), "COMMAND_ACK")] == [0, 1]
    fenced(aloft)
    aloft.command(300, 0, 0)
    aloft.live(0.1)
    assert aloft.flight.mode.name == "MISSION"


def test_a_fence_that_a_mission_under_way_breaks_ends_it(aloft):
    mission(aloft, waypoint(10.0), waypoint(30.0))
    aloft.command(300, 0, 0)
    aloft.live(1.0)
    assert aloft.flight.mode.name == "MISSION"
    said(aloft)
    fenced(aloft, *square(5001, 20.0))
    aloft.live(0.1)
    assert said(aloft) == ["Geofence violation for waypoint 2"]
    assert aloft.flight.mode.name == "HOLD"


def test_a_mission_higher_than_gf_max_ver_dist_is_refused(aloft):
    aloft.simulator._craft.set_parameter("GF_MAX_VER_DIST", 18.0)
    mission(aloft, waypoint(10.0, 17.0), waypoint(10.0, 19.0))
    assert said(aloft) == ["Geofence violation for waypoint 2"]


def test_outside_its_fence_it_does_not_arm(new_client, pick):
    client = new_client()
    client.heartbeat()
    client.until(lambda: client.flight.ready, 10.0)
    fenced(client, *square(5001, 20.0))
    client.command(179, 0, 0, 0, 0, HOME.lat_deg + 30.0 * METRE_LAT_DEG, HOME.lon_deg, HOME.alt_amsl_m)
    client.simulator._craft.set_parameter("GF_MAX_HOR_DIST", 20.0)
    client.live(0.1)
    said(client)
    client.command(400, 1, 0)
    assert pick(client.live(0.1), "COMMAND_ACK")[0].result == 1
    assert said(client) == [
        "Geofence: exceeding maximum distance to Home",
        "Arming denied: Resolve system health failures first",
    ]
    client.simulator._craft.set_parameter("GF_ACTION", 0)
    client.command(400, 1, 0)
    client.live(0.1)
    assert client.flight.armed


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
