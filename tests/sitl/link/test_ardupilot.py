"""ArduCopter's dialect: what a real ArduCopter 4.6.3 was seen to do, one test a behaviour."""

import math

import numpy as np
import pytest
from copter_client import GUIDED, LAND, LOITER, RTL, Client, new_simulator, pick, texts, yaw_deg
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sitl.orders import Mode

# Boot and telemetry


def test_the_first_bytes_are_plain_text_and_a_parser_finds_its_feet_behind_them(copter):
    heard = copter.live(1.5)
    assert copter.raw.lstrip().startswith(b"Init ArduCopter V4.6.3")
    assert pick(heard, "HEARTBEAT")


def test_unasked_come_heartbeats_at_1_hz_and_timesync_every_10_s_only(copter):
    heard = copter.live(20.5)
    assert {message.get_type() for message in heard} == {"HEARTBEAT", "TIMESYNC"}
    assert len(pick(heard, "HEARTBEAT")) == pytest.approx(20, abs=1)
    assert len(pick(heard, "TIMESYNC")) == pytest.approx(2, abs=1)


def test_the_heartbeat_says_boot_for_2_9_s_and_then_standby(copter):
    first = pick(copter.live(2.8), "HEARTBEAT")
    then = pick(copter.live(2.5), "HEARTBEAT")
    assert {beat.system_status for beat in first} == {1}
    assert {beat.system_status for beat in then[-2:]} == {3}
    assert (then[0].autopilot, then[0].type, then[0].base_mode, then[0].custom_mode) == (3, 2, 81, 0)


def test_an_interval_that_was_set_before_standby_has_no_effect(copter):
    copter.live(1.0)
    assert copter.ask(511, 30, 100_000) == 0
    assert not pick(copter.live(3.0), "ATTITUDE")
    assert copter.ask(511, 30, 100_000) == 0
    assert len(pick(copter.live(2.0), "ATTITUDE")) == pytest.approx(20, abs=1)


def test_request_data_stream_0_starts_all_groups_and_stops_them(copter):
    copter.live(4.0)
    copter.say(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 4, 1))
    copter.live(0.5)
    heard = copter.live(3.0)
    kinds = {message.get_type() for message in heard}
    assert {"ATTITUDE", "GLOBAL_POSITION_INT", "VFR_HUD", "SYS_STATUS", "GPS_RAW_INT", "RC_CHANNELS"} <= kinds
    assert {"EKF_STATUS_REPORT", "RAW_IMU", "SERVO_OUTPUT_RAW", "SYSTEM_TIME", "BATTERY_STATUS"} <= kinds
    assert {"VIBRATION", "NAV_CONTROLLER_OUTPUT", "SCALED_PRESSURE", "AHRS2", "MISSION_CURRENT"} <= kinds
    assert len(pick(heard, "ATTITUDE")) == pytest.approx(12, abs=1)
    copter.say(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 0, 0))
    copter.live(0.1)
    assert {message.get_type() for message in copter.live(3.0)} <= {"HEARTBEAT", "TIMESYNC"}


def test_it_tells_where_it_flies_to_and_how_far_that_is(aloft):
    aloft.say(mavlink.MAVLink_request_data_stream_message(1, 1, 2, 4, 1))
    assert not pick(aloft.live(1.0), "POSITION_TARGET_GLOBAL_INT")
    north_m, east_m, down_m = aloft.here.tolist()
    aloft.target(p=(north_m + 60.0, east_m, down_m - 5.0))
    heard = aloft.live(1.0)
    here = aloft.simulator.report.place
    target = pick(heard, "POSITION_TARGET_GLOBAL_INT")[-1]
    assert target.lat_int * 1e-7 == pytest.approx(here[0] + math.degrees(60.0 / 6.357e6), abs=2e-5)
    assert target.lon_int * 1e-7 == pytest.approx(here[1], abs=2e-6)
    assert target.alt == pytest.approx(here[2] + 5.0, abs=1.0)
    assert pick(heard, "NAV_CONTROLLER_OUTPUT")[-1].wp_dist == pytest.approx(60, abs=2)
    aloft.command(176, 1, RTL)
    aloft.live(40.0)
    assert pick(aloft.live(0.5), "NAV_CONTROLLER_OUTPUT")[-1].wp_dist < 60


