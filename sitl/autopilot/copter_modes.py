"""ArduCopter's modes as a table: what each does, and when it may be entered and armed in.

A mode is a trip to glide along; GUIDED, AUTO and CIRCLE have rooms of their own. The sticks of a pilot who is not there stand
in their middle: STABILIZE and ALT_HOLD keep level and keep their height. Who is there flies them by `hands`. SMARTRTL has its way from the trail.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sitl.autopilot.glide import Glide
from sitl.autopilot.trip import Trip, fly_home, hold_here, land_here
from sitl.orders import Mode
from sitl.status import Home

__all__ = ["COPTER_MODES", "CopterRow"]

_Begin = Callable[[Glide, Home | None, Mapping[str, float]], Trip]


@dataclass(frozen=True, slots=True)
class CopterRow:
    """One mode: its trip, whether it needs a position, whether one may arm in it, and whether it comes down.

    A `level` one keeps level, as with its sticks in their middle. One `by_hand` obeys the sticks of whoever holds some.
    """

    trip: _Begin
    needs_place: bool = True
    arms: bool = False
    lands: bool = False
    level: bool = False
    by_hand: bool = False


def _stay(glide: Glide, _: Home | None, parameters: Mapping[str, float]) -> Trip:
    return hold_here(glide, parameters)


COPTER_MODES: Mapping[Mode, CopterRow] = {
    Mode.STABILIZE: CopterRow(_stay, needs_place=False, arms=True, level=True, by_hand=True),
    Mode.ALT_HOLD: CopterRow(_stay, needs_place=False, arms=True, level=True, by_hand=True),
    Mode.AUTO: CopterRow(_stay),
    Mode.GUIDED: CopterRow(_stay, arms=True),
    Mode.LOITER: CopterRow(_stay, arms=True, by_hand=True),
    Mode.POSHOLD: CopterRow(_stay, arms=True, by_hand=True),
    Mode.BRAKE: CopterRow(_stay),
    Mode.CIRCLE: CopterRow(_stay),
    Mode.RTL: CopterRow(fly_home, lands=True),
    Mode.SMARTRTL: CopterRow(fly_home, lands=True),
    Mode.LAND: CopterRow(land_here, needs_place=False, lands=True),
}
