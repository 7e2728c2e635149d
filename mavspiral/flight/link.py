"""MAVLink 2 bytes to values and values to bytes, without a socket: the streamer's one contact with pymavlink.

We are system 245, component 191, a MAV_TYPE_ONBOARD_CONTROLLER without an autopilot. pymavlink frames and
checks everything. The messages that fly fifty times a second are decoded and packed here from pymavlink's own
metadata, which costs a tenth of building its objects; tests hold both equal to pymavlink's, byte for byte.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.messages import (
    Attitude,
    AutopilotVersion,
    Command,
    CommandAck,
    ExtendedSysState,
    GlobalPosition,
    Heartbeat,
    LocalPosition,
    Message,
    Origin,
    ParamValue,
    StatusText,
    SysStatus,
    Target,
)

__all__ = ["COMPONENT_ID", "SYSTEM_ID", "Link"]

SYSTEM_ID = 245
COMPONENT_ID = 191  # MAV_COMP_ID_ONBOARD_COMPUTER
LATE_N = 32  # a sequence number this far behind the newest was overtaken; further behind, many were lost

_UNCHECKED = object()  # a message beyond the dialect, whose checksum nobody here can know
_HEADER_N = 10
_CHECKSUM_N = 2
_SETPOINT = mavlink.MAVLink_set_position_target_local_ned_message


class Link:
    """Both ends of one conversation: `receive(bytes) -> messages`, and a method for each frame that we send.

    Until `vehicle` is set only heartbeats come through; from then on, only the vehicle's own messages, each
    once and none after a newer one.

    Args:
        tap: is handed every whole frame, in and out, as it passes.
    """

    def __init__(self, tap: Callable[[bytes], None] | None = None) -> None:
        self.vehicle: tuple[int, int] | None = None
        self.arrivals: Counter[int] = Counter()  # of the vehicle's messages, by MAVLink message id
        self.garbage_n = 0
        self.late_n = 0
        self._tap = tap
        self._newest_seq: int | None = None
        self._parser = _Parser(None, SYSTEM_ID, COMPONENT_ID)
        self._parser.robust_parsing = True

    def receive(self, data: bytes) -> list[Message]:
        """The messages that `data` completes. Garbage is counted and skipped."""
        messages: list[Message] = []
        if not data:
            return messages
        for item in self._parser.parse_buffer(data) or ():
            if item.__class__ is not tuple:
                self.garbage_n += 1
                continue
            frame, value = item
            if self._tap is not None:
                self._tap(bytes(frame))
            if value is _UNCHECKED:
                continue
            message_id, system_id, component_id, seq = _header(frame)
            if self.vehicle is None:
                if isinstance(value, Heartbeat):
                    messages.append(value)
                continue
            if (system_id, component_id) != self.vehicle or self._is_late(seq):
                continue
            self.arrivals[message_id] += 1
            if value is not None:
                messages.append(value)
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

    def command(self, command: Command, *params: float) -> bytes:
        """A COMMAND_LONG to the vehicle; parameters that are not given are zero."""
        filled = (*params, *(0.0,) * (7 - len(params)))
        return self._pack(mavlink.MAVLink_command_long_message(*self._addressee, int(command), 0, *filled))

    def parameter_request(self, name: str) -> bytes:
        """A PARAM_REQUEST_READ by name."""
        return self._pack(
            mavlink.MAVLink_param_request_read_message(*self._addressee, name.encode("ascii"), -1)
        )

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
        checksum: int = mavlink.x25crc(body + bytes((_SETPOINT.crc_extra,))).crc
        return self._sent(b"\xfd" + body + checksum.to_bytes(_CHECKSUM_N, "little"))

    @property
    def _addressee(self) -> tuple[int, int]:
        if self.vehicle is None:
            raise RuntimeError("no vehicle to address: set `vehicle` from its heartbeat first")
        return self.vehicle

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
        if self._tap is not None:
            self._tap(frame)
        return frame


class _Parser(mavlink.MAVLink):  # type: ignore[misc]
    """pymavlink's parser, whose messages are `(frame, value)`; the value is None of what we do not use."""

    def decode(self, msgbuf: bytearray) -> tuple[bytearray, object]:
        message_id = msgbuf[7] | msgbuf[8] << 8 | msgbuf[9] << 16 if msgbuf[0] == 0xFD else -1
        hot = _HOT.get(message_id)
        if hot is None or msgbuf[2] or self.signing.secret_key is not None:
            message = super().decode(msgbuf)
            if isinstance(message, mavlink.MAVLink_unknown):
                return msgbuf, _UNCHECKED
            convert = _RARE.get(message.get_type())
            return msgbuf, convert(message) if convert else None
        make, described = hot
        checked = msgbuf[1:-_CHECKSUM_N]
        checked.append(described.crc_extra)
        if mavlink.x25crc(checked).crc != msgbuf[-2] | msgbuf[-1] << 8:
            raise mavlink.MAVError("checksum")
        size = described.unpacker.size
        payload = msgbuf[_HEADER_N:-_CHECKSUM_N].ljust(size, b"\0")
        return msgbuf, make(described.unpacker.unpack_from(payload))


def _header(frame: bytearray) -> tuple[int, int, int, int]:
    """Message id, system, component and sequence number of a MAVLink 2 or 1 frame."""
    if frame[0] == 0xFD:
        return frame[7] | frame[8] << 8 | frame[9] << 16, frame[5], frame[6], frame[4]
    return frame[5], frame[3], frame[4], frame[2]


def _heartbeat(m: mavlink.MAVLink_message) -> Heartbeat:
    armed = bool(m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    source = m.get_srcSystem(), m.get_srcComponent()
    return Heartbeat(*source, m.autopilot, armed, m.custom_mode, m.system_status)


def _version(m: mavlink.MAVLink_message) -> AutopilotVersion:
    parts = (m.flight_sw_version >> shift & 0xFF for shift in (24, 16, 8))
    return AutopilotVersion(".".join(map(str, parts)), m.capabilities)


_HOT: dict[int, tuple[Callable[..., Message], Any]] = {
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: (
        LocalPosition._make,
        mavlink.MAVLink_local_position_ned_message,
    ),
    mavlink.MAVLINK_MSG_ID_ATTITUDE: (Attitude._make, mavlink.MAVLink_attitude_message),
}

_RARE: dict[str, Callable[[Any], Message]] = {
    "HEARTBEAT": _heartbeat,
    "SYS_STATUS": lambda m: SysStatus(m.battery_remaining if m.battery_remaining >= 0 else None),
    "EXTENDED_SYS_STATE": lambda m: ExtendedSysState(m.landed_state),
    "GPS_GLOBAL_ORIGIN": lambda m: Origin(m.latitude / 1e7, m.longitude / 1e7, m.altitude / 1e3),
    "GLOBAL_POSITION_INT": lambda m: GlobalPosition(m.time_boot_ms, m.lat / 1e7, m.lon / 1e7, m.alt / 1e3),
    "COMMAND_ACK": lambda m: CommandAck(m.command, m.result),
    "AUTOPILOT_VERSION": _version,
    "STATUSTEXT": lambda m: StatusText(m.severity, m.text),
    "PARAM_VALUE": lambda m: ParamValue(m.param_id, m.param_value, m.param_type),
    "LOCAL_POSITION_NED": lambda m: LocalPosition(m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz),
    "ATTITUDE": lambda m: Attitude(
        m.time_boot_ms, m.roll, m.pitch, m.yaw, m.rollspeed, m.pitchspeed, m.yawspeed
    ),
}