def test_without_an_airspeed_sensor_the_hud_shows_the_speed(aloft):
    assert aloft.ask(511, 74, 100_000) == 0
    aloft.live(6.0, lambda: aloft.target(v=(3.0, 0.0, 0.0)))
    assert pick(aloft.live(0.3), "VFR_HUD")[-1].airspeed == pytest.approx(3.0, abs=0.4)


def test_400_hz_is_refused_as_too_fast(copter):
    copter.live(4.0)
    copter.command(511, 30, 2500)
    heard = copter.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [2]
    assert any("too fast" in text for text in texts(heard))


def test_the_local_position_is_absent_until_the_ekf_has_an_origin(copter):
    copter.live(4.0)
    copter.command(511, 32, 100_000)
    copter.command(511, 30, 100_000)
    heard = copter.until(lambda: copter.simulator.report.origin is not None, 40.0)
    assert not pick(heard[:-100], "LOCAL_POSITION_NED") and pick(heard, "ATTITUDE")
    assert pick(copter.live(1.0), "LOCAL_POSITION_NED")


def test_links_are_asked_one_by_one(copter):
    copter.live(4.0)
    copter.command(511, 30, 100_000)
    first, second = copter.simulator.exchange(5_000_000, (copter.outbox, b""))
    assert not second.count(b"ATTITUDE")
    first, second = copter.simulator.exchange(7_000_000, (b"", b""))
    assert len(first) > 3 * len(second) > 0


# Arming


def test_arming_in_guided_fails_with_4_until_41_s_though_the_prearm_bit_is_set_at_23_s(copter):
    copter.ask(176, 1, GUIDED)
    copter.live(20.0)
    copter.command(512, 1)
    (status,) = pick(copter.live(0.1), "SYS_STATUS")
    assert not status.onboard_control_sensors_health & 1 << 28
    copter.live(5.0)
    copter.command(512, 1)
    copter.command(400, 1)
    heard = copter.live(0.1)
    assert pick(heard, "SYS_STATUS")[0].onboard_control_sensors_health & 1 << 28
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [0, 4]
    assert "Arm: Need Position Estimate" in texts(heard)
    assert "EKF3 IMU0 is using GPS" in texts(copter.live(17.0))
    assert copter.ask(400, 1) == 0


def test_it_does_not_arm_in_modes_that_fly_by_themselves(copter):
    copter.live(42.0)
    copter.ask(176, 1, RTL)
    copter.command(400, 1)
    heard = copter.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [4]
    assert "Arm: RTL mode not armable" in texts(heard)


def test_arming_tells_origin_and_home_again_and_arming_when_armed_is_accepted(copter):
    copter.ask(176, 1, GUIDED)
    copter.live(42.0)
    copter.command(400, 1)
    heard = copter.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [0]
    assert pick(heard, "GPS_GLOBAL_ORIGIN")
    assert pick(heard, "HOME_POSITION")
    assert copter.ask(400, 1) == 0


def test_home_moves_when_it_is_armed_but_the_origin_stays(copter):
    """Landed 20 m north, it is armed there: home is there, the local frame begins where it began."""
    copter.airborne()
    origin, home = copter.simulator.report.origin, copter.flight.home.position_ned_m
    copter.target(p=(float(home[0]) + 20.0, float(home[1]), float(home[2]) - 10.0))
    copter.live(20.0)
    copter.ask(176, 1, LAND)
    copter.until(lambda: not copter.flight.armed, 40.0)
    copter.ask(176, 1, GUIDED)
    assert copter.ask(400, 1) == 0
    moved = copter.flight.home.position_ned_m - home
    assert moved[0] == pytest.approx(20.0, abs=1.0)
    assert copter.simulator.report.origin == origin


def test_do_set_home_moves_home_and_leaves_the_local_frame(aloft):
    before, place = aloft.here.copy(), aloft.flight.home.point
    assert aloft.ask(179, 0, 0, 0, 0, place.lat_deg, place.lon_deg + 1e-4, place.alt_amsl_m - 3.0) == 0
    assert aloft.flight.home.position_ned_m[2] == pytest.approx(before[2] + 10.0 + 3.0, abs=0.5)
    assert np.allclose(aloft.here, before, atol=0.2)


