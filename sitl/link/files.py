"""MAVLink FTP on one link: what is asked for is answered, though there is little to read and nothing to write.

Source: mavlink.io, File Transfer Protocol. A file is whatever `open_file` makes of a path; one is open at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from struct import Struct
from typing import NamedTuple

from sitl.link.codec import Received
from sitl.link.messages import Message, message_type

__all__ = ["FILE_MESSAGE", "Files", "no_file"]

FILE_MESSAGE = message_type("FILE_TRANSFER_PROTOCOL")
_HEADER, _SIZE = Struct("<HBBBBBxI"), Struct("<I")
_PAYLOAD, _ROOM = 251, 239
_ACK, _NAK = 128, 129
_TERMINATE, _RESET, _LIST, _OPEN, _READ, _OPEN_TO_WRITE, _BURST = 1, 2, 3, 4, 5, 11, 15
_CHECKSUM = 14
_INVALID_DATA_SIZE, _INVALID_SESSION, _END, _UNKNOWN_COMMAND, _PROTECTED, _NOT_FOUND = 3, 4, 6, 7, 9, 10
_WRITES = (6, 7, 8, 9, 10, 12, 13)
_PACKETS = 8
"""Of a burst, a frame."""

OpenFile = Callable[[bytes], bytes | None]
"""What is in the file of that name; None: there is none."""


def no_file(_: bytes) -> None:
    """There is none."""


class _Request(NamedTuple):
    seq: int
    session: int
    opcode: int
    size: int
    req_opcode: int
    burst_complete: int
    offset: int


@dataclass(slots=True)
class Files:
    """The file that is open, and how far a burst has come. What it remembers are values: `replace` copies it."""

    content: bytes | None = None
    partner: tuple[int, int] = (0, 0)
    burst_at: int | None = None
    burst_size: int = _ROOM
    seq: int = 0
    session: int = 0

    def receive(self, received: Received, open_file: OpenFile) -> list[Message]:
        """The answer to a FILE_TRANSFER_PROTOCOL."""
        payload = bytes(received.message.payload)
        request = _Request._make(_HEADER.unpack_from(payload))
        data = payload[_HEADER.size : _HEADER.size + request.size]
        partner = received.system, received.component
        match request.opcode:
            case 0:
                return [_message(partner, request, _ACK)]
            case _ if request.opcode in (_TERMINATE, _RESET):
                self.content = self.burst_at = None
                return [_message(partner, request, _ACK)]
            case _ if request.opcode == _LIST:
                return [_refusal(partner, request, _END if data.rstrip(b"\0/") == b"" else _NOT_FOUND)]
            case _ if request.opcode == _OPEN:
                self.content, self.burst_at = open_file(data.rstrip(b"\0")), None
                if self.content is None:
                    return [_refusal(partner, request, _NOT_FOUND)]
                return [_message(partner, request, _ACK, _SIZE.pack(len(self.content)))]
            case _ if request.opcode in (_READ, _BURST):
                return self._read(partner, request)
            case _ if request.opcode in (*_WRITES, _OPEN_TO_WRITE):
                return [_refusal(partner, request, _PROTECTED)]
            case _ if request.opcode == _CHECKSUM:
                return [_refusal(partner, request, _NOT_FOUND)]
        return [_refusal(partner, request, _UNKNOWN_COMMAND)]

    @property
    def is_busy(self) -> bool:
        """Whether there is more of a burst to send."""
        return self.burst_at is not None

    def proceed(self) -> list[Message]:
        """What there is to send of a burst in this frame."""
        messages: list[Message] = []
        while self.burst_at is not None and len(messages) < _PACKETS:
            assert self.content is not None
            data = self.content[self.burst_at : self.burst_at + self.burst_size]
            request = _Request(self.seq, self.session, _BURST, 0, 0, 0, self.burst_at)
            self.seq = self.seq + 1 & 0xFFFF
            self.burst_at += len(data)
            if not data:
                self.burst_at = None
                messages.append(_refusal(self.partner, request, _END))
                continue
            last = self.burst_at >= len(self.content)
            messages.append(_message(self.partner, request, _ACK, data, burst_complete=last))
            self.burst_at = None if last else self.burst_at
        return messages

    def _read(self, partner: tuple[int, int], request: _Request) -> list[Message]:
        if self.content is None:
            return [_refusal(partner, request, _INVALID_SESSION)]
        if request.size > _ROOM:
            return [_refusal(partner, request, _INVALID_DATA_SIZE)]
        if request.opcode == _BURST:
            self.partner, self.burst_at = partner, request.offset
            self.seq, self.session = request.seq, request.session
            self.burst_size = request.size or _ROOM
            return []
        data = self.content[request.offset : request.offset + request.size]
        return [_message(partner, request, _ACK, data) if data else _refusal(partner, request, _END)]


def _message(
    partner: tuple[int, int],
    request: _Request,
    opcode: int,
    data: bytes = b"",
    *,
    burst_complete: bool = False,
) -> Message:
    header = _HEADER.pack(
        request.seq + 1 & 0xFFFF,
        request.session,
        opcode,
        len(data),
        request.opcode,
        int(burst_complete),
        request.offset,
    )
    payload = tuple((header + data).ljust(_PAYLOAD, b"\0"))
    return FILE_MESSAGE(0, *partner, payload)


def _refusal(partner: tuple[int, int], request: _Request, error: int) -> Message:
    return _message(partner, request, _NAK, bytes([error]))
