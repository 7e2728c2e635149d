"""ArduPilot's parameter protocol: every value is a plain number on the wire, whatever its type.

The type that a PARAM_SET states does not matter: what is a whole number stays one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from sitl.airframe import Airframe
from sitl.copter_params import body_params, copter_defaults, yaw_gain
from sitl.copter_types import as_kept, copter_bits
from sitl.link.messages import Message, message_type
from sitl.link.parameters import ChangeParameter, ParameterTable
from sitl.params import Params

__all__ = ["CopterParameterService", "CopterTable"]

_PARAM_VALUE = message_type("PARAM_VALUE")
_PARAM_SET = message_type("PARAM_SET")
_PARAM_REQUEST_READ = message_type("PARAM_REQUEST_READ")
_PARAM_REQUEST_LIST = message_type("PARAM_REQUEST_LIST")

_TYPE_REAL32, _TYPES = 9, {8: 2, 16: 4, 32: 6}
"""MAV_PARAM_TYPE, of whole numbers by their bits."""
_NO_INDEX = 65535
_LIST_CHUNK = 21
"""Values a frame: ArduCopter was seen to send its 1392 in 0.65 s."""
_RUNTIME, _RUNTIME_US = "STAT_RUNTIME", 30_000_000


class CopterTable(ParameterTable):
    """ArduCopter's parameters. `params` are the body's own, which ArduPilot's parameters overrule in part."""

    def __init__(self, params: Params, airframe: Airframe, system: int) -> None:
        self._params, self._yaw_gain = params, yaw_gain(airframe)
        own = {"SYSID_THISMAV": float(system), "BATT_CAPACITY": 1e3 * airframe.battery.capacity_ah}
        values = {**copter_defaults(), **own}
        self._hold({name: as_kept(name, value) for name, value in values.items()})

    def set(self, name: str, value: float) -> None:
        """Change a value; of a whole number the fraction is cut off."""
        super().set(name, as_kept(name, value))

    @property
    def vehicle_params(self) -> Params:
        """What the body's control obeys."""
        return body_params(self, self._params, self._yaw_gain)


@dataclass(slots=True)
class CopterParameterService:
    """The parameter protocol on one link. What it remembers are numbers: `replace` copies it."""

    cursor: int | None = None
    runtime_us: int = _RUNTIME_US

    def receive(self, message: Message, table: ParameterTable, change: ChangeParameter) -> list[Message]:
        """The answer to a PARAM_ message. An unknown name gets none."""
        match message:
            case _PARAM_REQUEST_LIST():
                self.cursor = 0
            case _PARAM_REQUEST_READ(param_index=index, param_id=name):
                return _read(index, name.decode("ascii", "replace"), table)
            case _PARAM_SET(param_id=name, param_value=value):
                return _set(name.decode("ascii", "replace"), value, table, change)
        return []

    @property
    def due_us(self) -> int:
        """When there will be something to send unasked; zero is at once."""
        return self.runtime_us if self.cursor is None else 0

    def proceed(self, table: ParameterTable, now_us: int) -> list[Message]:
        """What there is to send unasked in this frame: the next part of a list, and how long it has run."""
        messages: list[Message] = []
        if now_us >= self.runtime_us:
            self.runtime_us = now_us + _RUNTIME_US
            messages.append(_value(table, _RUNTIME, _NO_INDEX, now_us // 1_000_000))
        if self.cursor is not None:
            end = self.cursor + _LIST_CHUNK
            names = table.names[self.cursor : end]
            messages += [_value(table, name, self.cursor + i) for i, name in enumerate(names)]
            self.cursor = end if end < len(table.names) else None
        return messages


def _read(index: int, name: str, table: Mapping[str, float]) -> list[Message]:
    assert isinstance(table, ParameterTable)
    if 0 <= index < len(table.names):
        return [_value(table, table.names[index], index)]
    return [_value(table, name, _NO_INDEX)] if index < 0 and name in table else []


def _set(name: str, value: float, table: ParameterTable, change: ChangeParameter) -> list[Message]:
    if name not in table:
        return []
    if math.isfinite(value):
        change(name, value)
    return [_value(table, name, _NO_INDEX)]


def _value(table: ParameterTable, name: str, index: int, value: float | None = None) -> Message:
    return _PARAM_VALUE(
        param_value=float(table[name] if value is None else value),
        param_count=len(table.names),
        param_index=index,
        param_id=name.encode(),
        param_type=_TYPES.get(copter_bits().get(name, 0), _TYPE_REAL32),
    )
