import math
import random
import struct

import pytest
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight import messages
from mavspiral.flight.link import LATE_N, Link
from mavspiral.flight.messages import (
    Command,
    Heartbeat,
    LandedState,
    MessageId,
    ParamValue,
    Result,
    SystemStatus,
    Target,
    TypeMask,
)
from mavspiral.flight.mission_messages import MissionItem

TARGET = Target((1.5, -2.25, -30.125), (3.0, 0.5, -0.25), (0.1, -0.2, 0.3), -3.0, 0.25)


def flat(target):
    return (*target[0], *target[1], *target[2], target[3], target[4])


def vehicle(seq=0, system=1, component=1):
    mav = mavlink.MAVLink(None, system, component)
    mav.seq = seq
    return mav


def paired(tap=None):
    link = Link(tap)
    link.vehicle = (1, 1)
    return link


def position(seq=0, **kwargs):
    return mavlink.MAVLink_local_position_ned_message(123456, 1.5, -2.0, -3.25, 0.5, 0.25, -0.125).pack(
        vehicle(seq, **kwargs)
    )


@pytest.mark.parametrize(
    ("ours", "prefix"),
    [
        (MessageId, "MAVLINK_MSG_ID_"),
        (Command, "MAV_CMD_"),
        (Result, "MAV_RESULT_"),
        (SystemStatus, "MAV_STATE_"),
        (LandedState, "MAV_LANDED_STATE_"),
        (TypeMask, "POSITION_TARGET_TYPEMASK_"),
    ],
)
def test_every_number_is_the_dialect_s(ours, prefix):
    for member in ours:
        assert member.value == getattr(mavlink, prefix + member.name), member


@pytest.mark.parametrize("target", [TARGET, Target((0, 0, 0), (0, 0, 0), (0, 0, 0), 0.0, 0.0)])
@pytest.mark.parametrize(("mask", "frame"), [(0, 1), (0x9C0, 8), (0, 0)])
def test_a_setpoint_is_pymavlink_s_byte_for_byte(target, mask, frame):
    link, theirs = paired(), vehicle(system=245, component=191)
    for _ in range(3):
        message = mavlink.MAVLink_set_position_target_local_ned_message(
            4_000_000_000, 1, 1, frame, mask, *target[0], *target[1], *target[2], target[3], target[4]
        )
        assert link.setpoint(
            4_000_000_000, flat(target), type_mask=mask, coordinate_frame=frame
        ) == message.pack(theirs)
        theirs.seq += 1


def test_every_other_frame_is_pymavlink_s_byte_for_byte():
    link, theirs = paired(), vehicle(system=245, component=191)
    item = MissionItem(3, 16, 6, (0.5, math.nan, 0.0, 1.5), 194339000, -991406000, 25.5, True, 0)
    for message, ours in (
        (mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), link.heartbeat()),
        (
            mavlink.MAVLink_command_long_message(1, 1, 22, 0, 1.0, math.nan, 0, 0, 0, 0, 0),
            link.command(Command.NAV_TAKEOFF, 1.0, math.nan),
        ),
        (
            mavlink.MAVLink_command_long_message(1, 100, 2000, 0, 0, 0, 1, 7, 0, 0, 0),
            link.command(Command.IMAGE_START_CAPTURE, 0.0, 0.0, 1.0, 7.0, component=100),
        ),
        (
            mavlink.MAVLink_param_request_read_message(1, 1, b"COM_OF_LOSS_T", -1),
            link.parameter_request("COM_OF_LOSS_T"),
        ),
        (
            mavlink.MAVLink_param_set_message(1, 1, b"RTL_RETURN_ALT", 31.5, 9),
            link.parameter_set("RTL_RETURN_ALT", 31.5, 9),
        ),
        (mavlink.MAVLink_mission_count_message(1, 1, 500, 2), link.mission_count(500, 2)),
        (mavlink.MAVLink_mission_write_partial_list_message(1, 1, 3, 9, 0), link.mission_part(3, 9, 0)),
        (
            mavlink.MAVLink_mission_item_int_message(
                1, 1, 3, 6, 16, 0, 1, 0.5, math.nan, 0.0, 1.5, 194339000, -991406000, 25.5, 0
            ),
            link.mission_item(item),
        ),
        (mavlink.MAVLink_mission_request_list_message(1, 1, 1), link.mission_list_request(1)),
        (mavlink.MAVLink_mission_request_int_message(1, 1, 260, 1), link.mission_request(260, 1)),
        (mavlink.MAVLink_mission_ack_message(1, 1, 0, 1), link.mission_ack(1)),
    ):
        assert ours == message.pack(theirs), message
        theirs.seq += 1


def test_sequence_numbers_run_through_all_frames_and_wrap():
    link = paired()
    seen = []
    for _ in range(130):
        seen.append(link.heartbeat()[4])
        seen.append(link.setpoint(0, flat(TARGET), type_mask=0, coordinate_frame=1)[4])
    assert seen == [i % 256 for i in range(260)]


def test_we_are_a_companion_and_no_autopilot():
    [beat] = mavlink.MAVLink(None).parse_buffer(Link().heartbeat())
    assert (beat.get_srcSystem(), beat.get_srcComponent()) == (245, 191)
    assert (beat.type, beat.autopilot) == (mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID)


