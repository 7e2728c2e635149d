"""MAVLink messages as named tuples in wire order, made from pymavlink's own tables.

A message here is its fields and nothing else: no header, no sequence number, no bytes. Names are MAVLink's,
verbatim; arrays are tuples; text is `bytes` without its padding.
"""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from struct import Struct
from typing import Any

from pymavlink.dialects.v20 import common

__all__ = ["Layout", "Message", "MessageType", "layout", "layout_of", "message_type"]

Message = Any
"""A named tuple made by `message_type`: its fields come from the dialect's table, at run time."""
MessageType = Any
"""The class of one kind of message, with `ID` (its number) and `LAYOUT` (its place on the wire)."""


@dataclass(frozen=True, slots=True)
class Layout:
    """How one kind of message lies on the wire."""

    type: MessageType
    number: bytes
    """The message's, as a header has it."""
    packer: Struct
    crc_extra: bytes
    spans: tuple[tuple[int, int], ...] | None
    """Where each field lies among the values that `packer` gives; None when every field is one number."""

    def flat(self, message: Message) -> list[object]:
        """The values that `packer` takes: what is an array, one by one."""
        flat: list[object] = []
        for value in message:
            if isinstance(value, tuple):
                flat.extend(value)
            else:
                flat.append(value)
        return flat

    def unpack(self, payload: bytes | bytearray) -> Message:
        """The message in a payload, whose cut zeros are put back and whose unknown extensions are cut."""
        size = self.packer.size
        if len(payload) != size:
            payload = payload[:size].ljust(size, b"\0")
        flat = self.packer.unpack(payload)
        if self.spans is None:
            return _made(self.type, flat)
        return _made(self.type, [_field(flat, begin, end) for begin, end in self.spans])


_made = tuple.__new__
"""A message of as many values as it has fields: a named tuple's own `_make` would count them again."""


def _field(flat: tuple[Any, ...], begin: int, end: int) -> object:
    if end - begin > 1:
        return flat[begin:end]
    value = flat[begin]
    return value.rstrip(b"\0") if isinstance(value, bytes) else value


def _number(message_id: int) -> bytes:
    return message_id.to_bytes(3, "little")


def _tuple_type(name: str, fields: list[str]) -> MessageType:
    return namedtuple(name, fields)  # type: ignore[misc]  # named at run time


def _spelled_out(message_id: int, name: str, fields: str, wire: str, crc_extra: int) -> Layout:
    kind = _tuple_type(name, fields.split())
    kind.ID = message_id
    kind.LAYOUT = Layout(kind, _number(message_id), Struct(wire), bytes([crc_extra]), None)
    found: Layout = kind.LAYOUT
    return found


_BEYOND_COMMON = {
    300: _spelled_out(
        300,
        "PROTOCOL_VERSION",
        "version min_version max_version spec_version_hash library_version_hash",
        "<HHH8s8s",
        217,
    ),
    411: _spelled_out(411, "CURRENT_EVENT_SEQUENCE", "sequence flags", "<HB", 106),
    412: _spelled_out(
        412, "REQUEST_EVENT", "first_sequence last_sequence target_system target_component", "<HHBB", 33
    ),
    413: _spelled_out(
        413,
        "RESPONSE_EVENT_ERROR",
        "sequence sequence_oldest_available target_system target_component reason",
        "<HHBBB",
        77,
    ),
    435: _spelled_out(
        435,
        "AVAILABLE_MODES",
        "custom_mode properties number_modes mode_index standard_mode mode_name",
        "<IIBBB35s",
        134,
    ),
    436: _spelled_out(436, "CURRENT_MODE", "custom_mode intended_custom_mode standard_mode", "<IIB", 193),
}
"""What PX4 sends and pymavlink's common dialect does not have: from MAVLink's common.xml (the events) and development.xml."""


@cache
def layout(message_id: int) -> Layout | None:
    """The layout of that message, or None when the dialect does not know it."""
    entry = common.mavlink_map.get(message_id)
    return _BEYOND_COMMON.get(message_id) if entry is None else layout_of(message_id, entry)


def layout_of(message_id: int, entry: Any) -> Layout:
    """The layout of the message of which pymavlink says `entry`."""
    kind = _tuple_type(entry.msgname, entry.ordered_fieldnames)
    ends = list(accumulate(entry.lengths))  # in wire order; text counts as one, as it does to `struct`
    spans = tuple((end - length, end) for end, length in zip(ends, entry.lengths, strict=True))
    numbers_only = ends[-1] == len(spans) and "char" not in entry.fieldtypes
    kind.ID = message_id
    crc_extra = bytes([entry.crc_extra])
    kind.LAYOUT = Layout(
        kind, _number(message_id), entry.unpacker, crc_extra, None if numbers_only else spans
    )
    found: Layout = kind.LAYOUT
    return found


def message_type(name: str) -> MessageType:
    """The class of the message of that name, as `message_type("HEARTBEAT")`."""
    for beyond in _BEYOND_COMMON.values():
        if beyond.type.__name__ == name:
            return beyond.type
    found = layout(getattr(common, f"MAVLINK_MSG_ID_{name}"))
    assert found is not None, name
    return found.type
