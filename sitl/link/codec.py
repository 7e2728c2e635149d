"""MAVLink bytes to messages and back, sans-I/O: what pymavlink accepts and what pymavlink emits, but faster.

MAVLink 1 and signatures are pymavlink's; payloads are read and written here from pymavlink's tables
(`messages`). A datagram of whole, unsigned MAVLink 2 frames, as almost all are, is walked in place. Whatever
is left of it is searched for frames byte by byte: a false start byte costs none of the frames behind it,
where pymavlink's parser swallows as much as the false header promises.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from struct import Struct
from typing import NamedTuple

from pymavlink.dialects.v20 import common

from sitl.link.frames import CHECKSUM_N, HEADER_N, HEADER_V1_N, MAGIC, MAGIC_V1, SIGNED, size_of
from sitl.link.messages import Layout, Message, layout
from sitl.link.signing import Signer

__all__ = ["Codec", "CodecState", "Received"]

_MAGIC = bytes((MAGIC,))
_HEADER = Struct("<BBBBBB3s")
"""The header behind its first byte, which is not part of the checksum."""
_SENDER, _SENDER_AT = Struct("<BBHB"), 5
"""The header's end: system, component and the message's number."""
_START = re.compile(b"[\xfd\xfe]")
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
    """One end of a MAVLink stream. Garbage is counted and skipped; less than a frame of it is kept.

    With a `signer`, every frame that goes out is signed and none comes in that it does not accept.
    """

    def __init__(self, system: int, component: int, signer: Signer | None = None) -> None:
        self.system = system
        self.component = component
        self._signer = signer
        self._rare = common.MAVLink(None)
        self._sequence = 0
        self._pending = b""
        self._received = 0
        self._rejected = 0

    def encode(self, message: Message, sender: tuple[int, int] | None = None) -> bytes:
        """The MAVLink 2 frame that carries the message; `sender` when it is passed on for another."""
        known: Layout = message.LAYOUT
        values = message if known.spans is None else known.flat(message)
        payload = known.packer.pack(*values).rstrip(b"\0") or b"\0"
        system, component = sender or (self.system, self.component)
        flags = 0 if self._signer is None else SIGNED
        header = _HEADER.pack(len(payload), flags, 0, self._sequence, system, component, known.number)
        self._sequence = (self._sequence + 1) & 0xFF
        body = header + payload
        crc = _crc(body + known.crc_extra, 0xFFFF)
        frame = _MAGIC + body + crc.to_bytes(CHECKSUM_N, "little")
        return frame if self._signer is None else self._signer.sign(frame)

    def decode(self, data: bytes) -> list[Received]:
        """The messages that these bytes complete."""
        messages: list[Received] = []
        begin = 0
        if not self._pending and self._signer is None:
            size = len(data)
            while size - begin >= HEADER_N + CHECKSUM_N and data[begin] == MAGIC and not data[begin + 2]:
                end = begin + HEADER_N + data[begin + 1] + CHECKSUM_N
                if end > size:
                    break
                received = _decode(data, begin, end)
                if received is None or received.message is None:
                    break
                messages.append(received)
                begin = end
        if begin < len(data):
            messages.extend(self._search(self._pending + data[begin:]))
        self._received += len(messages)
        return messages

    def _search(self, data: bytes) -> list[Received]:
        """The frames among whatever else is there. What may still become one is kept.

        Nobody can check a frame whose number the dialect does not know. It counts as one when another frame
        seems to follow it and none that can be checked begins inside it.
        """
        messages: list[Received] = []
        at = accepted_to = searched_to = 0
        while (start := _START.search(data, at)) is not None:
            at = start.start()
            end = at + _size(data, at)
            if end > len(data):
                break
            received = self._read(data[at:end])
            if received is not None and received.message is None:
                searched_to = self._next_sure(data, max(searched_to, at + 1), end)
                if searched_to < end:
                    received = None
                elif end == len(data):
                    break
                elif not _START.match(data, end):
                    received = None
            if received is None:
                at += 1
                continue
            if self._signer is None or self._signer.accepts(data[at:end]):
                messages.append(received)
            self._rejected += at > accepted_to
            at = accepted_to = end
        else:
            at = len(data)
        self._rejected += at > accepted_to
        self._pending = data[at:]
        return messages

    def _next_sure(self, data: bytes, begin: int, end: int) -> int:
        """Where the first frame begins that has come whole and whose checksum holds; `end` if none does."""
        for start in _START.finditer(data, begin, end):
            at = start.start()
            received = self._read(data[at : at + _size(data, at)])
            if received is not None and received.message is not None:
                return at
        return max(begin, end)

    def _read(self, frame: bytes) -> Received | None:
        """What a frame carries; None when it is none, or not whole."""
        if not frame or len(frame) < _size(frame, 0):
            return None
        if frame[0] == MAGIC and not frame[2]:
            return _decode(frame, 0, len(frame))
        try:
            sender = self._rare.decode(bytearray(frame))
        except common.MAVError:
            return None
        begin = HEADER_V1_N if frame[0] == MAGIC_V1 else HEADER_N
        known = layout(sender.get_msgId())
        message = None if known is None else known.unpack(frame[begin : begin + frame[1]])
        return Received(message, sender.get_srcSystem(), sender.get_srcComponent())

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


def _size(data: bytes, at: int) -> int:
    """How long the frame is that begins there, as `size_of` has it; zero when its header is impossible."""
    flags = data[at + 2 : at + 3]
    return 0 if data[at] == MAGIC and flags and flags[0] & ~SIGNED else size_of(data, at)


def _decode(data: bytes, begin: int, end: int) -> Received | None:
    """What the unsigned MAVLink 2 frame there carries; None when its checksum is wrong."""
    system, component, low, high = _SENDER.unpack_from(data, begin + _SENDER_AT)
    known = layout(low | high << 16)
    if known is None:
        return Received(None, system, component)
    tail = end - CHECKSUM_N
    crc: int = _crc(data[begin + 1 : tail] + known.crc_extra, 0xFFFF)
    if crc != data[tail] | data[tail + 1] << 8:
        return None
    return Received(known.unpack(data[begin + HEADER_N : tail]), system, component)
