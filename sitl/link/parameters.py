"""PX4's parameter protocol and the parameters that are on offer.

The vehicle's own (`sitl.params`) all have a meaning in it. The others are kept and told: ground stations ask for some of
them before they say that a vehicle is complete.
"""

from __future__ import annotations

import functools
import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import resources
from struct import Struct

from sitl.link.messages import Message, message_type
from sitl.params import DEFAULTS, Params

__all__ = ["ParameterService", "ParameterTable", "TableState"]

_PARAM_VALUE = message_type("PARAM_VALUE")
_PARAM_SET = message_type("PARAM_SET")
_PARAM_REQUEST_READ = message_type("PARAM_REQUEST_READ")
_PARAM_REQUEST_LIST = message_type("PARAM_REQUEST_LIST")

_FLOAT, _INT32, _UINT32 = Struct("<f"), Struct("<i"), Struct("<I")
_TYPE_UINT32, _TYPE_INT32, _TYPE_REAL32 = 5, 6, 9
_HASH_NAME, _NO_INDEX = "_HASH_CHECK", 65535
_LIST_CHUNK = 10
"""Values a frame: PX4 was seen to send its 878 in 0.86 s."""


@functools.cache
def _others() -> Mapping[str, float | int]:
    """PX4's other parameters, name to default: an int is an INT32."""
    text = resources.files("sitl").joinpath("px4.toml").read_text(encoding="utf-8")
    rows = (line.split(" = ") for line in text.splitlines() if not line.startswith("#"))
    return {name: int(value) if value.lstrip("-").isdigit() else float(value) for name, value in rows}


ChangeParameter = Callable[[str, float], None]
"""Sets a parameter, and whatever depends on it."""


@dataclass(frozen=True, slots=True)
class TableState:
    """Every value, and the revision in which each was set last."""

    values: Mapping[str, float | int]
    changed_in: Mapping[str, int]
    revision: int


class ParameterTable(dict[str, float | int]):
    """All parameters of one vehicle, in the autopilot's order. Whoever holds it sees every change.

    A dictionary, because they are looked up a hundred times a frame; only `set` and `restore` change it.
    """

    def __init__(self, params: Params) -> None:
        self._hold(dict(sorted({**_others(), **params}.items())))

    def _hold(self, values: dict[str, float | int]) -> None:
        self.clear()
        self.update(values)
        self._changed_in: dict[str, int] = {}
        self.revision = 0
        self.names = tuple(self)
        self.index = {name: index for index, name in enumerate(self.names)}

    @property
    def vehicle_params(self) -> Params:
        """Those that the body's control obeys."""
        return Params({name: self[name] for name in DEFAULTS})

    def set(self, name: str, value: float) -> None:
        """Change a value. The same value again is no change."""
        if value != self[name]:
            self.revision += 1
            self[name], self._changed_in[name] = value, self.revision

    def changed_since(self, revision: int) -> list[str]:
        """The names that have changed after that revision."""
        return [name for name, changed_in in self._changed_in.items() if changed_in > revision]

    def snapshot(self) -> TableState:
        """Every value."""
        return TableState(dict(self), dict(self._changed_in), self.revision)

    def restore(self, state: TableState) -> None:
        """Go on from a snapshot."""
        self.update(state.values)
        self._changed_in = dict(state.changed_in)
        self.revision = state.revision


@dataclass(slots=True)
class ParameterService:
    """The parameter protocol on one link. What it remembers are two numbers: `replace` copies it."""

    announced: int = 0
    cursor: int | None = None

    def receive(self, message: Message, table: ParameterTable, change: ChangeParameter) -> list[Message]:
        """The answer to a PARAM_ message. Unknown names and wrong types get none, as with PX4."""
        match message:
            case _PARAM_REQUEST_LIST():
                self.cursor = 0
                return [_hash_value(table)]
            case _PARAM_REQUEST_READ(param_index=index, param_id=name):
                return self._read(index, name.decode("ascii", "replace"), table)
            case _PARAM_SET(param_id=name, param_type=kind, param_value=value):
                return self._set(name.decode("ascii", "replace"), kind, value, table, change)
        return []

    def has_news(self, table: ParameterTable) -> bool:
        """Whether `proceed` has anything to send."""
        return self.cursor is not None or self.announced != table.revision

    def proceed(self, table: ParameterTable) -> list[Message]:
        """What there is to send unasked in this frame: changes, and the next part of a list."""
        messages: list[Message] = []
        if self.announced != table.revision:
            messages += [_value(table, name) for name in table.changed_since(self.announced)]
            self.announced = table.revision
        if self.cursor is not None:
            end = self.cursor + _LIST_CHUNK
            messages += [_value(table, name) for name in table.names[self.cursor : end]]
            self.cursor = end if end < len(table.names) else None
        return messages

    def _read(self, index: int, name: str, table: ParameterTable) -> list[Message]:
        if 0 <= index < len(table.names):
            return [_value(table, table.names[index])]
        if index < 0 and name == _HASH_NAME:
            return [_hash_value(table)]
        if index < 0 and name in table:
            return [_value(table, name)]
        return []

    def _set(
        self, name: str, kind: int, wire_value: float, table: ParameterTable, change: ChangeParameter
    ) -> list[Message]:
        if name not in table:
            return []
        is_int = isinstance(table[name], int)
        if kind != (_TYPE_INT32 if is_int else _TYPE_REAL32):
            return []
        value = _INT32.unpack(_FLOAT.pack(wire_value))[0] if is_int else wire_value
        if math.isfinite(value):
            change(name, value)
        return [_value(table, name)]


def _value(table: ParameterTable, name: str) -> Message:
    value = table[name]
    is_int = isinstance(value, int)
    return _PARAM_VALUE(
        param_value=_FLOAT.unpack(_INT32.pack(value))[0] if is_int else value,
        param_count=len(table.names),
        param_index=table.index[name],
        param_id=name.encode(),
        param_type=_TYPE_INT32 if is_int else _TYPE_REAL32,
    )


def _hash_value(table: ParameterTable) -> Message:
    """The sum by which a ground station knows that its copy is still good; it comes before the list."""
    crc = 0
    for name in table.names:
        value = table[name]
        crc = zlib.crc32(name.encode() + (_INT32 if isinstance(value, int) else _FLOAT).pack(value), crc)
    return _PARAM_VALUE(
        param_value=_FLOAT.unpack(_UINT32.pack(crc))[0],
        param_count=len(table.names),
        param_index=_NO_INDEX,
        param_id=_HASH_NAME.encode(),
        param_type=_TYPE_UINT32,
    )
