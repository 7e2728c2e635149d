"""Faults on order: `NAME[=VALUE]@START[+DURATION]`, times since the simulation's start.

`motor=2:0.5@60s` leaves motor 2 (counted from 1, in PX4's order) half of its thrust; `gps_loss@60s+20s`
takes the fixes away for 20 s; `wind_step=8@30s` adds 8 m/s to the wind, along it, or from the west in a calm.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

__all__ = ["Fault", "GpsLoss", "MotorLoss", "WindStep", "parse_fault"]


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that goes wrong from `start_us` until before `end_us` (None: for good)."""

    start_us: int
    end_us: int | None

    def active(self, time_us: int) -> bool:
        """Whether it is wrong at this time."""
        return self.start_us <= time_us and (self.end_us is None or time_us < self.end_us)


@dataclass(frozen=True, slots=True)
class MotorLoss(Fault):
    """A motor, counted from 1, keeps only `thrust_left` (0…1) of its thrust."""

    motor: int
    thrust_left: float


@dataclass(frozen=True, slots=True)
class GpsLoss(Fault):
    """The receiver gives no fix."""


@dataclass(frozen=True, slots=True)
class WindStep(Fault):
    """The mean wind rises at once by `speed_mps`."""

    speed_mps: float


_EXAMPLES = {"motor": "motor=2:0.5@60s", "gps_loss": "gps_loss@60s+20s", "wind_step": "wind_step=8@30s"}
_SPEC = re.compile(
    r"(?P<name>[a-z_]+)(=(?P<value>[^@]+))?@(?P<start>\d+(\.\d*)?)s?(\+(?P<duration>\d+(\.\d*)?)s?)?"
)


def parse_fault(spec: str) -> Fault:
    """The fault that `spec` orders.

    Raises:
        ValueError: an unknown name (the known ones are listed), or another form (the right one is shown).
    """
    match = _SPEC.fullmatch(spec.strip())
    if match is None:
        raise ValueError(f"fault {spec!r}: wanted NAME[=VALUE]@START[+DURATION], like {_EXAMPLES['motor']}")
    name, value = match["name"], match["value"]
    if name not in _EXAMPLES:
        raise ValueError(f"fault {spec!r}: unknown {name!r}; known: {', '.join(_EXAMPLES)}")
    start_us = round(float(match["start"]) * 1e6)
    end_us = None if match["duration"] is None else start_us + round(float(match["duration"]) * 1e6)
    try:
        return _fault(name, value, start_us, end_us)
    except ValueError:
        raise ValueError(f"fault {spec!r}: bad value {value!r}; wanted such as {_EXAMPLES[name]}") from None


def _fault(name: str, value: str | None, start_us: int, end_us: int | None) -> Fault:
    if name == "gps_loss":
        if value is not None:
            raise ValueError(value)
        return GpsLoss(start_us, end_us)
    if value is None:
        raise ValueError(value)
    if name == "wind_step":
        if not math.isfinite(float(value)):
            raise ValueError(value)
        return WindStep(start_us, end_us, float(value))
    motor, _, left = value.partition(":")
    fault = MotorLoss(start_us, end_us, int(motor), float(left))
    if not (1 <= fault.motor <= 4 and 0.0 <= fault.thrust_left <= 1.0):
        raise ValueError(value)
    return fault
