"""The parameters that make a lost link safe: set before the flight when that is asked for, put back after it.

A setpoint is bound to a live planner: when our process hangs or dies, the vehicle hears no more of them, and what it does
then is its own failsafe. These parameters say what. A flight that ends before it can put them back leaves them to
the next one, which is told of them (`SessionConfig.borrowed`).
"""

from __future__ import annotations

from mavspiral.flight.messages import raw_of
from mavspiral.flight.situation import Situation

__all__ = ["are_restored", "are_set", "ask_restored", "ask_set", "borrowed", "left_as_set", "prepare"]

_SAME = 1e-4


def prepare(s: Situation) -> None:
    """Work out what must be set, from what the vehicle has told."""
    s.failsafes_wanted, s.failsafes_before = {}, {}
    if s.config.dry_run:
        return
    _take_over(s)
    if not s.config.set_failsafes:
        return
    for name, wanted in s.profile.failsafes.items():
        now = _value(s, name)
        if now is None:
            s.tell("warning", f"{name} could not be read and is not set")
            continue
        own = s.failsafes_before.get(name, now)
        value = wanted(own, s.safe_return_m)
        if abs(value - own) > _SAME or name in s.failsafes_before:
            s.failsafes_wanted[name], s.failsafes_before[name] = value, own
        if abs(value - now) > _SAME:
            s.tell("info", f"{name} is set to {value:g} for this flight (was {now:g})")


def borrowed(s: Situation) -> dict[str, tuple[float, float]]:
    """Of each parameter that is not as it was: the vehicle's own value, and the one that it was given."""
    return {name: (own, s.failsafes_wanted[name]) for name, own in s.failsafes_before.items()}


def are_set(s: Situation) -> bool:
    """Whether the vehicle has them as they must be."""
    return not _differing(s, s.failsafes_wanted)


def ask_set(s: Situation) -> bytes:
    """Set what is not yet as it must be."""
    return _told(s, s.failsafes_wanted)


def are_restored(s: Situation) -> bool:
    """Whether all are as they were before."""
    if _differing(s, s.failsafes_before):
        return False
    s.failsafes_before.clear()
    return True


def ask_restored(s: Situation) -> bytes:
    """Put back what is not yet as it was."""
    return _told(s, s.failsafes_before)


def left_as_set(s: Situation) -> str | None:
    """What is not as it was before the flight, in words; None where nothing is."""
    if not s.failsafes_before:
        return None
    told = ", ".join(
        f"{name} = {s.failsafes_wanted[name]:g} (was {before:g})"
        for name, before in s.failsafes_before.items()
    )
    return f"left as set for this flight: {told}"


def _take_over(s: Situation) -> None:
    """What an earlier flight has set stays for this one, and is put back after it; what was changed since then is left alone."""
    for name, (own, given) in s.config.borrowed.items():
        now = _value(s, name)
        if now is None:
            words = f"{name} could not be read; an earlier flight has set it to {given:g} (was {own:g})"
            s.tell("warning", f"{words}: put it back yourself")
        elif abs(now - given) <= _SAME:
            s.failsafes_wanted[name], s.failsafes_before[name] = now, own
    if s.failsafes_before:
        told = ", ".join(
            f"{name} = {s.failsafes_wanted[name]:g} (was {own:g})" for name, own in s.failsafes_before.items()
        )
        s.tell("info", f"an earlier flight has left {told}: put back after this one")


def _value(s: Situation, name: str) -> float | None:
    value = s.vehicle.parameters.get(name)
    return None if value is None else value.number(bytewise=s.profile.integers_bytewise)


def _differing(s: Situation, wanted: dict[str, float]) -> list[str]:
    return [name for name, value in wanted.items() if abs((_value(s, name) or 0.0) - value) > _SAME]


def _told(s: Situation, wanted: dict[str, float]) -> bytes:
    told = b""
    for name in _differing(s, wanted):
        kind = s.vehicle.parameters[name].param_type
        told += s.link.parameter_set(
            name, raw_of(wanted[name], kind, bytewise=s.profile.integers_bytewise), kind
        )
    return told
