"""MAVLink bytes to whole frames and what they say, whatever garbage is between them.

pymavlink checks and decodes all that is rare. What comes fifty times a second is decoded here from its own metadata,
which costs a tenth of building its objects; tests hold both equal.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from operator import itemgetter
from typing import Any

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

__all__ = ["CHECKSUM_N", "UNCHECKED", "Decoder", "crc", "header"]

CHECKSUM_N = 2
UNCHECKED = object()
"""The value of a message beyond the dialect, whose checksum nobody here can know."""

_V2, _V1 = 0xFD, 0xFE
_START = re.compile(b"[\xfd\xfe]", re.DOTALL)
_INVALID = object()
_HEADER_N = 10
crc: Callable[[bytes, int], int] = getattr(mavlink, "mcrf4xx", None) or (
    lambda data, _: mavlink.x25crc(data).crc
)
"""CRC-16/MCRF4XX: in C where pymavlink has it."""


class Decoder:
    """`frames(bytes) -> (frame, value) …`: a `Message`, None where it is of no use to us, or `UNCHECKED`.

    `garbage_n` bytes began no frame.
    """

    def __init__(self) -> None:
        self.garbage_n = 0
        self._rest = b""
        self._parser = _Parser(None)

    def frames(self, data: bytes) -> Iterator[tuple[bytes, object]]:
        """The frames in what has come so far, with their values.

        A start byte that begins no frame costs one byte, not the frames behind it: the search goes on at the
        very next. pymavlink's own would swallow as many bytes as the false header promised.
        """
        buffer = self._rest + data
        at, came_to = 0, len(buffer)
        while at < came_to:
            if buffer[at] != _V2:
                start = _START.search(buffer, at)
                skipped_to = came_to if start is None else start.start()
                self.garbage_n += skipped_to - at
                at = skipped_to
                if start is None:
                    break
            end = at + _size(buffer, at)
            if end > came_to:
                break
            frame = buffer[at:end]
            value = self._parser.value(frame) if end > at else _INVALID
            if value is UNCHECKED and end < came_to and not _START.match(buffer, end):
                value = _INVALID
            if value is _INVALID:
                self.garbage_n += 1
                at += 1
            else:
                at = end
                yield frame, value
        self._rest = buffer[at:]


class _Parser(mavlink.MAVLink):  # type: ignore[misc]
    """pymavlink's decoder, with a short way for the hot messages."""

    def value(self, frame: bytes) -> object:
        """What we make of a frame: a `Message`, None where it is of no use, `UNCHECKED` or `_INVALID`."""
        message_id = frame[7] | frame[8] << 8 | frame[9] << 16 if frame[0] == _V2 else None
        hot = _HOT.get(message_id)
        if hot is None or frame[2]:
            try:
                message = self.decode(bytearray(frame))
            except mavlink.MAVError:
                return _INVALID
            if isinstance(message, mavlink.MAVLink_unknown):
                return UNCHECKED
            convert = _RARE.get(message.get_type())
            return convert(message) if convert else None
        make, described, crc_extra = hot
        if crc(frame[1:-CHECKSUM_N] + crc_extra, 0xFFFF) != frame[-2] | frame[-1] << 8:
            return _INVALID
        size = described.unpacker.size
        return make(described.unpacker.unpack_from(frame[_HEADER_N:-CHECKSUM_N].ljust(size, b"\0")))


def _size(buffer: bytes, at: int) -> int:
    """The size of the frame whose start byte is at `at`; 0 if its header is impossible.

    While the header is incomplete, that of the smallest frame.
    """
    if buffer[at] == _V1:
        return 8 + (buffer[at + 1] if at + 1 < len(buffer) else 0)
    if at + 2 >= len(buffer):
        return 12
    if buffer[at + 2] & ~mavlink.MAVLINK_IFLAG_SIGNED:
        return 0
    signature_n = mavlink.MAVLINK_SIGNATURE_BLOCK_LEN if buffer[at + 2] else 0
    return 12 + buffer[at + 1] + signature_n


def header(frame: bytes) -> tuple[int, int, int, int]:
    """Message id, system, component and sequence number of a MAVLink 2 or 1 frame."""
    if frame[0] == _V2:
        return frame[7] | frame[8] << 8 | frame[9] << 16, frame[5], frame[6], frame[4]
    return frame[5], frame[3], frame[4], frame[2]