def test_commands_and_requests_are_addressed_to_the_vehicle():
    link = Link()
    link.vehicle = (7, 3)
    [command] = mavlink.MAVLink(None).parse_buffer(link.command(Command.NAV_TAKEOFF, 1.0, math.nan))
    assert (command.target_system, command.target_component, command.command) == (7, 3, 22)
    assert command.param1 == 1.0 and math.isnan(command.param2) and command.param7 == 0.0
    [request] = mavlink.MAVLink(None).parse_buffer(link.parameter_request("MPC_Z_VEL_MAX_UP"))
    assert (request.target_system, request.param_id, request.param_index) == (7, "MPC_Z_VEL_MAX_UP", -1)


def test_garbage_is_counted_and_skipped_and_costs_no_frame():
    rng = random.Random(3)
    stream, link = b"", paired()
    for seq in range(50):
        stream += bytes(
            rng.choice([b for b in range(256) if b not in (0xFD, 0xFE)]) for _ in range(9)
        ) + position(seq)
    got = []
    while stream:  # in pieces of any size
        n = rng.randint(1, 40)
        got += link.receive(stream[:n])
        stream = stream[n:]
    assert len(got) == 50
    assert link.garbage_n >= 50


def test_a_false_start_costs_one_byte_and_no_frame():
    link = paired()
    stream = b"".join(b"\xfd" + position(seq) + b"\xfe\x09" for seq in range(40))
    assert len(link.receive(stream) + link.receive(b"\x00" * 300)) == 40


def test_version_1_frames_are_read_too():
    beat = mavlink.MAVLink_heartbeat_message(2, 12, 0x81, 6 << 16, 4, 3).pack(vehicle(), force_mavlink1=True)
    link = paired()
    assert link.receive(beat[:3]) == [] and link.receive(beat[3:]) == [
        Heartbeat(1, 1, 12, True, 6 << 16, 4, 2)
    ]


def test_of_a_corrupted_stream_all_is_accepted_that_pymavlink_accepts_and_nothing_false():
    rng = random.Random(5)
    stream = bytearray(b"".join(position(seq % 256) for seq in range(400)))
    for _ in range(60):
        stream[rng.randrange(len(stream))] ^= 1 << rng.randrange(8)
    slow = mavlink.MAVLink(None)
    slow.robust_parsing = True
    theirs = [
        m.time_boot_ms for m in slow.parse_buffer(bytes(stream)) if m.get_type() == "LOCAL_POSITION_NED"
    ]
    seen = []
    paired(lambda _, frame: seen.append(frame)).receive(bytes(stream))
    ours = [f for f in seen if f[7:10] == b"\x20\0\0"]
    assert len(ours) >= len(theirs) > 300
    assert {f[10:][:-2] for f in ours} == {position()[10:-2]}


def test_only_the_vehicle_is_heard_once_it_is_known():
    beat = mavlink.MAVLink_heartbeat_message(2, 12, 0x81, 6 << 16, 4, 3).pack(vehicle(system=9))
    link = Link()
    assert link.receive(position()) == []
    assert link.receive(beat) == [Heartbeat(9, 1, 12, True, 6 << 16, 4, 2)]
    link.vehicle = (9, 1)
    assert link.receive(position(5)) == []
    assert len(link.receive(position(5, system=9))) == 1


def test_doubled_and_overtaken_frames_are_dropped():
    link = paired()
    order = [250, 251, 251, 253, 252, 2, 1, 3]
    got = [bool(link.receive(position(seq))) for seq in order]
    assert got == [True, True, False, True, False, True, False, True]


def test_a_long_gap_is_not_taken_for_an_overtaken_frame():
    link = paired()
    assert link.receive(position(200)) and link.receive(position((200 - LATE_N) % 256))


def test_messages_beyond_the_dialect_are_passed_over_but_tapped():
    seen = []
    link = paired(lambda now_us, frame: seen.append((now_us, frame)))
    link.now_us = 70
    unknown = bytearray(position(9))
    unknown[7:10] = (410).to_bytes(3, "little")
    assert link.receive(bytes(unknown)) == []
    assert (seen, link.garbage_n, dict(link.arrivals)) == ([(70, bytes(unknown))], 0, {})
    assert link.receive(position(5)), "an unchecked sequence number counts for nothing"


def test_the_tap_sees_whole_frames_of_both_directions():
    frames = []
    link = paired(lambda _, frame: frames.append(frame))
    beat = link.heartbeat()
    link.receive(b"junk" + position()[:10])
    link.receive(position()[10:])
    assert frames == [beat, position()]


@pytest.mark.parametrize(("kind", "code", "value"), [(6, "<i", -5), (9, "<f", 2.5), (2, "<bxxx", -3)])
def test_integers_are_read_from_the_float_s_bytes(kind, code, value):
    raw = struct.unpack("<f", struct.pack(code, value))[0]
    message = mavlink.MAVLink_param_value_message(b"COM_OBL_RC_ACT", raw, kind, 1, 0)
    [got] = paired().receive(message.pack(vehicle()))
    assert isinstance(got, ParamValue) and got.name == "COM_OBL_RC_ACT"
    assert got.number(bytewise=True) == value
    assert ParamValue("X", 3.0, kind).number(bytewise=False) == 3.0


def test_all_our_values_are_exported():
    assert set(messages.__all__) <= set(dir(messages))
