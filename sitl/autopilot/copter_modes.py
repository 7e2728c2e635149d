"""ArduCopter's modes as a table: what each does, and when it may be entered and armed in.

A mode is a trip to glide along; GUIDED and AUTO have rooms of their own. The sticks of a pilot who is not there stand
in their middle: STABILIZE and ALT_HOLD keep level and keep their height.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sitl.autopilot.glide import Glide
from sitl.autopilot.trip import Trip, fly_home, hold_here, land_here
from sitl.orders import Home, Mode

__all__ = ["COPTER_MODES", "CopterRow", "after_gcs_loss"]

_Begin = Callable[[Glide, Home | None, Mapping[str, float]], Trip]


@dataclass(frozen=True, slots=True)
class CopterRow:
    """One mode: its trip, whether it needs a position, whether one may arm in it, and whether it comes down."""

    trip: _Begin
    needs_place: bool = True
    arms: bool = False
    lands: bool = False
    level: bool = False


def _stay(glide: Glide, _: Home | None, parameters: Mapping[str, float]) -> Trip:
    return hold_here(glide, parameters)


COPTER_MODES: Mapping[Mode, CopterRow] = {
    Mode.STABILIZE: CopterRow(_stay, needs_place=False, arms=True, level=True),
    Mode.ALT_HOLD: CopterRow(_stay, needs_place=False, arms=True, level=True),
    Mode.AUTO: CopterRow(_stay),
    Mode.GUIDED: CopterRow(_stay, arms=True),
    Mode.LOITER: CopterRow(_stay, arms=True),
    Mode.POSHOLD: CopterRow(_stay, arms=True),
    Mode.BRAKE: CopterRow(_stay),
    Mode.RTL: CopterRow(fly_home, lands=True),
    Mode.LAND: CopterRow(land_here, needs_place=False, lands=True),
}

_AFTER_GCS_LOSS = {5: Mode.LAND, 7: Mode.BRAKE}


def after_gcs_loss(parameters: Mapping[str, float]) -> Mode | None:
    """FS_GCS_ENABLE: what follows when the ground station's heartbeat stays away; None: nothing does.

    Simpler than ArduPilot: there is no SmartRTL, so that 3 and 4 return as 1 does.
    """
    value = parameters["FS_GCS_ENABLE"]
    action = int(value) if math.isfinite(value) else 0
    return _AFTER_GCS_LOSS.get(action, Mode.RTL) if action > 0 else None
