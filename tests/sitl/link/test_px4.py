"""PX4's dialect, what it tells and answers: what a real PX4 v1.17 was seen to do, one test a behaviour."""

import math

import pytest
from px4_answers import acks

from sitl.airframe import load_airframe
from sitl.orders import Mode

TELEMETRY_RATES_HZ = {
    "ATTITUDE": 100,
    "ATTITUDE_QUATERNION": 50,
    "HIGHRES_IMU": 50,
    "GLOBAL_POSITION_INT": 50,
    "LOCAL_POSITION_NED": 30,
    "ODOMETRY": 30,
    "ALTITUDE": 10,
    "DISTANCE_SENSOR": 10,
    "SERVO_OUTPUT_RAW": 10,
    "VFR_HUD": 10,
    "TIMESYNC": 10,
    "GPS_RAW_INT": 8,
    "EXTENDED_SYS_STATE": 5,
    "SYS_STATUS": 5,
    "HEARTBEAT": 1,
    "ESTIMATOR_STATUS": 1,
    "MISSION_CURRENT": 1,
    "PING": 1,
    "SCALED_PRESSURE": 1,
    "SYSTEM_TIME": 1,
    "BATTERY_STATUS": 0.5,
    "CURRENT_MODE": 0.5,
    "HOME_POSITION": 0.5,
    "VIBRATION": 0.5,
}


def test_telemetry_comes_unasked_at_px4s_rates(client, pick):
    client.live(6.0)
    heard = client.live(10.0)
    for name, rate_hz in TELEMETRY_RATES_HZ.items():
        assert len(pick(heard, name)) == pytest.approx(10 * rate_hz, abs=1), name


def test_the_offboard_link_carries_407_messages_and_24_kb_a_second_in_flight_mavlink_2_from_the_first_byte(
    client,
):
    simulator, sent = client.simulator, b""
    while not sent:
        client.now_us += 10_000
        (sent,) = simulator.exchange(client.now_us, (b"",))
    assert sent[0] == 0xFD
    client.airborne(4.0)
    here = tuple(simulator.report.estimate.position_ned_m.tolist())

    def stream():
        client.setpoint(here)

    client.live(0.5, stream)
    client.command(176, 1, 6)
    client.live(0.5, stream)
    messages_n = bytes_n = 0
    for _ in range(400):
        client.now_us += 10_000
        client.setpoint(here)
        received, client.outbox = tuple(client.outbox), [b""]
        (sent,) = simulator.exchange(client.now_us, received)
        bytes_n += len(sent)
        messages_n += len(client.codecs[0].decode(sent))
    assert messages_n / 4 == pytest.approx(407, abs=4)
    assert bytes_n / 4 == pytest.approx(24_000, rel=0.05)


def test_the_first_heartbeat_says_px4_quadrotor_standby_in_hold(client, pick):
    beat = pick(client.live(2.0), "HEARTBEAT")[0]
    assert (beat.type, beat.autopilot, beat.base_mode, beat.system_status) == (2, 12, 29, 3)
    assert (beat.custom_mode >> 16, beat.custom_mode >> 24) == (4 | 3 << 8, 3)


def test_system_is_instance_plus_one(new_client):
    client = new_client(instance=4)
    client.live(0.1)
    data = client.simulator.exchange(200_000, (b"",))[0]
    assert {item.system for item in client.codecs[0].decode(data)} == {5}


def test_the_health_bits_are_all_set_once_it_is_ready(client, pick):
    client.until(lambda: client.flight.ready, 10.0)
    status = pick(client.live(1.0), "SYS_STATUS")[-1]
    needed = 1 | 2 | 4 | 8 | 32 | 1 << 28  # gyro, accelerometer, magnetometer, barometer, GPS, pre-arm
    for field in ("present", "enabled", "health"):
        assert getattr(status, f"onboard_control_sensors_{field}") & needed == needed


def test_the_origin_is_told_on_change_only_and_on_request(client, pick):
    origins = pick(client.live(10.0), "GPS_GLOBAL_ORIGIN")
    assert len(origins) == 1
    client.command(512, 49)
    heard = client.live(0.1)
    assert pick(heard, "GPS_GLOBAL_ORIGIN")[0][:3] == origins[0][:3]


