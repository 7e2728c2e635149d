"""A mission's items in ArduPilot's order: which of them navigate, and which comes next."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from sitl.plans import PlanItem

__all__ = [
    "PLACES",
    "WAYPOINTS",
    "AutoItem",
    "Jumps",
    "is_navigating",
    "navigates",
    "next_item",
    "takes_off_first",
]


class AutoItem(IntEnum):
    """The commands that steer the vehicle, by MAVLink's numbers."""

    WAYPOINT = 16
    LOITER_UNLIM = 17
    LOITER_TURNS = 18
    LOITER_TIME = 19
    RETURN = 20
    LAND = 21
    TAKEOFF = 22
    LOITER_TO_ALT = 31
    SPLINE_WAYPOINT = 82
    DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    CONDITION_YAW = 115
    JUMP = 177
    CHANGE_SPEED = 178
    SET_HOME = 179
    SET_SERVO = 183


_NAVIGATING = frozenset({*range(16, 95)} - {80})
WAYPOINTS = (AutoItem.WAYPOINT, AutoItem.SPLINE_WAYPOINT)
PLACES = (
    *WAYPOINTS,
    AutoItem.LOITER_UNLIM,
    AutoItem.LOITER_TURNS,
    AutoItem.LOITER_TIME,
    AutoItem.LOITER_TO_ALT,
    AutoItem.LAND,
)
_MOST_JUMPS = 100

Jumps = tuple[tuple[int, int], ...]
"""The DO_JUMPs that were taken: item and how often."""


def is_navigating(item: PlanItem) -> bool:
    """Whether the item moves the vehicle; the others are done on the way to the one that does after them."""
    return item.command in _NAVIGATING


def navigates(items: tuple[PlanItem, ...]) -> bool:
    """Whether there is anything to fly besides home."""
    return any(map(is_navigating, items[1:]))


def takes_off_first(items: tuple[PlanItem, ...], seq: int) -> bool:
    """Whether the next item that navigates is a take-off."""
    found = next_item(items, max(0, seq - 1), ()).seq
    return found is not None and items[found].command == AutoItem.TAKEOFF


class Next(NamedTuple):
    """The next item that navigates (None after the last), the jumps so far, and what is to be done on the way."""

    seq: int | None
    jumps: Jumps
    passed: tuple[int, ...]


def next_item(items: tuple[PlanItem, ...], seq: int, jumps: Jumps) -> Next:
    """What comes after item `seq`."""
    passed: list[int] = []
    seq += 1
    for _ in range(_MOST_JUMPS + len(items)):
        if not 0 <= seq < len(items):
            break
        item = items[seq]
        if is_navigating(item):
            return Next(seq, jumps, tuple(passed))
        if item.command != AutoItem.JUMP:
            passed.append(seq)
            seq += 1
            continue
        taken, often = dict(jumps), item.params[1]
        if often < 0.0 or taken.get(seq, 0) < often:
            jumps = tuple(sorted({**taken, seq: taken.get(seq, 0) + 1}.items()))
            seq = int(item.params[0])
        else:
            seq += 1
    return Next(None, jumps, tuple(passed))
