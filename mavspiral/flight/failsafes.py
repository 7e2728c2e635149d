"""The parameters that make a lost link safe: set before the flight when that is asked for, put back after it.

A setpoint is bound to a live planner: when our process hangs or dies, the vehicle hears no more of them, and what it does
then is its own failsafe. These parameters say what. A flight that ends before it can put them back leaves them to
the next one, which is told of them (`SessionConfig.borrowed`).
"""

from __future__ import annotations

from mavspiral.flight.messages import raw_of
from mavspiral.flight.situation import Situation

__all__ = ["are_restored", "are_set", "ask_restored", "ask_set", "left_as_set", "prepare"]

_SAME = 1e-4


def prepare(s: Situation) -> None:
    """Work out what must be set, from what the vehicle has told."""
    s.borrowed = {} if s.config.dry_run else _taken_over(s)
    if s.config.dry_run or not s.config.set_failsafes:
        return
    borrowed = dict(s.borrowed)
    for name, wanted in s.profile.failsafes.items():
        now = _value(s, name)
        if now is None:
            s.tell("warning", f"{name} could not be read and is not set")
            continue
        own, _ = borrowed.get(name, (now, now))
        value = wanted(own, s.safe_return_m)
        if abs(value - own) > _SAME or name in borrowed:
            borrowed[name] = own, value
        if abs(value - now) > _SAME:
            s.tell("info", f"{name} is set to {value:g} for this flight (was {now:g})")
    s.borrowed = borrowed


def are_set(s: Situation) -> bool:
    """Whether the vehicle has them as they must be."""
    return not _differing(s, _given(s))


def ask_set(s: Situation) -> bytes:
    """Set what is not yet as it must be."""
    return _told(s, _given(s))


def are_restored(s: Situation) -> bool:
    """Whether all are as they were before."""
    if _differing(s, _own(s)):
        return False
    s.borrowed = {}
    return True


def ask_restored(s: Situation) -> bytes:
    """Put back what is not yet as it was."""
    return _told(s, _own(s))


def left_as_set(s: Situation) -> str | None:
    """What is not as it was before the flight, in words; None where nothing is."""
    return f"left as set for this flight: {_listed(s.borrowed)}" if s.borrowed else None


def _taken_over(s: Situation) -> dict[str, tuple[float, float]]:
    """What an earlier flight has set stays for this one, and is put back after it; what was changed since then is left alone."""
    taken = {}
    for name, (own, given) in s.config.borrowed.items():
        now = _value(s, name)
        if now is None:
            words = f"{name} could not be read; an earlier flight has set it to {given:g} (was {own:g})"
            s.tell("warning", f"{words}: put it back yourself")
        elif abs(now - given) <= _SAME:
            taken[name] = own, now
    if taken:
        s.tell("info", f"an earlier flight has left {_listed(taken)}: put back after this one")
    return taken


def _own(s: Situation) -> dict[str, float]:
    return {name: own for name, (own, _) in s.borrowed.items()}


def _given(s: Situation) -> dict[str, float]:
    return {name: given for name, (_, given) in s.borrowed.items()}


def _listed(borrowed: dict[str, tuple[float, float]]) -> str:
    return ", ".join(f"{name} = {given:g} (was {own:g})" for name, (own, given) in borrowed.items())


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