def test_autopilot_version_comes_before_its_ack(client, pick):
    client.command(512, 148)
    names = [type(m).__name__ for m in client.live(0.02)]
    assert names.index("AUTOPILOT_VERSION") < names.index("COMMAND_ACK")
    version = pick([m for _, _, m in client.heard], "AUTOPILOT_VERSION")[0]
    assert version.capabilities == 0xE8FF
    assert version.flight_sw_version >> 16 == 0x0111


def test_a_request_for_an_unknown_message_is_denied(client, pick):
    client.command(512, 12345)
    assert acks(client.live(0.1), pick) == [(512, 2)]


def test_an_unknown_command_is_unsupported(client, pick):
    client.command(31999)
    assert acks(client.live(0.1), pick) == [(31999, 3)]


@pytest.mark.parametrize(("system", "component"), [(0, 0), (1, 42), (2, 1), (0, 1)])
def test_commands_to_others_or_to_everybody_are_ignored(client, pick, system, component):
    client.command(400, 1.0, 21196.0, system=system, component=component)
    assert acks(client.live(0.1), pick) == []
    assert not client.flight.armed


def test_message_intervals_are_set_switched_off_and_reset(client, pick):
    client.command(511, 32, 20_000)
    client.command(511, 30, -1)
    assert acks(client.live(5.0), pick) == [(511, 0), (511, 0)]
    heard = client.live(2.0)
    assert len(pick(heard, "LOCAL_POSITION_NED")) == 100
    assert pick(heard, "ATTITUDE") == []
    client.command(510, 32)
    assert pick(client.live(0.1), "MESSAGE_INTERVAL") == [(20_000, 32)]
    client.command(511, 32, 0)
    client.command(511, 30, 0)
    client.live(0.1)
    heard = client.live(2.0)
    assert len(pick(heard, "LOCAL_POSITION_NED")) == 60
    assert len(pick(heard, "ATTITUDE")) == 200


@pytest.mark.parametrize("number", [375, 65, 115, 116])
def test_an_interval_of_px4s_streams_that_have_nothing_to_say_is_taken(client, pick, number):
    """MAVSDK's set_rate_actuator_output_status() and the like raise nothing on a PX4."""
    client.command(511, number, 100_000)
    heard = client.live(0.5)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [0]
    assert not [message for message in heard if number == type(message).ID]


def test_the_scaled_imu_weighs_a_standing_vehicle_at_one_g(client, pick):
    client.command(511, 26, 100_000)
    imu = pick(client.live(0.5), "SCALED_IMU")[-1]
    assert (imu.xacc, imu.yacc, imu.zacc) == pytest.approx((0, 0, -1000), abs=40)


@pytest.mark.parametrize("interval_us", [-1, math.nan, math.inf, 2e6, 3e38])
def test_the_heartbeat_is_never_switched_off(client, pick, interval_us):
    client.command(511, 0, interval_us)
    assert acks(client.live(0.1), pick) == [(511, 4)]
    assert len(pick(client.live(5.0), "HEARTBEAT")) == 5


def test_the_heartbeat_comes_oftener_if_asked_and_goes_back_to_its_default(client, pick):
    client.command(511, 0, 500_000)
    assert acks(client.live(0.1), pick) == [(511, 0)]
    assert len(pick(client.live(4.0), "HEARTBEAT")) == 8
    client.command(511, 0, 0)
    assert acks(client.live(0.1), pick) == [(511, 0)]
    assert len(pick(client.live(4.0), "HEARTBEAT")) == 4


def test_timesync_and_ping_are_answered(client, pick):
    client.live(1.0)
    client.say("TIMESYNC", tc1=0, ts1=77)
    client.say("PING", time_usec=5, seq=6, target_system=0, target_component=0)
    heard = client.live(0.01)
    assert next(m for m in pick(heard, "TIMESYNC") if m.ts1 == 77).tc1 == pytest.approx(1e9, abs=2e7)
    assert (5, 6, 255, 190) in pick(heard, "PING")


