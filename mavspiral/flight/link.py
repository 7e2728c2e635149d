"""MAVLink 2 bytes to values and values to bytes, without a socket: the streamer's one contact with pymavlink.

We are system 245, component 191, a MAV_TYPE_ONBOARD_CONTROLLER without an autopilot. pymavlink checks and
decodes all that is rare. The messages that fly fifty times a second are decoded and packed here from its own
metadata, which costs a tenth of building its objects; tests hold both equal to pymavlink's, byte for byte.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.messages import (
    Attitude,
    AutopilotVersion,
    Command,
    CommandAck,
    ExtendedSysState,
    GlobalPosition,
    Heartbeat,
    Home,
    ImageCaptured,
    LocalPosition,
    Message,
    MissionAck,
    MissionCount,
    MissionItem,
    MissionRequest,
    Origin,
    ParamValue,
    StatusText,
    SysStatus,
    Target,
)
from mavspiral.flight.signing import SIGNED, Signer

__all__ = ["COMPONENT_ID", "SYSTEM_ID", "Link"]

SYSTEM_ID = 245
COMPONENT_ID = 191  # MAV_COMP_ID_ONBOARD_COMPUTER
LATE_N = 32  # a sequence number this far behind the newest was overtaken; further behind, many were lost

_V2, _V1 = 0xFD, 0xFE
_START = re.compile(b"[\xfd\xfe]", re.DOTALL)
_UNCHECKED = object()  # a message beyond the dialect, whose checksum nobody here can know
_INVALID = object()
_HEADER_N = 10
_CHECKSUM_N = 2
_SETPOINT = mavlink.MAVLink_set_position_target_local_ned_message
_crc: Callable[[bytes, int], int] = getattr(mavlink, "mcrf4xx", None) or (
    lambda data, _: mavlink.x25crc(data).crc
)
"""CRC-16/MCRF4XX: in C where pymavlink has it."""


class Link:
    """Both ends of one conversation: `receive(bytes) -> messages`, and a method for each frame that we send.

    Until `vehicle` is set only heartbeats come through; from then on, only the vehicle's own messages, each
    once and none after a newer one.

    Args:
        tap: is handed every whole frame, in and out, as it passes.
        signer: signs all that goes out; what it does not accept has not come in.
    """

    def __init__(self, tap: Callable[[bytes], None] | None = None, signer: Signer | None = None) -> None:
        self.vehicle: tuple[int, int] | None = None
        self.arrivals: Counter[int] = Counter()  # of the vehicle's messages, by MAVLink message id
        self.garbage_n = 0  # bytes
        self.late_n = 0
        self._tap = tap
        self._signer = signer
        self._newest_seq: int | None = None
        self._rest = b""
        self._parser = _Parser(None, SYSTEM_ID, COMPONENT_ID)

    def receive(self, data: bytes) -> list[Message]:
        """The messages that `data` completes. Garbage is counted and skipped."""
        messages: list[Message] = []
        for frame, value in self._frames(data):
            if self._tap is not None:
                self._tap(frame)
            if self._signer is not None and not self._signer.accepts(frame):
                continue
            if value is _UNCHECKED:
                continue
            message_id, system_id, component_id, seq = _header(frame)
            if self.vehicle is None:
                if isinstance(value, Heartbeat):
                    messages.append(value)
                continue
            if (system_id, component_id) != self.vehicle:
                if system_id == self.vehicle[0] and isinstance(value, (CommandAck, ImageCaptured)):
                    messages.append(value)  # its camera's
                continue
            if self._is_late(seq):
                continue
            self.arrivals[message_id] += 1
            if value is not None:
                messages.append(value)  # type: ignore[arg-type]
        return messages

    def heartbeat(self) -> bytes:
        """Our HEARTBEAT."""
        return self._pack(
            mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
                mavlink.MAV_AUTOPILOT_INVALID,
                0,
                0,
                mavlink.MAV_STATE_ACTIVE,
                3,
            )
        )

    def command(self, command: Command, *params: float, component: int | None = None) -> bytes:
        """A COMMAND_LONG to the vehicle or another `component` of it; parameters that are not given are zero."""
        filled = (*params, *(0.0,) * (7 - len(params)))
        system_id, autopilot_id = self._addressee
        to = system_id, autopilot_id if component is None else component
        return self._pack(mavlink.MAVLink_command_long_message(*to, int(command), 0, *filled))

    def parameter_request(self, name: str) -> bytes:
        """A PARAM_REQUEST_READ by name."""
        return self._pack(
            mavlink.MAVLink_param_request_read_message(*self._addressee, name.encode("ascii"), -1)
        )

    def parameter_set(self, name: str, raw: float, param_type: int) -> bytes:
        """A PARAM_SET."""
        return self._pack(
            mavlink.MAVLink_param_set_message(*self._addressee, name.encode("ascii"), raw, param_type)
        )

    def mission_count(self, count: int, kind: int) -> bytes:
        """A MISSION_COUNT: the offer of an upload."""
        return self._pack(mavlink.MAVLink_mission_count_message(*self._addressee, count, kind))

    def mission_item(self, item: MissionItem) -> bytes:
        """A MISSION_ITEM_INT; the first one is the current one."""
        return self._pack(
            mavlink.MAVLink_mission_item_int_message(
                *self._addressee,
                item.seq,
                item.frame,
                item.command,
                int(item.seq == 0),
                int(item.autocontinue),
                *item.params,
                item.x,
                item.y,
                item.z,
                item.kind,
            )
        )

    def mission_list_request(self, kind: int) -> bytes:
        """A MISSION_REQUEST_LIST: how many items are there?"""
        return self._pack(mavlink.MAVLink_mission_request_list_message(*self._addressee, kind))

    def mission_request(self, seq: int, kind: int) -> bytes:
        """A MISSION_REQUEST_INT for one item."""
        return self._pack(mavlink.MAVLink_mission_request_int_message(*self._addressee, seq, kind))

    def mission_ack(self, kind: int) -> bytes:
        """A MISSION_ACK: all items of a download have come."""
        return self._pack(mavlink.MAVLink_mission_ack_message(*self._addressee, 0, kind))

    def setpoint(self, time_boot_ms: int, target: Target, *, type_mask: int, coordinate_frame: int) -> bytes:
        """A SET_POSITION_TARGET_LOCAL_NED, packed straight from the dialect's own format."""
        payload = _SETPOINT.unpacker.pack(
            time_boot_ms & 0xFFFFFFFF,
            *target.position_ned_m,
            *target.velocity_ned_mps,
            *target.acceleration_ned_mps2,
            target.yaw_ned_rad,
            target.yaw_rate_ned_radps,
            type_mask,
            *self._addressee,
            coordinate_frame,
        ).rstrip(b"\0")
        body = bytes((len(payload), 0, 0, self._parser.seq, SYSTEM_ID, COMPONENT_ID, _SETPOINT.id, 0, 0)) + (
            payload or b"\0"
        )
        checksum = _crc(body + bytes((_SETPOINT.crc_extra,)), 0xFFFF).to_bytes(_CHECKSUM_N, "little")
        return self._sent(b"\xfd" + body + checksum)

    @property
    def refused_n(self) -> int:
        """How many frames were not signed as they must be."""
        return 0 if self._signer is None else self._signer.refused_n

    @property
    def _addressee(self) -> tuple[int, int]:
        if self.vehicle is None:
            raise RuntimeError("no vehicle to address: set `vehicle` from its heartbeat first")
        return self.vehicle

    def _frames(self, data: bytes) -> Iterator[tuple[bytes, object]]:
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
            if value is _UNCHECKED and end < came_to and not _START.match(buffer, end):
                value = _INVALID
            if value is _INVALID:
                self.garbage_n += 1
                at += 1
            else:
                at = end
                yield frame, value
        self._rest = buffer[at:]

    def _is_late(self, seq: int) -> bool:
        if self._newest_seq is not None and (self._newest_seq - seq) % 256 < LATE_N:
            self.late_n += 1
            return True
        self._newest_seq = seq
        return False

    def _pack(self, message: mavlink.MAVLink_message) -> bytes:
        return self._sent(message.pack(self._parser))

    def _sent(self, frame: bytes) -> bytes:
        self._parser.seq = (self._parser.seq + 1) % 256
        if self._signer is not None:
            frame = self._signer.sign(_flagged(frame))
        if self._tap is not None:
            self._tap(frame)
        return frame


