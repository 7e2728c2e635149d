"""PX4's dialect: what a real PX4 v1.17 was seen to do, one test a behaviour."""

import math
from struct import pack, unpack

import pytest

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


def acks(heard, pick):
    return [(ack.command, ack.result) for ack in pick(heard, "COMMAND_ACK")]


def heartbeat_mode(heard, pick):
    beat = pick(heard, "HEARTBEAT")[-1]
    return beat.custom_mode >> 16 & 0xFF, beat.custom_mode >> 24


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


def test_the_parameter_list_begins_with_the_hash_and_is_complete(client, pick):
    client.quiet()
    client.say("PARAM_REQUEST_LIST", target_system=1, target_component=1)
    values = pick(client.live(1.0), "PARAM_VALUE")
    assert (values[0].param_id, values[0].param_index, values[0].param_type) == (b"_HASH_CHECK", 65535, 5)
    assert [value.param_index for value in values[1:]] == list(range(values[0].param_count))
    names = [value.param_id for value in values[1:]]
    assert names == sorted(names)
    assert {b"MPC_XY_P", b"COM_OF_LOSS_T", b"MIS_TAKEOFF_ALT", b"RTL_RETURN_ALT", b"SYS_AUTOSTART"} <= set(
        names
    )


def read(client, pick, name):
    client.say("PARAM_REQUEST_READ", param_index=-1, target_system=1, target_component=1, param_id=name)
    return pick(client.live(0.05), "PARAM_VALUE")


def test_integers_travel_byte_wise_in_the_float(client, pick):
    (value,) = read(client, pick, b"SYS_AUTOSTART")
    assert value.param_type == 6
    assert unpack("<i", pack("<f", value.param_value))[0] == 10040
    client.say(
        "PARAM_SET",
        param_value=unpack("<f", pack("<i", 3))[0],
        target_system=1,
        target_component=1,
        param_id=b"NAV_RCL_ACT",
        param_type=6,
    )
    client.live(0.1)
    assert client.simulator.parameters["NAV_RCL_ACT"] == 3


def test_a_changed_value_is_echoed_twice_and_an_unchanged_one_once(client, pick):
    client.quiet()

    def set_height(value):
        client.say(
            "PARAM_SET",
            param_value=value,
            target_system=1,
            target_component=1,
            param_id=b"MIS_TAKEOFF_ALT",
            param_type=9,
        )
        return [v.param_value for v in pick(client.live(0.1), "PARAM_VALUE")]

    assert set_height(7.5) == [7.5, 7.5]
    assert set_height(7.5) == [7.5]


def test_unknown_names_and_wrong_types_are_met_with_silence(client, pick):
    assert read(client, pick, b"NO_SUCH_THING") == []
    client.say(
        "PARAM_SET",
        param_value=1.0,
        target_system=1,
        target_component=1,
        param_id=b"MIS_TAKEOFF_ALT",
        param_type=6,
    )
    client.say(
        "PARAM_SET", param_value=1.0, target_system=1, target_component=1, param_id=b"FOO", param_type=9
    )
    assert pick(client.live(0.1), "PARAM_VALUE") == []
    assert client.simulator.parameters["MIS_TAKEOFF_ALT"] == 2.5


def test_out_of_range_values_are_accepted_but_not_what_is_no_number(client, pick):
    for value in (math.nan, math.inf, 1e9):
        client.say(
            "PARAM_SET",
            param_value=value,
            target_system=1,
            target_component=1,
            param_id=b"RTL_RETURN_ALT",
            param_type=9,
        )
    client.live(0.1)
    assert client.simulator.parameters["RTL_RETURN_ALT"] == 1e9


def test_arm_and_take_off_go_through_the_states_that_px4_shows(client, pick):
    client.until(lambda: client.flight.ready, 10.0)
    client.command(400, 1.0, 0.0)
    client.command(22)
    assert acks(client.live(0.05), pick) == [(400, 0), (22, 0)]
    modes, landed = [], []
    for message in client.live(20.0):
        if type(message).__name__ == "HEARTBEAT":
            modes.append((message.custom_mode >> 16 & 0xFF, message.custom_mode >> 24))
            assert message.base_mode == 157
        elif type(message).__name__ == "EXTENDED_SYS_STATE":
            landed.append(message.landed_state)
    assert list(dict.fromkeys(modes)) == [(4, 2), (4, 3)]
    assert list(dict.fromkeys(landed)) == [1, 3, 2]
    assert client.simulator.truth.position_ned_m[2] == pytest.approx(-2.5, abs=0.5)