def test_texts_go_to_links_that_hear_a_ground_station_only(new_client, pick):
    client = new_client(links=2)
    client.until(lambda: client.flight.ready, 10.0)
    client.heartbeat(link=0, kind=18)
    client.heartbeat(link=1, kind=6)
    client.live(0.1)
    client.heard.clear()
    client.command(400, 1.0, 0.0)
    client.live(0.1)
    assert [link for _, link, m in client.heard if type(m).__name__ == "STATUSTEXT"] == [1]


def test_a_ground_station_that_falls_silent_is_told_of_and_nothing_else(client, pick):
    client.airborne()
    client.heartbeat()
    assert pick(client.live(9.9), "STATUSTEXT") == []
    told = [bytes(text.text) for text in pick(client.live(20.0), "STATUSTEXT")]
    assert told == [b"Connection to ground station lost"]
    assert client.flight.mode is Mode.HOLD and not client.flight.failsafe
    client.heartbeat()
    told = [bytes(text.text) for text in pick(client.live(11.0), "STATUSTEXT")]
    assert told == [b"Connection to ground station lost"]


def test_long_texts_are_split_at_fifty_characters(client, pick):
    client.heartbeat()
    client.airborne(3.0)
    client.command(176, 1, 6)
    parts = pick(client.live(0.1), "STATUSTEXT")
    assert [part.chunk_seq for part in parts] == [0, 1]
    assert len(parts[0].text) == 50
    assert parts[0].id == parts[1].id != 0


def test_the_two_links_have_their_own_rates(new_client, pick):
    client = new_client(links=2)
    client.live(3.0)
    client.command(511, 32, -1, link=1)
    client.live(0.1)
    client.heard.clear()
    client.live(2.0)
    local = [link for _, link, m in client.heard if type(m).__name__ == "LOCAL_POSITION_NED"]
    assert local.count(0) == 60
    assert local.count(1) == 0


def test_a_ground_stations_heartbeat_is_passed_on_to_the_offboard_link_but_not_back(new_client):
    client = new_client(links=2)
    client.heartbeat(link=1, kind=6)
    client.heartbeat(link=0, kind=18)
    client.live(0.05)
    foreign = [
        (link, m.type) for _, link, m in client.heard if type(m).__name__ == "HEARTBEAT" and m.autopilot == 8
    ]
    assert foreign == [(0, 6)]


def test_attitude_target_comes_ten_times_a_second_while_armed(client, pick):
    assert pick(client.live(3.0), "ATTITUDE_TARGET") == []
    client.airborne()
    told = pick(client.live(2.0), "ATTITUDE_TARGET")
    assert len(told) == pytest.approx(20, abs=1)
    assert told[-1].q[0] ** 2 + told[-1].q[3] ** 2 == pytest.approx(1.0, abs=0.01)
    assert told[-1].thrust == pytest.approx(client.simulator.report.instruments.thrust, abs=0.05)


def test_position_target_masks_nothing_whatever_the_setpoint_masks(client, pick):
    client.airborne()
    north_m, east_m, down_m = client.simulator.report.estimate.position_ned_m.tolist()

    def stream():
        client.setpoint((north_m + 50.0, east_m, down_m))

    client.live(0.5, stream)
    client.command(176, 1, 6)
    told = pick(client.live(3.0, stream), "POSITION_TARGET_LOCAL_NED")[-1]
    assert told.type_mask == 0
    assert told.x == pytest.approx(north_m + 50.0, abs=0.01)


def test_position_target_is_no_echo_but_holds_the_cascades_corrections(client, pick):
    """Ten metres behind its target and told to stand there: it wants to go north, by its own correction."""
    client.airborne()
    north_m, east_m, down_m = client.simulator.report.estimate.position_ned_m.tolist()

    def stream():
        client.setpoint((north_m + 10.0, east_m, down_m), (0.0, 0.0, 0.0))

    client.live(0.5, stream)
    client.command(176, 1, 6)
    told = pick(client.live(0.3, stream), "POSITION_TARGET_LOCAL_NED")[-1]
    assert told.vx == pytest.approx(0.95 * 10.0, abs=1.0)  # MPC_XY_P
    assert told.afx > 1.0
    assert told.afz == told.afz