class _Parser(mavlink.MAVLink):  # type: ignore[misc]
    """pymavlink's decoder, with a short way for the hot messages."""

    def value(self, frame: bytes) -> object:
        """What we make of a frame: a `Message`, None where it is of no use, `_UNCHECKED` or `_INVALID`."""
        message_id = frame[7] | frame[8] << 8 | frame[9] << 16 if frame[0] == _V2 else None
        hot = _HOT.get(message_id)
        if hot is None or frame[2] or self.signing.secret_key is not None:
            try:
                message = self.decode(bytearray(frame))
            except mavlink.MAVError:
                return _INVALID
            if isinstance(message, mavlink.MAVLink_unknown):
                return _UNCHECKED
            convert = _RARE.get(message.get_type())
            return convert(message) if convert else None
        make, described, crc_extra = hot
        if _crc(frame[1:-_CHECKSUM_N] + crc_extra, 0xFFFF) != frame[-2] | frame[-1] << 8:
            return _INVALID
        size = described.unpacker.size
        return make(described.unpacker.unpack_from(frame[_HEADER_N:-_CHECKSUM_N].ljust(size, b"\0")))


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


def _flagged(frame: bytes) -> bytes:
    """A MAVLink 2 frame of ours that says that it is signed; its signature is still to come."""
    body = frame[1:2] + bytes((SIGNED,)) + frame[3:-_CHECKSUM_N]
    crc_extra = mavlink.mavlink_map[_header(frame)[0]].crc_extra
    checksum: int = mavlink.x25crc(body + bytes((crc_extra,))).crc
    return frame[:1] + body + checksum.to_bytes(_CHECKSUM_N, "little")


def _header(frame: bytes) -> tuple[int, int, int, int]:
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


def _camera_feedback(values: tuple[Any, ...]) -> ImageCaptured:
    """ArduPilot's own word for a picture, in its order on the wire; the common dialect does not know it."""
    time_us, image_index = values[0], values[9]
    return ImageCaptured(time_us // 1000, image_index, taken=True)


_HOT: dict[int | None, tuple[Callable[..., Message], Any, bytes]] = {
    described.id: (make, described, bytes((described.crc_extra,)))
    for make, described in (
        (LocalPosition._make, mavlink.MAVLink_local_position_ned_message),
        (Attitude._make, mavlink.MAVLink_attitude_message),
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
