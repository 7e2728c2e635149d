"""What ArduCopter does in need: battery, lost place, crash, fence, and the way back that it came."""

import math

import pytest
from copter_client import AUTO, GUIDED, LOITER, mavlink, pick, texts

from sitl.faults import parse_fault

SMARTRTL = 21


def set_parameters(client, **values):
    for name, value in values.items():
        client.say(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, 9))
    client.live(0.1)


def strike(client, spec):
    client.simulator.inject(parse_fault(f"{spec}@{client.now_s:.2f}s"))


def mode(client):
    return client.flight.mode.name


@pytest.mark.parametrize(
    ("settings", "level", "says", "mode_after"),
    [
        ({}, "critical", [], "GUIDED"),
        ({"BATT_LOW_MAH": 1000}, "low", ["Battery 1 is low", "Battery Failsafe"], "GUIDED"),
        (
            {"BATT_LOW_MAH": 1000, "BATT_FS_LOW_ACT": 2},
            "low",
            ["Battery 1 is low", "Battery Failsafe"],
            "RTL",
        ),
        ({"BATT_CRT_MAH": 400, "BATT_FS_CRT_ACT": 1}, "low", [], "GUIDED"),
        ({"BATT_CRT_MAH": 400, "BATT_FS_CRT_ACT": 1}, "critical", ["Battery 1 is critical"], "LAND"),
        ({"BATT_LOW_MAH": 1000, "BATT_FS_LOW_ACT": 3}, "low", ["Battery 1 is low"], "SMARTRTL"),
    ],
)
def test_a_battery_is_told_of_and_answered_as_its_parameters_say(aloft, settings, level, says, mode_after):
    set_parameters(aloft, **settings)
    strike(aloft, f"battery={level}")
    told = texts(aloft.live(2.0))
    for begin in says:
        assert any(text.startswith(begin) for text in told), told
    assert bool(told) is bool(says)
    assert mode(aloft) == mode_after


def test_low_volts_count_after_batt_low_timer(aloft):
    set_parameters(aloft, BATT_LOW_VOLT=20.0, BATT_FS_LOW_ACT=1)
    assert not texts(aloft.live(9.0))
    assert texts(aloft.live(2.0))[0].startswith("Battery 1 is low")
    assert mode(aloft) == "LAND"


def test_on_the_ground_a_failsafe_disarms(copter):
    copter.live(42.0)
    set_parameters(copter, BATT_LOW_MAH=1000, BATT_FS_LOW_ACT=2)
    copter.ask(176, 1, GUIDED)
    assert copter.ask(400, 1) == 0
    strike(copter, "battery=low")
    assert "Battery Failsafe - Disarming" in texts(copter.live(1.0))
    assert not copter.flight.armed


@pytest.mark.parametrize(("action", "mode_after"), [(0, "GUIDED"), (1, "LAND"), (2, "ALT_HOLD")])
def test_without_fixes_the_ekf_failsafe_comes_after_8_s(aloft, action, mode_after):
    set_parameters(aloft, FS_EKF_ACTION=action)
    strike(aloft, "gps_loss")
    aloft.live(7.5)
    assert mode(aloft) == "GUIDED"
    told = texts(aloft.live(1.5))
    assert told[0] == "EKF variance"
    assert told[1:] == ([f"EKF Failsafe: changed to {mode_after} Mode"] if action else [])
    assert mode(aloft) == mode_after


def test_the_ekf_failsafe_clears_but_the_mode_stays_and_critical_ends(aloft):
    strike(aloft, "gps_loss")
    aloft.live(9.0)
    assert pick(aloft.live(1.1), "HEARTBEAT")[0].system_status == mavlink.MAV_STATE_CRITICAL
    aloft.simulator.heal(type(parse_fault("gps_loss@0s")))
    assert "EKF Failsafe Cleared" in texts(aloft.live(3.0))
    assert mode(aloft) == "LAND"
    assert aloft.ask(176, 1, LOITER) == 0


