"""Faults on order: `NAME[=VALUE]@START[+DURATION]`, times since the simulation's start.

`motor=2:0.5@60s` leaves motor 2 (counted from 1, in PX4's order) half of its thrust; `gps_loss@60s+20s`
takes the fixes away for 20 s; `packet_loss=30%` loses that share of all frames from the start. Values only:
`sitl.trouble` does to the body what they say, `sitl.link.channel` to the bytes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

__all__ = [
    "BaroStep",
    "BatteryLevel",
    "Fault",
    "GpsDrift",
    "GpsJump",
    "GpsLoss",
    "GpsMultipath",
    "LinkDelay",
    "LinkFault",
    "LinkLoss",
    "MagDisturbance",
    "MotorLoss",
    "PacketLoss",
    "SensorStuck",
    "WindStep",
    "parse_fault",
]


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
class GpsJump(Fault):
    """Every fix lies `distance_m` too far north."""

    distance_m: float


@dataclass(frozen=True, slots=True)
class GpsDrift(Fault):
    """The fixes creep north by `speed_mps`, as a spoofer leads a vehicle away; their speed does not show it."""

    speed_mps: float


@dataclass(frozen=True, slots=True)
class GpsMultipath(Fault):
    """Near a wall: the fixes wander by `sigma_m` (1 σ an axis, correlated over 20 s) more than they tell."""

    sigma_m: float


@dataclass(frozen=True, slots=True)
class BaroStep(Fault):
    """The barometer reads `step_m` too high."""

    step_m: float


@dataclass(frozen=True, slots=True)
class MagDisturbance(Fault):
    """Steel nearby adds `field_gauss` to the magnetic field, eastwards."""

    field_gauss: float


@dataclass(frozen=True, slots=True)
class BatteryLevel(Fault):
    """At its start the pack holds `remaining` (0…1) of its charge. Nothing charges it again at the end."""

    remaining: float


@dataclass(frozen=True, slots=True)
class SensorStuck(Fault):
    """A sense repeats its last sample: accel, gyro, baro, mag or gps."""

    sensor: str


@dataclass(frozen=True, slots=True)
class WindStep(Fault):
    """The mean wind at 20 ft rises at once by `speed_mps`."""

    speed_mps: float


@dataclass(frozen=True, slots=True)
class LinkFault(Fault):
    """Something that befalls the bytes on every link, both ways."""


@dataclass(frozen=True, slots=True)
class LinkLoss(LinkFault):
    """Nothing passes."""


@dataclass(frozen=True, slots=True)
class PacketLoss(LinkFault):
    """Each frame is lost with probability `share`."""

    share: float


@dataclass(frozen=True, slots=True)
class LinkDelay(LinkFault):
    """Each frame arrives `delay_us` later."""

    delay_us: int


_Span = tuple[int, int | None]
_LEVELS: Final = {"low": 0.14, "critical": 0.06, "emergency": 0.04}
"""Just below PX4's defaults of BAT_LOW_THR, BAT_CRIT_THR and BAT_EMERGEN_THR."""
_SENSORS: Final = ("accel", "gyro", "baro", "mag", "gps")


def _number(value: str | None, units: tuple[str, ...], low: float, high: float) -> float:
    text = value or ""
    for unit in units:
        if text.endswith(unit):
            text = text.removesuffix(unit)
            break
    number = float(text)
    if not (math.isfinite(number) and low <= number <= high):
        raise ValueError(value)
    return number


def _motor(value: str | None, span: _Span) -> Fault:
    number, _, left = (value or "").partition(":")
    if int(number) not in range(1, 5):
        raise ValueError(value)
    return MotorLoss(*span, int(number), _number(left, (), 0.0, 1.0))


def _bare(kind: Callable[..., Fault]) -> Callable[[str | None, _Span], Fault]:
    def read(value: str | None, span: _Span) -> Fault:
        if value is not None:
            raise ValueError(value)
        return kind(*span)

    return read


def _measured(
    kind: Callable[..., Fault], units: tuple[str, ...], low: float, high: float, scale: float = 1.0
) -> Callable[[str | None, _Span], Fault]:
    def read(value: str | None, span: _Span) -> Fault:
        return kind(*span, scale * _number(value, units, low, high))

    return read


def _battery(value: str | None, span: _Span) -> Fault:
    if value in _LEVELS:
        return BatteryLevel(*span, _LEVELS[value])
    return BatteryLevel(*span, 0.01 * _number(value, ("%",), 0.0, 100.0))


