"""Types in a JSON document as QGroundControl's validator sees them."""

from __future__ import annotations

import math
from typing import Any, Final

from mavspiral.export.check.findings import Findings

__all__ = ["ARRAY", "FLAG", "FLOAT_MAX", "NUMBER", "OBJECT", "TEXT", "demand", "is_kind", "place_of", "short"]

NUMBER, TEXT, OBJECT, ARRAY, FLAG = "a number", "a string", "an object", "an array", "true or false"
HEIGHT = 2
FLOAT_MAX = 3.4e38
"""MAVLink carries heights and radii in floats of 32 bits."""
_TYPES: Final[dict[str, type | tuple[type, ...]]] = {
    NUMBER: (int, float),
    TEXT: str,
    OBJECT: dict,
    ARRAY: list,
    FLAG: bool,
}


def demand(holder: dict[str, Any], keys: dict[str, str], place: str, findings: Findings) -> bool:
    """Whether each of `keys` is there and of its kind; what is not is noted as an error."""
    whole = True
    for key, kind in keys.items():
        if key not in holder:
            findings.error(place, f"{key} is missing")
            whole = False
        elif not is_kind(holder[key], kind):
            findings.error(place, f"{key} is {short(holder[key])}, wanted {kind}")
            whole = False
    return whole


def is_kind(value: Any, kind: str) -> bool:
    """Whether the value is of that kind; a flag is no number."""
    return isinstance(value, _TYPES[kind]) and (kind == FLAG or not isinstance(value, bool))


def place_of(value: Any, count: int) -> tuple[float, ...] | None:
    """An array of exactly `count` numbers: latitude, longitude, and a height that may be null; None if it is none."""
    if not isinstance(value, list) or len(value) != count:
        return None
    if not all(is_kind(v, NUMBER) or (v is None and i == HEIGHT) for i, v in enumerate(value)):
        return None
    if (
        abs(value[0]) > 90
        or abs(value[1]) > 180
        or any(abs(v) > FLOAT_MAX for v in value[HEIGHT:] if v is not None)
    ):
        return None
    return tuple(math.nan if v is None else float(v) for v in value)


def short(value: Any) -> str:
    """The value in a few characters, for a message."""
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "an array"
    if value is None or isinstance(value, bool):
        return str(value).lower().replace("none", "null")
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}…"