def test_do_set_mode_gives_two_acks_and_the_second_is_the_verdict(client, pick):
    client.airborne()
    client.command(176, 1, 6, 0)
    client.heard.clear()
    client.live(0.1)
    told = [(at_us, m.result) for at_us, _, m in client.heard if type(m).__name__ == "COMMAND_ACK"]
    assert [result for _, result in told] == [0, 1]
    assert told[1][0] - told[0][0] == 10_000
    assert client.flight.mode is Mode.HOLD


def test_an_unknown_mode_is_acknowledged_and_does_nothing(client, pick):
    client.command(176, 1, 99, 7)
    assert {result for _, result in acks(client.live(0.1), pick)} == {0}
    assert client.flight.mode is Mode.HOLD


def test_set_mode_gives_one_ack(client, pick):
    client.live(3.0)
    client.say("SET_MODE", custom_mode=3 << 16, target_system=1, base_mode=1)
    heard = client.live(1.1)
    assert acks(heard, pick) == [(176, 0)]
    assert heartbeat_mode(heard, pick) == (3, 0)


def test_disarming_in_the_air_is_refused_and_forced_disarming_works(client, pick):
    client.airborne(5.0)
    client.command(400, 0.0, 0.0)
    assert acks(client.live(0.1), pick) == [(400, 1)]
    client.command(400, 0.0, 21196.0)
    assert acks(client.live(0.1), pick) == [(400, 0)]
    assert not client.flight.armed


def test_land_comes_down_and_disarms(client, pick):
    client.airborne(5.0)
    client.command(21)
    heard = client.live(1.1)
    assert acks(heard, pick) == [(21, 0)]
    assert heartbeat_mode(heard, pick) == (4, 6)
    client.until(lambda: not client.flight.armed, 30.0)
    assert client.simulator.truth.position_ned_m[2] == pytest.approx(0.0, abs=0.1)


def test_offboard_right_after_the_first_setpoint_is_accepted(client, pick):
    client.airborne()
    here = client.simulator.report.estimate.position_ned_m.tolist()
    client.setpoint(here)
    client.command(176, 1, 6)
    assert acks(client.live(0.1), pick) == [(176, 0), (176, 0)]
    assert client.flight.mode is Mode.OFFBOARD


@pytest.mark.parametrize(
    "bad",
    [
        {"position": (0.0, 0.0, -10.0), "frame": 7},
        {"position": (0.0, 0.0, -10.0), "system": 2},
        {"position": (0.0, 0.0, -10.0), "component": 42},
        {"mask": 0xFFF},
        {"mask": 0x1FF},  # yaw alone
        {"position": (math.nan,) * 3},
        {"position": (0.0, 0.0, -10.0), "mask": 0x238},  # force
        {"position": (1.0, 1.0, 1.0), "frame": 8},  # a position in body axes
        {"velocity": (1.0, 0.0, 0.0), "mask": 0x1E7, "frame": 8},  # one body axis ignored
    ],
)
def test_what_px4_does_not_take_for_a_setpoint_is_no_stream(client, bad):
    client.airborne().live(0.5, lambda: client.setpoint(**bad))
    client.command(176, 1, 6)
    client.live(0.1, lambda: client.setpoint(**bad))
    assert client.flight.mode is Mode.HOLD


@pytest.mark.parametrize(
    "good",
    [
        {"position": (0.0, 0.0, -10.0), "system": 0, "component": 0},
        {"velocity": (0.0, 0.0, 0.0), "frame": 8},
        {"position": (0.0, 0.0, -10.0), "velocity": (0.0,) * 3, "mask": 0x9C0},
    ],
)
def test_what_px4_takes_for_a_setpoint_is_a_stream(client, good):
    client.airborne().live(0.5, lambda: client.setpoint(**good))
    client.command(176, 1, 6)
    client.live(0.1, lambda: client.setpoint(**good))
    assert client.flight.mode is Mode.OFFBOARD


