"""Arming, modes and OFFBOARD over PX4's link: what a real PX4 v1.17 was seen to do, one test a behaviour."""

import math

import pytest
from px4_answers import acks, heartbeat_mode

from sitl.orders import Mode


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
