"""AVAILABLE_MODES: what ground stations fill their list of modes with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from sitl.link.messages import Message, message_type

__all__ = ["AVAILABLE_MODES", "ListedMode", "listed"]

AVAILABLE_MODES = message_type("AVAILABLE_MODES")
_NOT_SELECTABLE = 2
"""MAV_MODE_PROPERTY_NOT_USER_SELECTABLE."""


class ListedMode(NamedTuple):
    """A mode by its name, the number in HEARTBEAT and the MAV_STANDARD_MODE that it is; 0 is none."""

    name: str
    custom_mode: int
    standard_mode: int = 0
    selectable: bool = True


def listed(modes: Sequence[ListedMode], index: int) -> list[Message]:
    """The mode of that index, counted from 1; all of them for index 0."""
    wanted = range(1, len(modes) + 1) if index == 0 else (index,) if 0 < index <= len(modes) else ()
    return [
        AVAILABLE_MODES(
            custom_mode=mode.custom_mode,
            properties=0 if mode.selectable else _NOT_SELECTABLE,
            number_modes=len(modes),
            mode_index=at,
            standard_mode=mode.standard_mode,
            mode_name=mode.name.encode(),
        )
        for at, mode in ((at, modes[at - 1]) for at in wanted)
    ]