def heading_deg(client):
    w, x, y, z = client.simulator.truth.q_ned_frd
    return math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def test_without_a_yaw_the_nose_stays_where_it_is_and_a_yaw_rate_alone_turns_it(client):
    client.airborne()
    here = tuple(client.simulator.report.estimate.position_ned_m.tolist())
    client.live(0.5, lambda: client.setpoint(here, yaw=1.0))
    client.command(176, 1, 6)
    client.live(5.0, lambda: client.setpoint(here, yaw=1.0))
    client.live(5.0, lambda: client.setpoint((here[0] + 9.0, *here[1:]), mask=0x400 | 0x800 | 0x1F8))
    held_deg = heading_deg(client)
    assert held_deg == pytest.approx(
        math.degrees(1.0), abs=6.0
    )  # along the way were 0; nothing brings it back
    assert client.simulator.truth.position_ned_m[0] > 6.0
    client.live(3.0, lambda: client.setpoint(here, mask=0x400 | 0x1F8, yaw_rate=math.radians(20.0)))
    assert 35.0 < heading_deg(client) - held_deg < 65.0


def test_a_velocity_in_body_axes_flies_along_the_nose(client):
    client.airborne()
    here = tuple(client.simulator.report.estimate.position_ned_m.tolist())
    client.live(0.5, lambda: client.setpoint(here, yaw=math.pi / 2))
    client.command(176, 1, 6)
    client.live(5.0, lambda: client.setpoint(here, yaw=math.pi / 2))
    client.live(5.0, lambda: client.setpoint(velocity=(2.0, 0.0, 0.0), frame=8, mask=0x407 | 0x1C0 | 0x800))
    assert client.simulator.truth.velocity_ned_mps == pytest.approx([0.0, 2.0, 0.0], abs=0.25)


def fly_north(client, speed_mps=3.0):
    """OFFBOARD along north, by position and velocity. Returns the stream."""
    client.airborne(15.0)
    north, east, down = client.simulator.report.estimate.position_ned_m.tolist()
    begin_us = client.now_us

    def stream():
        s = 1e-6 * (client.now_us - begin_us)
        client.setpoint((north + speed_mps * s, east, down), (speed_mps, 0.0, 0.0))

    client.live(0.5, stream)
    client.command(176, 1, 6)
    client.live(6.0, stream)
    assert client.flight.mode is Mode.OFFBOARD
    return stream


def test_lost_setpoints_are_chased_for_a_second_then_it_says_so_and_returns(client, pick):
    client.heartbeat()
    fly_north(client)
    begin_m = client.simulator.truth.position_ned_m[0]
    client.live(1.0)
    assert client.simulator.truth.position_ned_m[0] - begin_m == pytest.approx(2.7, abs=0.5)
    heard = client.live(1.2)
    assert b"Failsafe activated" in [text.text for text in pick(heard, "STATUSTEXT")]
    assert heartbeat_mode(heard, pick) == (4, 5)
    assert pick(heard, "HEARTBEAT")[-1].system_status == 5
    client.until(lambda: not client.flight.armed, 90.0)
    assert client.simulator.truth.position_ned_m == pytest.approx([0.0, 0.0, 0.0], abs=0.5)


def test_resuming_the_stream_in_flight_brings_it_back_to_offboard_by_itself(client):
    stream = fly_north(client)
    client.live(2.0)
    assert client.flight.mode is Mode.RETURN
    client.live(0.1, stream)
    assert client.flight.mode is Mode.OFFBOARD


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


def test_run_faster_than_real_time_it_waits_longer_for_setpoints(new_client):
    """PX4 multiplies COM_OF_LOSS_T by its speed factor."""
    client = new_client(loss_scale=4.0)
    stream = fly_north(client)
    client.live(3.8)
    assert client.flight.mode is Mode.OFFBOARD
    client.live(0.5)
    assert client.flight.mode is Mode.RETURN
    client.live(0.1, stream)
    assert client.flight.mode is Mode.OFFBOARD


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


