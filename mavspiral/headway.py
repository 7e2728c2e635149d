"""How far a long work has come, told to whoever asked."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Headway", "to_nobody", "within"]

Headway = Callable[[float], None]
"""Is told the share that is done, which rises from 0 to 1."""


def to_nobody(share: float) -> None:
    """Tells nobody."""


def within(whole: Headway, begin: float, end: float) -> Headway:
    """The headway of a piece of the work, which is that of the whole from `begin` to `end`."""
    return lambda share: whole(begin + share * (end - begin))