def test_the_range_finder_reads_the_height_along_the_belly(client, pick):
    leg_m = load_airframe("x500").ground.leg_height_m
    standing = pick(client.live(1.0), "DISTANCE_SENSOR")[-1]
    assert standing.current_distance == pytest.approx(100.0 * leg_m, abs=1.0)
    client.airborne()
    told = pick(client.live(1.0), "DISTANCE_SENSOR")
    assert len(told) == 10
    height_m = leg_m - client.simulator.truth.position_ned_m[2]
    assert told[-1].current_distance == pytest.approx(100.0 * height_m, abs=5.0)


def test_vibration_tells_the_imus_noise(client, pick):
    """The mean length of the difference of two samples' noise in three axes: √2 σ · √(8/π)."""
    client.airborne()
    told = pick(client.live(4.0), "VIBRATION")[-1]
    accel_mps2, gyro_radps = 7e-3 * 200.0**0.5, 2e-4 * 200.0**0.5
    spread = 2.0**0.5 * (8.0 / math.pi) ** 0.5
    assert told.vibration_z == pytest.approx(spread * accel_mps2, rel=0.3)
    assert told.vibration_y == pytest.approx(spread * gyro_radps, rel=0.5)
    assert told.clipping_0 == 0


def test_it_has_no_logs_and_says_so(client, pick):
    client.say("LOG_REQUEST_LIST", target_system=1, target_component=1, start=0, end=0xFFFF)
    (entry,) = pick(client.live(0.1), "LOG_ENTRY")
    assert entry.num_logs == 0
    client.say("LOG_REQUEST_LIST", target_system=7, target_component=1, start=0, end=0xFFFF)
    assert not pick(client.live(0.1), "LOG_ENTRY")


def test_it_has_no_events_and_says_so(client, pick):
    heard = client.live(6.5)
    told = pick(heard, "CURRENT_EVENT_SEQUENCE")
    assert [(message.sequence, message.flags) for message in told] == [(65525, 1)] * 3
    client.say("REQUEST_EVENT", first_sequence=3, last_sequence=900, target_system=1, target_component=1)
    (answer,) = pick(client.live(0.1), "RESPONSE_EVENT_ERROR")
    assert answer == (3, 65525, 255, 190, 0)


@pytest.mark.parametrize(("request_", "result"), [((246, 0), 0), ((246, 1), 2), ((187, 0.5), 0)])
def test_it_does_not_reboot_but_takes_actuators_that_it_has_not(client, pick, request_, result):
    client.command(*request_)
    assert acks(client.live(0.1), pick) == [(request_[0], result)]


def test_the_origin_is_moved_on_the_ground_told_at_once_and_the_flight_is_as_before(client, pick):
    """Home stays where it is on Earth; armed, it is only told."""
    client.until(lambda: client.flight.ready, 10.0)
    client.live(1.0)
    origin, home = client.simulator.report.origin, client.flight.home.point
    wanted = {
        "latitude": round(origin.lat_deg * 1e7) + 9000,  # 100 m north
        "longitude": round(origin.lon_deg * 1e7),
        "altitude": round(origin.alt_amsl_m * 1e3) + 7000,
    }
    client.say("SET_GPS_GLOBAL_ORIGIN", **wanted, target_system=1, time_usec=0)
    (told,) = pick(client.live(0.02), "GPS_GLOBAL_ORIGIN")
    assert (told.latitude, told.longitude, told.altitude) == tuple(wanted.values())
    position = client.simulator.report.estimate.position_ned_m
    assert (position[0], position[2]) == (pytest.approx(-100.0, abs=1.0), pytest.approx(7.0, abs=0.5))
    moved = client.flight.home
    assert moved.point == home and moved.position_ned_m[2] == pytest.approx(7.0, abs=0.5)

    client.airborne(5.0)
    north_m, east_m, down_m = client.simulator.truth.position_ned_m
    assert math.hypot(north_m, east_m) < 1.0 and down_m == pytest.approx(-12.0, abs=0.7)
    client.say("SET_GPS_GLOBAL_ORIGIN", **wanted | {"latitude": 0}, target_system=1, time_usec=0)
    (told,) = pick(client.live(0.02), "GPS_GLOBAL_ORIGIN")
    assert told.latitude == wanted["latitude"]