def test_a_home_that_was_set_by_hand_stays_when_it_is_armed(copter):
    copter.ask(176, 1, GUIDED)
    copter.live(42.0)
    place = copter.flight.home.point
    copter.ask(179, 0, 0, 0, 0, place.lat_deg, place.lon_deg + 1e-4, place.alt_amsl_m - 6.0)
    home = copter.flight.home
    copter.airborne(16.0)
    assert copter.flight.home is home
    assert copter.here[2] - home.position_ned_m[2] == pytest.approx(-16.0, abs=0.5)
    assert copter.simulator.truth.position_ned_m[2] == pytest.approx(-10.0, abs=0.7)


def test_disarming_in_the_air_fails_with_4_and_forced_it_works(aloft):
    assert aloft.ask(400, 0) == 4
    assert aloft.flight.armed
    assert aloft.ask(400, 0, 21196) == 0
    assert not aloft.flight.armed


@pytest.mark.parametrize("streaming", [False, True])
def test_it_disarms_10_s_after_arming_on_the_ground_streaming_or_not(copter, streaming):
    copter.ask(176, 1, GUIDED)
    copter.live(42.0)
    copter.ask(400, 1)
    stream = (lambda: copter.target(p=(0.0, 0.0, -10.0))) if streaming else None
    copter.live(9.5, stream)
    assert copter.flight.armed
    copter.live(1.0, stream)
    assert not copter.flight.armed


# Parameters


def test_parameters_come_in_index_order_as_plain_numbers(copter):
    copter.live(4.0)
    copter.say(mavlink.MAVLink_param_request_list_message(1, 1))
    values = [v for v in pick(copter.live(1.0), "PARAM_VALUE") if v.param_index != 65535]
    assert [value.param_index for value in values] == list(range(values[0].param_count))
    table = {value.param_id: value.param_value for value in values}
    assert table["WPNAV_SPEED"] == 1000.0
    assert table["GUID_TIMEOUT"] == 3.0
    assert table["RTL_ALT"] == 1500.0
    assert table["FS_GCS_ENABLE"] == 0.0


def test_param_set_and_read_by_name_answer_with_index_65535_and_unknown_names_with_nothing(copter):
    copter.live(4.0)
    copter.say(mavlink.MAVLink_param_set_message(1, 1, b"GUID_TIMEOUT", 0.5, 9))
    copter.say(mavlink.MAVLink_param_request_read_message(1, 1, b"GUID_TIMEOUT", -1))
    copter.say(mavlink.MAVLink_param_request_read_message(1, 1, b"NO_SUCH_NAME", -1))
    values = pick(copter.live(0.2), "PARAM_VALUE")
    assert [(v.param_id, v.param_value, v.param_index) for v in values] == [("GUID_TIMEOUT", 0.5, 65535)] * 2


def test_parameters_tell_their_types_and_a_set_with_another_type_changes_none(copter):
    """8, 16 and 32 bits are 2, 4 and 6, floats 9; the values are plain numbers all the same."""
    copter.say(mavlink.MAVLink_param_set_message(1, 1, b"RTL_ALT", 2500.7, 9))
    for name in (b"RTL_ALT", b"SYSID_MYGCS", b"WP_YAW_BEHAVIOR", b"WPNAV_SPEED"):
        copter.say(mavlink.MAVLink_param_request_read_message(1, 1, name, -1))
    told = {v.param_id: (v.param_type, v.param_value) for v in pick(copter.live(0.1), "PARAM_VALUE")}
    assert told == {
        "RTL_ALT": (6, 2500.0),
        "SYSID_MYGCS": (4, 255.0),
        "WP_YAW_BEHAVIOR": (2, 2.0),
        "WPNAV_SPEED": (9, 1000.0),
    }


def test_an_unsolicited_parameter_appears(copter):
    (value,) = pick(copter.live(31.0), "PARAM_VALUE")
    assert value.param_id == "STAT_RUNTIME"


# Commands


def test_a_bad_mode_is_answered_with_4_and_a_text(copter):
    copter.live(4.0)
    copter.command(176, 1, 99)
    heard = copter.live(0.1)
    assert [ack.result for ack in pick(heard, "COMMAND_ACK")] == [4]
    assert texts(heard)