def test_a_mode_that_needs_a_place_is_refused_without_one(aloft):
    strike(aloft, "gps_loss")
    aloft.live(9.0)
    assert aloft.ask(176, 1, GUIDED) == 4


def test_with_fixes_that_repeat_themselves_it_lands_blind_whoever_else_fails_and_disarms(aloft):
    """Such fixes are believed anew every 7 s: RTL would fly by them, and a speed that they tell keeps nobody armed."""
    set_parameters(aloft, FS_GCS_ENABLE=1)
    north, east, down = aloft.here.tolist()
    begin_s = aloft.now_s

    def ahead():
        aloft.target(p=(north + 3.0 * (aloft.now_s - begin_s), east, down), v=(3.0, 0.0, 0.0))

    aloft.live(4.0, ahead)
    strike(aloft, "sensor_stuck=gps")
    told = texts(aloft.until(lambda: mode(aloft) == "LAND", 6.0, ahead))
    assert told == ["EKF variance", "EKF Failsafe: changed to LAND Mode"]
    aloft.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    begun_m = aloft.simulator.truth.position_ned_m[:2].copy()
    told = texts(aloft.until(lambda: not aloft.flight.armed, 60.0))
    assert "GCS Failsafe" in told and "Mode change to RTL failed: requires position" in told
    assert mode(aloft) == "LAND"
    assert math.dist(aloft.simulator.truth.position_ned_m[:2], begun_m) < 20.0


def test_a_vehicle_that_lies_on_its_side_is_disarmed(aloft):
    strike(aloft, "motor=2:0")
    told = texts(aloft.live(12.0))
    assert any(text.startswith("Crash: Disarming: AngErr=") for text in told), told
    assert not aloft.flight.armed


def test_beyond_the_circle_it_returns_and_says_so_by_text_and_fence_status(aloft):
    set_parameters(aloft, FENCE_RADIUS=30, FENCE_ENABLE=1)
    aloft.command(511, 162, 100_000)
    aloft.command(511, 1, 100_000)
    quiet = aloft.live(1.0)
    assert pick(quiet, "FENCE_STATUS")[-1].breach_status == 0
    assert pick(quiet, "SYS_STATUS")[-1].onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_GEOFENCE
    heard = aloft.until(
        lambda: mode(aloft) == "RTL", 20.0, stream=lambda: aloft.target(v=(6.0, 0.0, 0.0), yaw=0.0)
    )
    assert "Circle fence breached" in texts(heard + aloft.live(0.3))
    told = aloft.live(0.3)
    status = pick(told, "FENCE_STATUS")[-1]
    assert (status.breach_status, status.breach_count) == (1, 1)
    assert status.breach_type == mavlink.FENCE_BREACH_BOUNDARY
    assert not pick(told, "SYS_STATUS")[-1].onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_GEOFENCE
    assert math.hypot(*(aloft.here - aloft.flight.home.position_ned_m)[:2]) < 45.0
    assert "Fence breach cleared" in texts(aloft.live(20.0))


@pytest.mark.parametrize(("action", "mode_after"), [(0, "GUIDED"), (2, "LAND"), (4, "BRAKE")])
def test_too_high_is_answered_as_fence_action_says(aloft, action, mode_after):
    set_parameters(aloft, FENCE_ALT_MAX=20, FENCE_ACTION=action, FENCE_ENABLE=1)
    heard = aloft.live(8.0, stream=lambda: aloft.target(v=(0.0, 0.0, -3.0)))
    assert "Max Alt fence breached" in texts(heard)
    assert mode(aloft) == mode_after


def test_places_beyond_the_fence_are_refused_as_targets(aloft):
    set_parameters(aloft, FENCE_RADIUS=30, FENCE_ENABLE=1)
    home = aloft.flight.home.point
    for metres, result in ((100.0, 4), (10.0, 0)):
        aloft.command_int(
            192, 6, -1, 1, x=round((home.lat_deg + metres / 111e3) * 1e7), y=round(home.lon_deg * 1e7), z=10.0
        )
        assert pick(aloft.live(0.2), "COMMAND_ACK")[0].result == result


