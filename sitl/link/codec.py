"""MAVLink bytes to messages and back, sans-I/O: what pymavlink accepts and what pymavlink emits, but faster.

Framing, MAVLink 1 and signatures are pymavlink's; payloads are read and written here from pymavlink's tables
(`messages`). A datagram of whole, unsigned MAVLink 2 frames, as almost all are, is walked in place. Whatever
is left of it goes through pymavlink's parser, so that the same frames are accepted and lost as there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from struct import Struct
from typing import NamedTuple

from pymavlink.dialects.v20 import common

from sitl.link.messages import Message, layout

__all__ = ["Codec", "CodecState", "Received"]

_HEADER = Struct("<BBBBBBBHB")
_MAGIC = 0xFD
_MAGIC_V1 = 0xFE
_HEADER_LENGTH = 10
_HEADER_LENGTH_V1 = 6
_CHECKSUM_LENGTH = 2
_crc: Callable[[bytes, int], int] = getattr(common, "mcrf4xx", None) or (
    lambda data, _: common.x25crc(data).crc
)
"""CRC-16/MCRF4XX: in C where pymavlink has it."""


class Received(NamedTuple):
    """A message and who sent it. The message is None when the dialect does not know its number."""

    message: Message
    system: int
    component: int


@dataclass(frozen=True, slots=True)
class CodecState:
    """All that a codec remembers: its sequence number, a frame's first part, its counts."""

    sequence: int = 0
    pending: bytes = b""
    received: int = 0
    rejected: int = 0


class Codec:
    """One end of a MAVLink stream. Garbage is counted and skipped; less than a frame of it is kept."""

    def __init__(self, system: int, component: int) -> None:
        self.system = system
        self.component = component
        self._parser = _Parser()
        self._sequence = 0
        self._pending = b""
        self._received = 0
        self._rejected = 0

    def encode(self, message: Message, sender: tuple[int, int] | None = None) -> bytes:
        """The MAVLink 2 frame that carries the message; `sender` when it is passed on for another."""
        payload: bytes = message.LAYOUT.pack(message)
        payload = payload.rstrip(b"\0") or payload[:1]
        system, component = sender or (self.system, self.component)
        low, high = message.ID & 0xFFFF, message.ID >> 16
        header = _HEADER.pack(_MAGIC, len(payload), 0, 0, self._sequence, system, component, low, high)
        frame = header + payload
        self._sequence = (self._sequence + 1) & 0xFF
        return frame + _checksum(frame, message.LAYOUT.crc_extra)

    def decode(self, data: bytes) -> list[Received]:
        """The messages that these bytes complete."""
        messages: list[Received] = []
        begin = 0
        if not self._pending:
            size = len(data)
            while (
                size - begin >= _HEADER_LENGTH + _CHECKSUM_LENGTH
                and data[begin] == _MAGIC
                and not data[begin + 2]
            ):
                end = begin + _HEADER_LENGTH + data[begin + 1] + _CHECKSUM_LENGTH
                if end > size:
                    break
                try:
                    messages.append(_decode(data[begin:end]))
                except common.MAVError:
                    self._rejected += 1
                begin = end
        if begin < len(data):
            messages.extend(self._parse(data[begin:]))
        self._received += len(messages)
        return messages

    def _parse(self, data: bytes) -> list[Received]:
        parser = self._parser
        parser.buf, parser.buf_index = bytearray(self._pending + data), 0
        messages: list[Received] = []
        while (message := parser.parse_char(b"")) is not None:
            if isinstance(message, Received):
                messages.append(message)
            else:
                self._rejected += 1
        self._pending = bytes(parser.buf[parser.buf_index :])
        return messages

    @property
    def received(self) -> int:
        """How many frames were accepted, known or not."""
        return self._received

    @property
    def rejected(self) -> int:
        """How many stretches of garbage and broken frames were skipped."""
        return self._rejected

    def snapshot(self) -> CodecState:
        """All that this codec remembers."""
        return CodecState(self._sequence, self._pending, self._received, self._rejected)

    def restore(self, state: CodecState) -> None:
        """Go on from a snapshot."""
        self._sequence = state.sequence
        self._pending = state.pending
        self._received = state.received
        self._rejected = state.rejected


class _Parser(common.MAVLink):  # type: ignore[misc]
    """pymavlink's framing around the decoder of this module."""

    def __init__(self) -> None:
        super().__init__(file=None)
        self.robust_parsing = True

    def decode(self, msgbuf: bytearray) -> Received:
        if msgbuf[0] == _MAGIC and not msgbuf[2]:
            return _decode(msgbuf)
        sender = super().decode(msgbuf)  # raises MAVError unless checksum and signature hold
        header_length = _HEADER_LENGTH_V1 if msgbuf[0] == _MAGIC_V1 else _HEADER_LENGTH
        payload = msgbuf[header_length : header_length + msgbuf[1]]
        known = layout(sender.get_msgId())
        message = None if known is None else known.unpack(payload)
        return Received(message, sender.get_srcSystem(), sender.get_srcComponent())


def _decode(frame: bytes | bytearray) -> Received:
    """What an unsigned MAVLink 2 frame carries. Raises: MAVError when its checksum is wrong."""
    _, _, _, _, _, system, component, low, high = _HEADER.unpack_from(frame)
    known = layout(low | high << 16)
    if known is None:
        return Received(None, system, component)
    if _checksum(frame[:-_CHECKSUM_LENGTH], known.crc_extra) != frame[-_CHECKSUM_LENGTH:]:
        raise common.MAVError("checksum")
    return Received(known.unpack(frame[_HEADER_LENGTH:-_CHECKSUM_LENGTH]), system, component)


def _checksum(frame: bytes | bytearray, crc_extra: bytes) -> bytes:
    return _crc(bytes(frame[1:]) + crc_extra, 0xFFFF).to_bytes(_CHECKSUM_LENGTH, "little")