def test_set_mode_works_without_an_ack(copter):
    copter.live(4.0)
    copter.say(mavlink.MAVLink_set_mode_message(1, 1, GUIDED))
    assert not pick(copter.live(0.1), "COMMAND_ACK")
    assert copter.flight.mode is Mode.GUIDED


def test_take_off_before_arming_fails_with_4_and_so_it_does_in_flight(copter, aloft):
    copter.ask(176, 1, GUIDED)
    assert copter.ask(22, 0, 0, 0, 0, 0, 0, 10) == 4
    assert aloft.ask(22, 0, 0, 0, 0, 0, 0, 20) == 4


def test_take_off_counts_from_home_and_a_command_int_needs_the_relative_frame(copter):
    copter.ask(176, 1, GUIDED)
    copter.live(42.0)
    copter.ask(400, 1)
    copter.command_int(22, 0, z=600.0)
    assert [ack.result for ack in pick(copter.live(0.1), "COMMAND_ACK")] == [4]
    copter.command_int(22, 3, z=6.0)
    assert [ack.result for ack in pick(copter.live(0.1), "COMMAND_ACK")] == [0]
    copter.live(12.0)
    assert copter.flight.home.position_ned_m[2] - copter.here[2] == pytest.approx(6.0, abs=0.5)


def test_an_unknown_message_is_refused_with_4_and_its_interval_with_2(copter):
    copter.live(4.0)
    assert copter.ask(512, 9999) == 4
    assert copter.ask(511, 9999, 100_000) == 2


def test_autopilot_version_comes_after_its_ack(copter):
    copter.live(4.0)
    copter.command(512, 148)
    heard = [message.get_type() for message in copter.live(0.05)]
    assert heard.index("COMMAND_ACK") < heard.index("AUTOPILOT_VERSION")


def test_the_capabilities_and_the_version_are_4_6_3s(copter):
    copter.live(4.0)
    copter.command(512, 148)
    (version,) = pick(copter.live(0.1), "AUTOPILOT_VERSION")
    assert version.capabilities == 64495
    assert version.flight_sw_version >> 8 == 0x040603


def test_unknown_commands_and_reposition_as_command_long_are_unsupported(aloft):
    assert aloft.ask(31999) == 3
    assert aloft.ask(192, -1, 1, 0, 0, 0, 0, 0) == 3


def test_reposition_as_command_int_goes_there(aloft):
    place = aloft.flight.home.point
    here = aloft.here.copy()
    aloft.command_int(
        192,
        3,
        -1,
        1,
        0,
        math.nan,
        x=round((place.lat_deg + 2e-4) * 1e7),
        y=round(place.lon_deg * 1e7),
        z=15.0,
    )
    heard = aloft.live(25.0)
    assert pick(heard, "COMMAND_ACK")[0].result == 0
    assert aloft.here[0] - here[0] == pytest.approx(22.2, abs=1.0)
    assert here[2] - aloft.here[2] == pytest.approx(5.0, abs=0.5)


# GUIDED


def test_armed_on_the_ground_setpoints_do_not_take_off(copter):
    copter.ask(176, 1, GUIDED)
    copter.live(42.0)
    copter.ask(400, 1)
    copter.live(5.0, lambda: copter.target(p=(0.0, 0.0, -20.0), v=(0.0, 0.0, -1.0)))
    assert copter.simulator.report.flight.landed.name == "ON_GROUND"


def test_a_position_setpoint_in_mid_take_off_cancels_it(copter):
    copter.ask(176, 1, GUIDED)
    copter.live(42.0)
    copter.ask(400, 1)
    copter.ask(22, 0, 0, 0, 0, 0, 0, 20)
    home_m = float(copter.flight.home.position_ned_m[2])
    copter.until(lambda: home_m - copter.here[2] > 3.0, 20.0)
    north, east, _ = copter.here.tolist()
    copter.target(p=(north, east, home_m - 5.0))
    copter.live(15.0)
    assert home_m - copter.here[2] == pytest.approx(5.0, abs=0.7)


