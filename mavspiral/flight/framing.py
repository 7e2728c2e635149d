"""MAVLink bytes to whole frames, whatever garbage is between them."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable

from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.decoding import KINDS, Kind, sender

__all__ = ["CHECKSUM_N", "Decoder", "Frame", "crc"]

CHECKSUM_N = 2

_V2, _V1 = 0xFD, 0xFE
_START = re.compile(b"[\xfd\xfe]", re.DOTALL)
_HEADER = struct.Struct("<BBBxBBB3s").unpack_from
"""Of MAVLink 2: start, payload, flags, sequence, system, component, id."""
_LEAST_N = 12  # of a MAVLink 2 frame: its header and its checksum
_SIGNATURE_N = mavlink.MAVLINK_SIGNATURE_BLOCK_LEN
crc: Callable[[bytes, int], int] = getattr(mavlink, "mcrf4xx", None) or (
    lambda data, _: mavlink.x25crc(data).crc
)
"""CRC-16/MCRF4XX: in C where pymavlink has it."""

Frame = tuple[bytes, Kind | None, int, int, int]
"""A whole frame, its kind, its sequence number, and the system and the component that sent it."""


class Decoder:
    """`frames(bytes)` gives the whole frames in what has come so far, each with its kind.

    The kind is None beyond the dialect, where nobody here knows the checksum. `garbage_n` bytes began no frame.
    """

    def __init__(self) -> None:
        self.garbage_n = 0
        self._rest = b""

    def frames(self, data: bytes) -> list[Frame]:
        """The frames that `data` completes.

        A start byte that begins no frame costs one byte, not the frames behind it: the search goes on at the
        very next. pymavlink's own would swallow as many bytes as the false header promised.
        """
        whole: list[Frame] = []
        buffer = self._rest + data
        at, came_to = 0, len(buffer)
        while at < came_to:
            if came_to - at >= _LEAST_N:
                start, payload_n, flags, seq, system_id, component_id, message_id = _HEADER(buffer, at)
                end = at + _LEAST_N + payload_n
                kind = KINDS.get(message_id)
                if start == _V2 and not flags and kind is not None and end <= came_to:
                    frame = buffer[at:end]
                    if crc(frame[1:-CHECKSUM_N] + kind[1], 0xFFFF) == frame[-2] | frame[-1] << 8:
                        whole.append((frame, kind, seq, system_id, component_id))
                        at = end
                        continue
            if (goes_on := self._look_closer(buffer, at, whole)) == at:
                break
            at = goes_on
        self._rest = buffer[at:]
        return whole

    def _look_closer(self, buffer: bytes, at: int, whole: list[Frame]) -> int:
        """Where to go on after what begins at `at`: a frame of any sort, or garbage; at the same place once more has come."""
        start = _START.search(buffer, at)
        begins = len(buffer) if start is None else start.start()
        self.garbage_n += begins - at
        if start is None:
            return begins
        end = begins + _size(buffer, begins)
        if end > len(buffer):
            return begins
        frame = buffer[begins:end]
        kind = KINDS.get(frame[7:10] if buffer[begins] == _V2 else frame[5:6] + b"\0\0")
        if kind is not None:
            good = _is_intact(frame, kind)
        else:
            good = end > begins and (end == len(buffer) or _START.match(buffer, end) is not None)
        if good:
            seq, system_id, component_id = sender(frame)
            whole.append((frame, kind, seq, system_id, component_id))
            return end
        self.garbage_n += 1
        return begins + 1


def _is_intact(frame: bytes, kind: Kind) -> bool:
    """Whether its checksum is right."""
    end = len(frame) - CHECKSUM_N
    if frame[0] == _V2 and frame[2]:
        end -= _SIGNATURE_N
    return crc(frame[1:end] + kind.crc_extra, 0xFFFF) == frame[end] | frame[end + 1] << 8


def _size(buffer: bytes, at: int) -> int:
    """The size of the frame whose start byte is at `at`; 0 if its header is impossible.

    While the header is incomplete, that of the smallest frame.
    """
    if buffer[at] == _V1:
        return 8 + (buffer[at + 1] if at + 1 < len(buffer) else 0)
    if at + 2 >= len(buffer):
        return _LEAST_N
    if buffer[at + 2] & ~mavlink.MAVLINK_IFLAG_SIGNED:
        return 0
    return _LEAST_N + buffer[at + 1] + (_SIGNATURE_N if buffer[at + 2] else 0)