def _heartbeat(m: mavlink.MAVLink_message) -> Heartbeat:
    armed = bool(m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    source = m.get_srcSystem(), m.get_srcComponent()
    return Heartbeat(*source, m.autopilot, armed, m.custom_mode, m.system_status)


def _version(m: mavlink.MAVLink_message) -> AutopilotVersion:
    parts = (m.flight_sw_version >> shift & 0xFF for shift in (24, 16, 8))
    return AutopilotVersion(".".join(map(str, parts)), m.capabilities)


def _mission_item(m: mavlink.MAVLink_message) -> MissionItem:
    params = (m.param1, m.param2, m.param3, m.param4)
    return MissionItem(m.seq, m.command, m.frame, params, m.x, m.y, m.z, bool(m.autocontinue), m.mission_type)


def _on_wire(described: Any, *names: str) -> Callable[[tuple[Any, ...]], Any]:
    """Takes these fields out of a message's values, which are in their order on the wire."""
    return itemgetter(*map(described.ordered_fieldnames.index, names))


_FIX = _on_wire(mavlink.MAVLink_gps_raw_int_message, "fix_type", "lat", "lon")
_LANDED = _on_wire(mavlink.MAVLink_extended_sys_state_message, "landed_state")
_REMAINING = _on_wire(mavlink.MAVLink_sys_status_message, "battery_remaining")
_ANSWER = _on_wire(mavlink.MAVLink_command_ack_message, "command", "result")


def _gps_fix(values: tuple[Any, ...]) -> GpsFix:
    fix_type, lat, lon = _FIX(values)
    return GpsFix(fix_type, lat / 1e7, lon / 1e7)


def _extended_sys_state(values: tuple[Any, ...]) -> ExtendedSysState:
    return ExtendedSysState(_LANDED(values))


def _sys_status(values: tuple[Any, ...]) -> SysStatus:
    remaining_pct = _REMAINING(values)
    return SysStatus(remaining_pct if remaining_pct >= 0 else None)


def _command_ack(values: tuple[Any, ...]) -> CommandAck:
    return CommandAck(*_ANSWER(values))


def _camera_feedback(values: tuple[Any, ...]) -> ImageCaptured:
    """ArduPilot's own word for a picture, in its order on the wire; the common dialect does not know it."""
    time_us, image_index = values[0], values[9]
    return ImageCaptured(time_us // 1000, image_index, taken=True)


_HOT: dict[int | None, tuple[Callable[..., Message], Any, bytes]] = {
    described.id: (make, described, bytes((described.crc_extra,)))
    for make, described in (
        (LocalPosition._make, mavlink.MAVLink_local_position_ned_message),
        (Attitude._make, mavlink.MAVLink_attitude_message),
        (_gps_fix, mavlink.MAVLink_gps_raw_int_message),
        (_extended_sys_state, mavlink.MAVLink_extended_sys_state_message),
        (_sys_status, mavlink.MAVLink_sys_status_message),
        (_command_ack, mavlink.MAVLink_command_ack_message),
        (_camera_feedback, ardupilotmega.MAVLink_camera_feedback_message),
    )
}

_RARE: dict[str, Callable[[Any], Message]] = {
    "HEARTBEAT": _heartbeat,
    "SYS_STATUS": lambda m: SysStatus(m.battery_remaining if m.battery_remaining >= 0 else None),
    "EXTENDED_SYS_STATE": lambda m: ExtendedSysState(m.landed_state),
    "GPS_GLOBAL_ORIGIN": lambda m: Origin(m.latitude / 1e7, m.longitude / 1e7, m.altitude / 1e3),
    "HOME_POSITION": lambda m: Home(m.latitude / 1e7, m.longitude / 1e7, m.altitude / 1e3),
    "GLOBAL_POSITION_INT": lambda m: GlobalPosition(m.time_boot_ms, m.lat / 1e7, m.lon / 1e7, m.alt / 1e3),
    "GPS_RAW_INT": lambda m: GpsFix(m.fix_type, m.lat / 1e7, m.lon / 1e7),
    "CAMERA_IMAGE_CAPTURED": lambda m: ImageCaptured(m.time_boot_ms, m.image_index, m.capture_result == 1),
    "COMMAND_ACK": lambda m: CommandAck(m.command, m.result),
    "AUTOPILOT_VERSION": _version,
    "STATUSTEXT": lambda m: StatusText(m.severity, m.text),
    "PARAM_VALUE": lambda m: ParamValue(m.param_id, m.param_value, m.param_type),
    "MISSION_COUNT": lambda m: MissionCount(m.count, m.mission_type),
    "MISSION_REQUEST": lambda m: MissionRequest(m.seq, m.mission_type),
    "MISSION_REQUEST_INT": lambda m: MissionRequest(m.seq, m.mission_type),
    "MISSION_ITEM_INT": _mission_item,
    "MISSION_ACK": lambda m: MissionAck(m.type, m.mission_type),
    "LOCAL_POSITION_NED": lambda m: LocalPosition(m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz),
    "ATTITUDE": lambda m: Attitude(
        m.time_boot_ms, m.roll, m.pitch, m.yaw, m.rollspeed, m.pitchspeed, m.yawspeed
    ),
}