@pytest.mark.parametrize("addressee", [(1, 1), (1, 0), (0, 0)])
def test_setpoints_are_taken_from_anybody_for_us_or_for_all(aloft, addressee):
    stranger = Client(aloft.simulator, system=77)
    north, east, down = stranger.here.tolist()
    stranger.target(p=(north + 5.0, east, down), system=addressee[0], component=addressee[1])
    stranger.live(10.0)
    assert stranger.here[0] - north == pytest.approx(5.0, abs=0.5)


def test_setpoints_for_another_system_are_ignored(aloft):
    north, east, down = aloft.here.tolist()
    aloft.target(p=(north + 5.0, east, down), system=2)
    aloft.live(6.0)
    assert aloft.here[0] == pytest.approx(north, abs=0.3)


def test_outside_guided_setpoints_are_silently_ignored(aloft):
    aloft.ask(176, 1, LOITER)
    north, east, down = aloft.here.tolist()
    heard = aloft.live(5.0, lambda: aloft.target(p=(north + 5.0, east, down)))
    assert aloft.here[0] == pytest.approx(north, abs=0.3)
    assert not pick(heard, "STATUSTEXT")


@pytest.mark.parametrize(
    "what",
    [
        {"p": (50.0, 0.0, -10.0), "a": (0.0, 0.0, 0.0)},
        {},
        {"yaw": 1.0},
        {"p": (50.0, 0.0, -10.0), "frame": 12},
        {"p": (50.0, 0.0, -10.0), "v": (math.nan, 0.0, 0.0)},
        {"p": (50.0, 0.0, -10.0), "v": (1001.0, 0.0, 0.0)},
        {"p": (50.0, 0.0, -10.0), "v": (1.0, 0.0, 0.0), "a": (0.0, 0.0, 0.0), "mask": 0x200},
    ],
    ids=["pos+acc", "nothing", "yaw only", "frame", "nan", "too fast", "force"],
)
def test_what_cannot_be_followed_stops_the_vehicle(aloft, what):
    aloft.live(4.0, lambda: aloft.target(v=(3.0, 0.0, 0.0)))
    assert aloft.simulator.report.estimate.velocity_ned_mps[0] > 2.5
    aloft.target(**what)
    aloft.live(5.0)
    assert np.linalg.norm(aloft.simulator.report.estimate.velocity_ned_mps) < 0.3
    assert aloft.flight.mode is Mode.GUIDED


def test_a_group_with_one_ignored_axis_is_ignored_whole(aloft):
    north, east, down = aloft.here.tolist()
    aloft.target(p=(north + 9.0, east, down), v=(0.0, 1.0, 0.0), mask=0xC00 | 0x1C0 | 0x001)
    aloft.live(2.5)
    assert aloft.here[0] == pytest.approx(north, abs=0.3)
    assert aloft.here[1] - east > 1.0


@pytest.mark.parametrize(("frame", "nose_deg"), [(7, 0.0), (9, 90.0)])
def test_offset_frames_count_from_where_it_is_at_every_message_so_that_streaming_them_creeps(
    aloft, frame, nose_deg
):
    aloft.target(p=tuple(aloft.here.tolist()), yaw=math.radians(nose_deg) + 1e-9)
    aloft.live(4.0)
    before = aloft.here.copy()
    aloft.target(p=(4.0, 0.0, 0.0), frame=frame)
    aloft.live(10.0)
    moved = aloft.here - before
    ahead = (math.cos(math.radians(nose_deg)), math.sin(math.radians(nose_deg)))
    assert moved[:2] == pytest.approx([4.0 * ahead[0], 4.0 * ahead[1]], abs=0.6)
    before = aloft.here.copy()
    aloft.live(20.0, lambda: aloft.target(p=(4.0, 0.0, 0.0), frame=7))
    assert aloft.here[0] - before[0] > 15.0


def test_in_body_axes_a_velocity_flies_along_the_nose_and_a_yaw_counts_from_it(aloft):
    aloft.target(p=tuple(aloft.here.tolist()), yaw=math.radians(90.0))
    aloft.live(5.0)
    aloft.target(v=(2.0, 0.0, 0.0), frame=8, yaw_rate=0.0)
    aloft.live(2.5)
    assert aloft.simulator.report.estimate.velocity_ned_mps == pytest.approx([0.0, 2.0, 0.0], abs=0.4)
    aloft.target(v=(0.0, 0.0, 0.0), frame=9, yaw=math.radians(30.0))
    aloft.live(8.0)
    assert yaw_deg(aloft) == pytest.approx(120.0, abs=4.0)


