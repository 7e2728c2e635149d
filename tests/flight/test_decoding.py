"""What a frame says is what pymavlink's decoder says, message by message."""

from __future__ import annotations

import random

import pytest
from pymavlink.dialects.v20 import ardupilotmega
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.decoding import KINDS
from mavspiral.flight.framing import Decoder
from mavspiral.flight.messages import (
    Attitude,
    AutopilotVersion,
    CommandAck,
    ExtendedSysState,
    GlobalPosition,
    GpsFix,
    Heartbeat,
    Home,
    ImageCaptured,
    LocalPosition,
    Origin,
    ParamValue,
    StatusText,
    SysStatus,
)
from mavspiral.flight.mission_messages import MissionAck, MissionCount, MissionItem, MissionRequest

MEANING = {
    "HEARTBEAT": lambda m: Heartbeat(
        m.get_srcSystem(),
        m.get_srcComponent(),
        m.autopilot,
        m.base_mode >= 128,
        m.custom_mode,
        m.system_status,
        m.type,
    ),
    "LOCAL_POSITION_NED": lambda m: LocalPosition(m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz),
    "ATTITUDE": lambda m: Attitude(
        m.time_boot_ms, m.roll, m.pitch, m.yaw, m.rollspeed, m.pitchspeed, m.yawspeed
    ),
    "SYS_STATUS": lambda m: SysStatus(None if m.battery_remaining < 0 else m.battery_remaining),
    "EXTENDED_SYS_STATE": lambda m: ExtendedSysState(m.landed_state),
    "GPS_RAW_INT": lambda m: GpsFix(m.fix_type, m.lat / 1e7, m.lon / 1e7),
    "GPS_GLOBAL_ORIGIN": lambda m: Origin(m.latitude / 1e7, m.longitude / 1e7, m.altitude / 1e3),
    "HOME_POSITION": lambda m: Home(m.latitude / 1e7, m.longitude / 1e7, m.altitude / 1e3),
    "GLOBAL_POSITION_INT": lambda m: GlobalPosition(m.time_boot_ms, m.lat / 1e7, m.lon / 1e7, m.alt / 1e3),
    "CAMERA_IMAGE_CAPTURED": lambda m: ImageCaptured(m.time_boot_ms, m.image_index, m.capture_result == 1),
    "CAMERA_FEEDBACK": lambda m: ImageCaptured(m.time_usec // 1000, m.img_idx, True),
    "COMMAND_ACK": lambda m: CommandAck(m.command, m.result),
    "AUTOPILOT_VERSION": lambda m: AutopilotVersion(
        ".".join(str(part) for part in m.flight_sw_version.to_bytes(4, "big")[:3]), m.capabilities
    ),
    "STATUSTEXT": lambda m: StatusText(m.severity, m.text),
    "PARAM_VALUE": lambda m: ParamValue(m.param_id, m.param_value, m.param_type),
    "MISSION_COUNT": lambda m: MissionCount(m.count, m.mission_type),
    "MISSION_REQUEST": lambda m: MissionRequest(m.seq, m.mission_type),
    "MISSION_REQUEST_INT": lambda m: MissionRequest(m.seq, m.mission_type),
    "MISSION_ITEM_INT": lambda m: MissionItem(
        m.seq,
        m.command,
        m.frame,
        (m.param1, m.param2, m.param3, m.param4),
        m.x,
        m.y,
        m.z,
        m.autocontinue != 0,
        m.mission_type,
    ),
    "MISSION_ACK": lambda m: MissionAck(m.type, m.mission_type),
}


def framed(described, payload, *, version, signed=False):
    """A frame from system 7, component 3, its signature nobody's."""
    if version == 1:
        body = bytes((len(payload), 9, 7, 3, described.id)) + payload
    else:
        body = bytes((len(payload), int(signed), 0, 9, 7, 3)) + described.id.to_bytes(3, "little") + payload
    checksum = mavlink.x25crc(body + bytes((described.crc_extra,))).crc.to_bytes(2, "little")
    return bytes((0xFE if version == 1 else 0xFD,)) + body + checksum + bytes(13 * signed)


def frames(described, rng):
    """Of any fields: whole, with zeros cut off, with bytes that a later dialect has added, signed, and by version 1."""
    size = described.unpacker.size
    for _ in range(20):
        payload = rng.randbytes(size)
        yield framed(described, payload, version=2)
        yield framed(described, payload, version=2, signed=True)
        yield framed(described, payload[: rng.randint(1, size)], version=2)
        yield framed(described, (payload + b"\1\2")[:255], version=2)
        if described.id < 256:
            yield framed(described, payload, version=1)


def test_every_value_is_of_a_message_that_is_checked_here():
    known = [kind for kind in KINDS.values() if kind.value is not None]
    assert len(known) == len(MEANING)


@pytest.mark.parametrize("name", MEANING)
def test_a_message_says_what_pymavlink_reads(name):
    by_name = {message.msgname: message for message in ardupilotmega.mavlink_map.values()}
    theirs = ardupilotmega.MAVLink(None)
    for frame in frames(by_name[name], random.Random(name)):
        [(whole, kind, *who)] = Decoder().frames(frame)
        assert (whole, who) == (frame, [9, 7, 3])
        # By repr, because a NaN is not itself.
        assert repr(kind.value(frame)) == repr(MEANING[name](theirs.decode(bytearray(frame)))), frame.hex()


def test_a_turned_bit_in_any_byte_is_noticed():
    whole = framed(mavlink.MAVLink_attitude_message, bytes(range(1, 29)), version=2)
    for at in range(len(whole)):
        turned = whole[:at] + bytes((whole[at] ^ 4,)) + whole[at + 1 :]
        assert not [kind for _, kind, *_ in Decoder().frames(turned + bytes(300)) if kind is not None]


def test_what_is_of_no_use_is_whole_and_says_nothing():
    [(_, kind, *_)] = Decoder().frames(framed(mavlink.MAVLink_vfr_hud_message, bytes(20), version=2))
    assert kind.message_id == mavlink.MAVLINK_MSG_ID_VFR_HUD
    assert kind.value is None
