"""What a MAVLink frame says, as one of our values.

Unpacked by pymavlink's own metadata, without building its objects, which costs ten times as much; tests hold both equal.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import ardupilotmega
from pymavlink.dialects.v20 import common as mavlink

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
    Message,
    Origin,
    ParamValue,
    StatusText,
    SysStatus,
)
from mavspiral.flight.mission_messages import MissionAck, MissionCount, MissionItem, MissionRequest

__all__ = ["KINDS", "Kind", "sender"]

_V2 = 0xFD
_HEADER_N, _V1_HEADER_N = 10, 6
_new: Callable[[type[Message], tuple[Any, ...]], Message] = tuple.__new__
_Fields = Callable[[bytes], tuple[Any, ...]]
_Value = Callable[[bytes], Message]


class Kind(NamedTuple):
    """One message of the dialect.

    Args:
        message_id: its number.
        crc_extra: the byte that its checksum has beyond the frame's own.
        value: what a whole frame of this kind says; None where it is of no use to us.
    """

    message_id: int
    crc_extra: bytes
    value: _Value | None


def sender(frame: bytes) -> bytes:
    """Sequence number, system and component of a MAVLink 2 or 1 frame, a byte each."""
    return frame[4:7] if frame[0] == _V2 else frame[2:5]


def _fields(described: Any) -> _Fields:
    """Gives the fields in a whole frame, in their order on the wire, with the zeros that were cut off."""
    unpack_from, payload_n = described.unpacker.unpack_from, described.unpacker.size

    def fields(frame: bytes) -> tuple[Any, ...]:
        begin, sent_n = _HEADER_N if frame[0] == _V2 else _V1_HEADER_N, frame[1]
        there: tuple[Any, ...]
        if sent_n >= payload_n:
            there = unpack_from(frame, begin)
        else:
            there = unpack_from(frame[begin : begin + sent_n].ljust(payload_n, b"\0"))
        return there

    return fields


def _as_they_are(described: Any, kind: type[Message]) -> _Value:
    """The value that is its fields as they are."""
    fields = _fields(described)
    return lambda frame: _new(kind, fields(frame))


def _taking(described: Any, names: str, make: Callable[..., Message]) -> _Value:
    """`make` of these fields; on the wire an array counts as many as it has."""
    fields = _fields(described)
    starts = [sum(described.lengths[:number]) for number in range(len(described.lengths))]
    places = [starts[described.ordered_fieldnames.index(name)] for name in names.split()]

    def value(frame: bytes) -> Message:
        said = fields(frame)
        return make(*[said[place] for place in places])

    return value


def _text(raw: bytes) -> str:
    return raw.split(b"\0", 1)[0].decode("ascii", errors="replace")


_heartbeat_fields = _fields(mavlink.MAVLink_heartbeat_message)


def _heartbeat(frame: bytes) -> Heartbeat:
    custom_mode, vehicle_type, autopilot, base_mode, system_status, _ = _heartbeat_fields(frame)
    armed = bool(base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    _, system_id, component_id = sender(frame)
    return Heartbeat(system_id, component_id, autopilot, armed, custom_mode, system_status, vehicle_type)


def _version(flight_sw_version: int, capabilities: int) -> AutopilotVersion:
    parts = (flight_sw_version >> shift & 0xFF for shift in (24, 16, 8))
    return AutopilotVersion(".".join(map(str, parts)), capabilities)


def _mission_item(
    seq: int, command: int, frame: int, x: int, y: int, z: float, again: int, kind: int, *params: float
) -> MissionItem:
    p1, p2, p3, p4 = params
    return MissionItem(seq, command, frame, (p1, p2, p3, p4), x, y, z, bool(again), kind)


_WHOLE: dict[Any, type[Message]] = {
    mavlink.MAVLink_local_position_ned_message: LocalPosition,
    mavlink.MAVLink_attitude_message: Attitude,
}

_SOME_FIELDS: tuple[tuple[Any, str, Callable[..., Message]], ...] = (
    (
        mavlink.MAVLink_sys_status_message,
        "battery_remaining",
        lambda pct: SysStatus(pct if pct >= 0 else None),
    ),
    (mavlink.MAVLink_extended_sys_state_message, "landed_state", ExtendedSysState),
    (
        mavlink.MAVLink_gps_raw_int_message,
        "fix_type lat lon",
        lambda fix_type, lat, lon: GpsFix(fix_type, lat / 1e7, lon / 1e7),
    ),
    (
        mavlink.MAVLink_gps_global_origin_message,
        "latitude longitude altitude",
        lambda lat, lon, alt: Origin(lat / 1e7, lon / 1e7, alt / 1e3),
    ),
    (
        mavlink.MAVLink_home_position_message,
        "latitude longitude altitude",
        lambda lat, lon, alt: Home(lat / 1e7, lon / 1e7, alt / 1e3),
    ),
    (
        mavlink.MAVLink_global_position_int_message,
        "time_boot_ms lat lon alt",
        lambda ms, lat, lon, alt: GlobalPosition(ms, lat / 1e7, lon / 1e7, alt / 1e3),
    ),
    (
        mavlink.MAVLink_camera_image_captured_message,
        "time_boot_ms image_index capture_result",
        lambda ms, index, result: ImageCaptured(ms, index, result == 1),
    ),
    (  # ArduPilot's own word for a picture, beyond the common dialect
        ardupilotmega.MAVLink_camera_feedback_message,
        "time_usec img_idx",
        lambda us, index: ImageCaptured(us // 1000, index, taken=True),
    ),
    (mavlink.MAVLink_command_ack_message, "command result", CommandAck),
    (mavlink.MAVLink_autopilot_version_message, "flight_sw_version capabilities", _version),
    (
        mavlink.MAVLink_statustext_message,
        "severity text",
        lambda severity, text: StatusText(severity, _text(text)),
    ),
    (
        mavlink.MAVLink_param_value_message,
        "param_id param_value param_type",
        lambda name, raw, kind: ParamValue(_text(name), raw, kind),
    ),
    (mavlink.MAVLink_mission_count_message, "count mission_type", MissionCount),
    (mavlink.MAVLink_mission_request_message, "seq mission_type", MissionRequest),
    (mavlink.MAVLink_mission_request_int_message, "seq mission_type", MissionRequest),
    (
        mavlink.MAVLink_mission_item_int_message,
        "seq command frame x y z autocontinue mission_type param1 param2 param3 param4",
        _mission_item,
    ),
    (mavlink.MAVLink_mission_ack_message, "type mission_type", MissionAck),
)


def _kinds() -> dict[bytes, Kind]:
    values: dict[Any, _Value] = {mavlink.MAVLink_heartbeat_message: _heartbeat}
    values |= {described: _as_they_are(described, kind) for described, kind in _WHOLE.items()}
    values |= {described: _taking(described, names, make) for described, names, make in _SOME_FIELDS}
    return {
        described.id.to_bytes(3, "little"): Kind(
            described.id, bytes((described.crc_extra,)), values.get(described)
        )
        for described in {*mavlink.mavlink_map.values(), *values}
    }


KINDS = _kinds()
"""By message id as it stands in a MAVLink 2 frame: the common dialect, and what else is of use to us."""