def test_an_acceleration_alone_is_followed(aloft):
    aloft.live(2.0, lambda: aloft.target(a=(1.0, 0.0, 0.0), yaw=0.0))
    north_mps, east_mps, down_mps = aloft.simulator.report.estimate.velocity_ned_mps
    assert 1.0 < north_mps < 2.5
    assert (east_mps, down_mps) == pytest.approx((0.0, 0.0), abs=0.3)


def test_a_target_beyond_the_fence_is_refused_without_a_word_and_the_one_before_it_kept(aloft):
    for name, value in ((b"FENCE_RADIUS", 30.0), (b"FENCE_ENABLE", 1.0)):
        aloft.say(mavlink.MAVLink_param_set_message(1, 1, name, value, 9))
    north, east, down = aloft.here.tolist()
    aloft.target(p=(north + 8.0, east, down))
    aloft.live(3.0)
    aloft.target(p=(north, east + 100.0, down))
    heard = aloft.live(8.0)
    assert aloft.here == pytest.approx([north + 8.0, east, down], abs=0.5)
    assert not pick(heard, "STATUSTEXT") and not pick(heard, "COMMAND_ACK")


def test_an_origin_is_not_moved_by_who_sets_another(aloft):
    origin = aloft.simulator.report.origin
    aloft.say(mavlink.MAVLink_set_gps_global_origin_message(1, 470_000_000, 80_000_000, 500_000))
    assert not aloft.live(0.5)
    assert aloft.simulator.report.origin == origin


def test_with_yaw_and_yaw_rate_ignored_the_nose_turns_along_the_velocity(aloft):
    aloft.live(8.0, lambda: aloft.target(v=(0.0, 3.0, 0.0)))
    assert yaw_deg(aloft) == pytest.approx(90.0, abs=4.0)


def test_yaw_is_held_and_a_rate_turns(aloft):
    p = tuple(aloft.here.tolist())
    aloft.target(p=p, yaw=math.radians(-120.0))
    aloft.live(6.0)
    assert yaw_deg(aloft) == pytest.approx(-120.0, abs=3.0)
    aloft.live(3.0, lambda: aloft.target(p=p, yaw_rate=math.radians(20.0)))
    assert yaw_deg(aloft) == pytest.approx(-60.0, abs=5.0)


def test_a_climb_of_5_mps_is_not_capped_by_wpnav_speed_up(aloft):
    aloft.live(8.0, lambda: aloft.target(v=(0.0, 0.0, -5.0)))
    assert aloft.simulator.report.estimate.velocity_ned_mps[2] == pytest.approx(-5.0, abs=0.3)


def loss(client, **stream):
    """How far beyond the last setpoint it comes when a stream at 3 m/s north breaks off, and the path."""
    north, east, down = client.here.tolist()
    begin_s, last = client.now_s, [0.0]

    def say():
        t_s = client.now_s - begin_s
        last[0] = north + 3.0 * t_s
        what = {"v": (3.0, 0.0, 0.0)} | stream
        if "p" in what:
            what["p"] = (last[0], east, down)
        client.target(**{name: value for name, value in what.items() if value is not None})

    client.live(10.0, say)
    broken_m = last[0]
    stopped_s = None
    for tenth in range(150):
        heard = client.live(0.1)
        assert not pick(heard, "STATUSTEXT")
        if stopped_s is None and abs(client.simulator.report.estimate.velocity_ned_mps[0]) < 0.1:
            stopped_s = tenth / 10
    assert client.flight.mode is Mode.GUIDED
    return float(client.here[0]) - broken_m, stopped_s


def test_a_position_that_is_not_repeated_is_held(aloft):
    north, east, down = aloft.here.tolist()
    aloft.target(p=(north + 6.0, east, down))
    aloft.live(20.0)
    assert aloft.here[0] - north == pytest.approx(6.0, abs=0.4)


def test_position_and_velocity_are_extrapolated_for_guid_timeout_and_then_held(aloft):
    beyond_m, _ = loss(aloft, p=True)
    assert beyond_m == pytest.approx(8.6, abs=0.8)


