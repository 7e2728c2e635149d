"""The types of ArduCopter's parameters: which are whole numbers, and what becomes of a fraction there."""

from __future__ import annotations

import functools
import math
import re
import tomllib
from collections.abc import Mapping
from importlib import resources

from sitl.copter_params import copter_defaults

__all__ = ["as_kept", "copter_bits"]

_NUMBER = re.compile(r"\d+")
_BITS = {"INT8": 8, "INT16": 16, "INT32": 32}
_NEARLY = 0.01
"""A number that lacks no more than this is whole: ArduPilot cuts the rest off (AP_Param::set_float)."""


@functools.cache
def copter_bits() -> Mapping[str, int]:
    """Name to 8, 16 or 32, for those that are whole numbers."""
    text = resources.files("sitl").joinpath("arducopter_types.toml").read_text(encoding="utf-8")
    bits = {name: _BITS[kind] for kind, names in tomllib.loads(text).items() for name in names.split()}
    patterns = ((name, _NUMBER.sub("#", name)) for name in copter_defaults())
    return {name: bits[pattern] for name, pattern in patterns if pattern in bits}


def as_kept(name: str, value: float) -> float:
    """What the parameter is when it is set to that."""
    bits = copter_bits().get(name)
    if bits is None:
        return value
    end = 2 ** (bits - 1)
    return float(min(max(math.trunc(value + math.copysign(_NEARLY, value)), -end), end - 1))