def test_reposition_by_command_int_goes_there(client, pick):
    client.airborne()
    home = client.flight.home.point
    client.say(
        "COMMAND_INT",
        param1=-1.0,
        param2=1.0,
        param3=0.0,
        param4=math.nan,
        x=round((home.lat_deg + 1e-4) * 1e7),
        y=round(home.lon_deg * 1e7),
        z=home.alt_amsl_m + 12.0,
        command=192,
        target_system=1,
        target_component=1,
        frame=0,
        current=0,
        autocontinue=0,
    )
    assert acks(client.live(0.1), pick) == [(192, 0)]
    client.live(15.0)
    assert client.simulator.truth.position_ned_m == pytest.approx([11.07, 0.0, -12.0], abs=0.5)


def test_attitude_target_comes_ten_times_a_second_while_armed(client, pick):
    assert pick(client.live(3.0), "ATTITUDE_TARGET") == []
    client.airborne()
    told = pick(client.live(2.0), "ATTITUDE_TARGET")
    assert len(told) == pytest.approx(20, abs=1)
    assert told[-1].q[0] ** 2 + told[-1].q[3] ** 2 == pytest.approx(1.0, abs=0.01)
    assert told[-1].thrust == pytest.approx(client.simulator.report.instruments.thrust, abs=0.05)


@pytest.mark.parametrize("time_boot_ms", [0, 1, 2**32 - 1])
def test_the_time_in_a_setpoint_is_ignored(client, time_boot_ms):
    client.airborne()

    def stream():
        client.setpoint((3.0, 0.0, -10.0), time_boot_ms=time_boot_ms)

    client.live(0.5, stream)
    client.command(176, 1, 6)
    client.live(6.0, stream)
    assert client.flight.mode is Mode.OFFBOARD
    assert client.simulator.truth.position_ned_m == pytest.approx([3.0, 0.0, -10.0], abs=0.5)


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


def test_a_companion_that_falls_silent_but_for_its_setpoints_changes_nothing(client):
    client.airborne()
    client.heartbeat(kind=18)
    here = tuple(client.simulator.report.estimate.position_ned_m.tolist())

    def stream():
        client.setpoint(here)

    client.live(0.5, stream)
    client.command(176, 1, 6)
    client.live(8.0, stream)
    assert client.flight.mode is Mode.OFFBOARD
    assert not client.flight.failsafe


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


def test_a_mode_that_wants_a_stick_or_a_target_is_acknowledged_then_refused_with_a_text(client, pick):
    client.heartbeat()
    client.live(0.1)
    client.command(176, 1, 4, 8)
    heard = client.live(0.1)
    assert acks(heard, pick) == [(176, 0), (176, 1)]
    text = b"".join(bytes(part.text) for part in pick(heard, "STATUSTEXT"))
    assert text == b"Switching to mode 'Follow Target' is currently not available"
    assert client.flight.mode is Mode.HOLD


def test_a_mission_is_not_started_without_one_and_the_text_says_why(client, pick):
    client.heartbeat()
    client.until(lambda: client.flight.ready, 10.0)
    client.command(300, 0, 0)
    heard = client.live(0.1)
    assert acks(heard, pick) == [(300, 2)]
    assert bytes(pick(heard, "STATUSTEXT")[-1].text) == b"Mission start denied! No valid mission"
    assert not client.flight.armed


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


def test_disarmed_any_mode_is_taken_and_mission_mode_then_does_not_arm_without_a_mission(client, pick):
    client.heartbeat()
    client.until(lambda: client.flight.ready, 10.0)
    client.command(176, 1, 4, 4)
    assert acks(client.live(0.1), pick) == [(176, 0), (176, 0)]
    assert client.flight.mode is Mode.MISSION
    client.command(400, 1.0, 0.0)
    heard = client.live(0.1)
    assert acks(heard, pick) == [(400, 1)]
    assert bytes(pick(heard, "STATUSTEXT")[-1].text) == b"Arming denied: No valid mission available"