def test_with_half_a_second_of_guid_timeout_it_goes_but_a_metre_further(aloft):
    aloft.say(mavlink.MAVLink_param_set_message(1, 1, b"GUID_TIMEOUT", 0.5, 9))
    beyond_m, _ = loss(aloft, p=True)
    assert beyond_m == pytest.approx(1.2, abs=0.5)


def test_a_lost_velocity_stops_after_3_to_5_seconds(aloft):
    _, stopped_s = loss(aloft)
    assert 3.0 < stopped_s < 5.5


# The ground station


def test_fs_gcs_is_off_by_default(aloft):
    aloft.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    aloft.live(8.0)
    assert aloft.flight.mode is Mode.GUIDED


def test_fs_gcs_returns_5_s_after_the_last_heartbeat_even_while_setpoints_come(aloft):
    aloft.say(mavlink.MAVLink_param_set_message(1, 1, b"FS_GCS_ENABLE", 1, 9))
    p = tuple(aloft.here.tolist())
    aloft.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    aloft.live(4.8, lambda: aloft.target(p=p))
    assert aloft.flight.mode is Mode.GUIDED
    heard = aloft.live(1.5, lambda: aloft.target(p=p))
    assert aloft.flight.mode is Mode.RTL
    assert any("GCS Failsafe" in text for text in texts(heard))
    assert pick(heard, "HEARTBEAT")[-1].system_status == 5


def test_fs_gcs_listens_to_sysid_mygcs_alone(aloft):
    aloft.say(mavlink.MAVLink_param_set_message(1, 1, b"FS_GCS_ENABLE", 1, 9))
    stranger = Client(aloft.simulator, system=245)
    stranger.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    aloft.live(0.1)
    stranger.live(8.0)
    assert aloft.flight.mode is Mode.GUIDED


# Flying by itself


def test_rtl_climbs_to_rtl_alt_in_its_cone_comes_home_and_disarms(aloft):
    north, east, down = aloft.here.tolist()
    home = aloft.flight.home.position_ned_m.copy()
    aloft.target(p=(north + 30.0, east, down))
    aloft.live(20.0)
    aloft.ask(176, 1, RTL)
    highest = []
    aloft.until(lambda: highest.append(home[2] - aloft.here[2]) or not aloft.flight.armed, 120.0)
    assert max(highest) == pytest.approx(15.0, abs=0.7)
    assert np.linalg.norm(aloft.here[:2] - home[:2]) < 0.7
    assert aloft.flight.mode is Mode.RTL


def test_land_lands_where_it_is_and_disarms(aloft):
    before = aloft.here.copy()
    aloft.ask(21)
    aloft.until(lambda: not aloft.flight.armed, 60.0)
    assert np.linalg.norm(aloft.here[:2] - before[:2]) < 0.7
    assert aloft.flight.mode is Mode.LAND


def test_the_same_bytes_after_a_snapshot(aloft):
    simulator = aloft.simulator
    state = simulator.snapshot()
    runs = []
    for _ in range(2):
        simulator.restore(state)
        client = Client(simulator)
        client.command(511, 30, 50_000)
        client.live(2.0, lambda client=client: client.target(v=(1.0, 2.0, 0.0), yaw=0.3))
        runs.append(client.raw)
    assert runs[0] == runs[1]
    assert len(runs[0]) > 1000


@pytest.mark.parametrize("seed", [18, 37, 48, 54])
def test_it_lands_upright_in_gusts_of_10_mps_and_rests_soon(seed):
    simulator = new_simulator(
        seed=seed, wind_ned_mps=(7.0, -7.0, 0.0) if seed % 2 == 0 else (0.0, 10.0, 0.0), gusts=True
    )
    client = Client(simulator).airborne(4.0)
    client.ask(176, 1, LAND)
    client.until(lambda: simulator.truth.position_ned_m[2] > -0.02, 20.0)
    lean_deg, begun_s = 0.0, client.now_s
    while client.flight.armed:
        client.live(0.05)
        _, x, y, _ = simulator.truth.q_ned_frd
        lean_deg = max(lean_deg, math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y))))
    assert lean_deg < 15.0
    assert client.now_s - begun_s < 2.5
