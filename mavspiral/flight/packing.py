"""Our values to MAVLink 2 frames.

Packed by pymavlink's own metadata, without building its objects, which costs ten times as much; tests hold both equal,
byte for byte.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

from mavspiral.flight.framing import CHECKSUM_N, crc

__all__ = ["COMPONENT_ID", "SYSTEM_ID", "Layout", "frame_of", "layout"]

SYSTEM_ID = 245
COMPONENT_ID = 191  # MAV_COMP_ID_ONBOARD_COMPUTER

_START = 0xFD
_HEADER = struct.Struct("<BBBBBBB3s").pack


class Layout(NamedTuple):
    """How one message stands on the wire; `order` says which of the dialect's fields comes there first, and which next."""

    message_id: bytes
    crc_extra: bytes
    pack: Callable[..., bytes]
    order: tuple[int, ...]


@cache
def layout(described: Any) -> Layout:
    """Of a message that pymavlink describes."""
    return Layout(
        described.id.to_bytes(3, "little"),
        bytes((described.crc_extra,)),
        described.unpacker.pack,
        tuple(map(described.fieldnames.index, described.ordered_fieldnames)),
    )


def frame_of(kind: Layout, fields: Sequence[Any], seq: int, flags: int) -> bytes:
    """The frame of `fields`, which are in their order on the wire; one that is flagged as signed lacks its signature."""
    message_id, crc_extra, pack, _ = kind
    payload = pack(*fields).rstrip(b"\0") or b"\0"
    body = _HEADER(_START, len(payload), flags, 0, seq, SYSTEM_ID, COMPONENT_ID, message_id) + payload
    return body + crc(body[1:] + crc_extra, 0xFFFF).to_bytes(CHECKSUM_N, "little")
