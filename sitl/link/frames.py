"""MAVLink frames as stretches of bytes: how long they are, by their headers, and how they lie end to end."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = [
    "CHECKSUM_N",
    "HEADER_N",
    "HEADER_V1_N",
    "MAGIC",
    "MAGIC_V1",
    "SIGNED",
    "datagrams",
    "frames",
    "size_of",
    "whole_frames",
]

MAGIC, MAGIC_V1 = 0xFD, 0xFE
"""The first byte of a frame of MAVLink 2 and of MAVLink 1."""
HEADER_N, HEADER_V1_N = 10, 6
CHECKSUM_N, SIGNATURE_N = 2, 13
SIGNED = 1
"""The incompatibility flag of a frame that carries a signature."""

_DATAGRAM_LIMIT = 1280


def size_of(data: bytes, begin: int) -> int:
    """How long the frame is that begins there; the least that it can be while too little has come to know.

    Zero where none begins.
    """
    header = data[begin : begin + 3]
    if header[:1] == bytes((MAGIC_V1,)):
        return HEADER_V1_N + CHECKSUM_N + (header[1] if len(header) > 1 else 0)
    if header[:1] != bytes((MAGIC,)):
        return 0
    if len(header) < 3:
        return HEADER_N + CHECKSUM_N
    return HEADER_N + header[1] + CHECKSUM_N + SIGNATURE_N * (header[2] & SIGNED)


def frames(data: bytes) -> Iterator[bytes]:
    """MAVLink frames of either version, whole; what is none stays together up to the next beginning."""
    begin = 0
    while begin < len(data):
        end = begin + size_of(data, begin)
        if end == begin or end > len(data):
            starts = (data.find(magic, begin + 1) for magic in (MAGIC_V1, MAGIC))
            end = min((at for at in starts if at > 0), default=len(data))
        yield data[begin:end]
        begin = end


def whole_frames(data: bytes) -> Iterator[bytes]:
    """The MAVLink frames that lie end to end in `data`. What does not look like one ends the walk."""
    begin = 0
    while (size := size_of(data, begin)) and begin + size <= len(data):
        yield data[begin : begin + size]
        begin += size


def datagrams(data: bytes, limit: int = _DATAGRAM_LIMIT) -> Iterator[bytes]:
    """The frames of `data` in datagrams of at most `limit` bytes, none of them cut."""
    begin = end = 0
    for frame in frames(data):
        if end > begin and end + len(frame) - begin > limit:
            yield data[begin:end]
            begin = end
        end += len(frame)
    if end > begin:
        yield data[begin:end]