def _stuck(value: str | None, span: _Span) -> Fault:
    if value not in _SENSORS:
        raise ValueError(value)
    return SensorStuck(*span, value)


def _delay(value: str | None, span: _Span) -> Fault:
    seconds = (value or "").endswith("s") and not (value or "").endswith("ms")
    amount = _number(value, ("ms", "s"), 0.0, 60.0 if seconds else 60_000.0)
    return LinkDelay(*span, round(amount * (1e6 if seconds else 1e3)))


@dataclass(frozen=True, slots=True)
class _Kind:
    """How one fault is read: its reader, what its value may be, an example, and whether it needs a start."""

    read: Callable[[str | None, _Span], Fault]
    wanted: str
    example: str
    needs_start: bool = True


_KINDS: Final[Mapping[str, _Kind]] = {
    "motor": _Kind(_motor, "motor 1 to 4 and what is left of its thrust, 0 to 1", "motor=2:0.5@60s"),
    "gps_loss": _Kind(_bare(GpsLoss), "no value", "gps_loss@60s+20s"),
    "gps_jump": _Kind(_measured(GpsJump, ("m",), -1e4, 1e4), "metres within ±10000", "gps_jump=5m@60s"),
    "gps_drift": _Kind(
        _measured(GpsDrift, ("m/s", "mps"), -10.0, 10.0), "m/s within ±10", "gps_drift=0.2@60s+30s"
    ),
    "multipath": _Kind(
        _measured(GpsMultipath, ("m",), 0.0, 100.0), "metres from 0 to 100", "multipath=2m@60s"
    ),
    "baro_step": _Kind(_measured(BaroStep, ("m",), -1e3, 1e3), "metres within ±1000", "baro_step=3m@60s"),
    "mag_disturb": _Kind(
        _measured(MagDisturbance, ("gauss", "G"), -10.0, 10.0), "gauss within ±10", "mag_disturb=0.2@60s+20s"
    ),
    "battery": _Kind(_battery, "low, critical, emergency or a charge in %", "battery=low@60s"),
    "sensor_stuck": _Kind(_stuck, f"one of {', '.join(_SENSORS)}", "sensor_stuck=baro@60s"),
    "wind_step": _Kind(
        _measured(WindStep, ("m/s", "mps"), -100.0, 100.0), "m/s within ±100", "wind_step=8@30s"
    ),
    "link_loss": _Kind(_bare(LinkLoss), "no value", "link_loss@60s+20s"),
    "packet_loss": _Kind(
        _measured(PacketLoss, ("%",), 0.0, 100.0, 0.01), "0 to 100 %", "packet_loss=30%", needs_start=False
    ),
    "delay": _Kind(_delay, "0 to 60000 ms", "delay=200ms", needs_start=False),
}

_SPEC = re.compile(
    r"(?P<name>[a-z_]+)(=(?P<value>[^@+]+))?(@(?P<start>\d{1,7}(\.\d{0,6})?)s?)?(\+(?P<duration>\d{1,7}(\.\d{0,6})?)s?)?"
)


def parse_fault(spec: str) -> Fault:
    """The fault that `spec` orders. `packet_loss` and `delay` hold from the beginning without a start.

    Raises:
        ValueError: an unknown name (the known ones are listed), or another form (the right one is shown).
    """
    match = _SPEC.fullmatch(spec.strip())
    if match is None:
        raise ValueError(
            f"fault {spec!r}: wanted NAME[=VALUE]@START[+DURATION], like {_KINDS['motor'].example}"
        )
    name, value = match["name"], match["value"]
    if name not in _KINDS:
        raise ValueError(f"fault {spec!r}: unknown {name!r}; known: {', '.join(_KINDS)}")
    kind = _KINDS[name]
    if match["start"] is None and kind.needs_start:
        raise ValueError(
            f"fault {spec!r}: no start; wanted NAME[=VALUE]@START[+DURATION], like {kind.example}"
        )
    start_us = round(float(match["start"] or 0) * 1e6)
    end_us = None if match["duration"] is None else start_us + round(float(match["duration"]) * 1e6)
    try:
        return kind.read(value, (start_us, end_us))
    except ValueError:
        raise ValueError(
            f"fault {spec!r}: bad value {value!r}; wanted such as {kind.example} ({kind.wanted})"
        ) from None