def test_an_uploaded_polygon_keeps_it_in_and_an_exclusion_keeps_it_out(aloft):
    home = aloft.flight.home.point

    def corner(command, count, north_m, east_m):
        lat_deg = home.lat_deg + north_m / 111_190
        lon_deg = home.lon_deg + east_m / 111_190 / math.cos(math.radians(home.lat_deg))
        return command, count, lat_deg, lon_deg

    square = [corner(5001, 4, n, e) for n, e in ((-60, -60), (-60, 60), (60, 60), (60, -60))]
    for items, way in (([corner(5004, 8.0, 30, 0)], (4.0, 0, 0)), (square, (0, -6.0, 0))):
        aloft.say(mavlink.MAVLink_mission_count_message(1, 1, len(items), 1))
        for seq, (command, p1, lat, lon) in enumerate(items):
            aloft.live(0.02)
            aloft.say(
                mavlink.MAVLink_mission_item_int_message(
                    1, 1, seq, 0, command, 0, 1, p1, 0, 0, 0, round(lat * 1e7), round(lon * 1e7), 0, 1
                )
            )
        assert pick(aloft.live(0.1), "MISSION_ACK")[0].type == 0
        assert aloft.ask(207, 1) == 0
        heard = aloft.until(lambda: mode(aloft) == "RTL", 25.0, stream=lambda: aloft.target(v=way, yaw=0.0))  # noqa: B023
        assert "Polygon fence breached" in texts(heard + aloft.live(0.2))
        assert aloft.ask(207, 0) == 0
        aloft.ask(176, 1, GUIDED)
        aloft.live(2.0)


def test_smartrtl_flies_home_along_the_way_that_it_came(aloft):
    north, east, down = aloft.here.tolist()
    for goal in ((north + 30, east, down), (north + 30, east + 30, down)):
        aloft.target(p=goal)
        aloft.live(14.0)
    assert aloft.ask(176, 1, SMARTRTL) == 0
    heartbeats = pick(aloft.live(1.1), "HEARTBEAT")
    assert heartbeats[-1].custom_mode == SMARTRTL
    worst_m = 0.0
    for _ in range(900):
        aloft.live(0.1)
        n, e, _ = (aloft.here - (north, east, down)).tolist()
        worst_m = max(
            worst_m, min(math.hypot(n - 30, 0) if 0 <= e <= 30 else 99, abs(e) if -2 <= n <= 32 else 99)
        )
        if not aloft.flight.armed:
            break
    assert not aloft.flight.armed
    assert worst_m < 3.0
    assert math.hypot(*(aloft.here - aloft.flight.home.position_ned_m)[:2]) < 1.5


def test_smartrtl_is_refused_on_a_trail_that_had_no_room(aloft):
    set_parameters(aloft, SRTL_POINTS=0)
    aloft.target(v=(4.0, 0.0, 0.0))
    aloft.live(3.0)
    assert aloft.ask(176, 1, SMARTRTL) == 4
    assert mode(aloft) == "GUIDED"


def test_a_lost_ground_station_may_leave_a_mission_going(aloft):
    set_parameters(aloft, FS_GCS_ENABLE=5, FS_OPTIONS=2)
    heartbeat = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
    home = aloft.flight.home.point
    place = (16, 3, (0, 0, 0, 0, home.lat_deg + 3e-3, home.lon_deg, 10))
    assert aloft.upload([place]) == 0
    assert aloft.ask(176, 1, AUTO) == 0
    aloft.say(heartbeat)
    assert "GCS Failsafe - Continuing Auto Mode" in texts(aloft.live(6.0))
    assert mode(aloft) == "AUTO"
    aloft.say(heartbeat)
    assert "GCS Failsafe Cleared" in texts(aloft.live(1.0))
    aloft.ask(176, 1, GUIDED)
    assert "GCS Failsafe" in texts(aloft.live(6.0))
    assert mode(aloft) == "LAND"
