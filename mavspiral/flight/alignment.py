"""On-site alignment: the vehicle stands at a place that the plan knows, and its own position says where the plan lies.

A map may be some metres off; its corners are then off by the same. The plan is shifted with all that stands on its map,
so that the clearance to the true building is as planned. Heights are not shifted: they are told.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import LimitError
from mavspiral.flight.messages import Triple
from mavspiral.flight.situation import Situation
from mavspiral.frames import GeoPoint, LocalFrame

__all__ = ["SHIFT_MAX_M", "Alignment", "approved", "measured", "prepare", "shifted"]

SHIFT_MAX_M = 5.0
"""A larger shift is taken for a wrong corner: maps are rarely so far off, and corners are often so far apart."""

_AVERAGE_S = 10.0
_SPREAD_MAX_M = 0.5
_ROWS_MIN_N = 20
_SETTLE_US = 2_000_000
"""Who asks may have kept us from listening: what is heard first is old."""


@dataclass(slots=True)
class Alignment:
    """What is measured, of a vehicle that stands at `place_enu_m` (3,) of the plan.

    Args:
        shift_enu_m: by which the plan is shifted, once it is measured; its height is 0.
        rise_m: how much higher the vehicle says that it stands than the plan has it.
        spread_m: how far its positions lay from their mean, RMS.
        question: what must be approved before the plan is shifted; empty until it is measured.
        approved: whether it was.
    """

    place_enu_m: FloatArray
    shift_enu_m: FloatArray | None = None
    rise_m: float = math.nan
    spread_m: float = math.nan
    question: str = ""
    approved: bool = False
    _approved_us: int | None = None
    _origin: object = None
    _newest: object = None
    _positions_ned_m: list[Triple] = field(default_factory=list)


def shifted(frame: LocalFrame, shift_enu_m: FloatArray) -> LocalFrame:
    """The plan's `frame` where it really lies."""
    return LocalFrame(frame.geo_point(shift_enu_m)) if np.any(shift_enu_m) else frame


def prepare(s: Situation) -> None:
    """Tell what is awaited."""
    s.tell("info", f"averaging its position for {_AVERAGE_S:g} s: leave it where it stands")


def measured(s: Situation) -> bool:
    """Whether the shift is known.

    Raises:
        LimitError: the vehicle does not stand still, or not where it is said to stand.
    """
    a = s.alignment
    assert a is not None and s.vehicle.origin is not None
    if s.vehicle.origin != a._origin:  # another frame: what came before does not count
        a._origin = s.vehicle.origin
        a._positions_ned_m.clear()
        s.entered_us = s.now_us
    if s.vehicle.local is not a._newest:
        a._newest = s.vehicle.local
        a._positions_ned_m.append(s.vehicle.position_ned_m)
    if s.elapsed_s < _AVERAGE_S or len(a._positions_ned_m) < _ROWS_MIN_N:
        return False
    _judge(s, a)
    return True


def approved(s: Situation) -> bool:
    """Whether the user has agreed, and we have listened again since; then the plan lies where it was measured to lie."""
    a = s.alignment
    assert a is not None and a.shift_enu_m is not None
    if not a.approved:
        return False
    if a._approved_us is None:
        a._approved_us = s.now_us
    if s.now_us - a._approved_us < _SETTLE_US:
        return False
    s.frame = shifted(s.frame, a.shift_enu_m)
    s.tell("info", f"aligned: the plan is shifted by {_way(a.shift_enu_m)}")
    return True


def _judge(s: Situation, a: Alignment) -> None:
    assert s.vehicle.origin is not None
    to_vehicle = s.frame.to_vehicle(GeoPoint(*s.vehicle.origin))
    positions_enu_m = to_vehicle.position_enu_m(np.array(a._positions_ned_m))
    here_enu_m = positions_enu_m.mean(axis=0)
    off_m = (positions_enu_m - here_enu_m)[:, :2]
    a.spread_m = float(np.sqrt((off_m**2).sum(axis=1).mean()))
    if a.spread_m > _SPREAD_MAX_M:
        raise LimitError(
            f"its position wanders by {a.spread_m:.2f} m while it stands, at most {_SPREAD_MAX_M:g} m is taken; "
            "wait for its GPS, and leave it where it stands"
        )
    difference_m = here_enu_m - a.place_enu_m
    shift_enu_m = np.array([*difference_m[:2], 0.0])
    a.rise_m = float(difference_m[2])
    if (shift_m := math.hypot(*shift_enu_m)) > SHIFT_MAX_M:
        raise LimitError(
            f"by its own position it stands {shift_m:.1f} m from there ({_way(shift_enu_m)}), at most {SHIFT_MAX_M:g} m "
            "are taken for the map's error; is it the right corner?"
        )
    a.shift_enu_m = shift_enu_m
    alt_m, where = s.frame.geo_point(here_enu_m).alt_amsl_m, "above" if a.rise_m >= 0.0 else "below"
    s.tell(
        "info",
        f"heights stay as planned: it says that it stands at {alt_m:.1f} m AMSL, {abs(a.rise_m):.1f} m {where} that place",
    )
    a.question = f"shift the plan and its obstacles by {_way(shift_enu_m)} ({shift_m:.2f} m, known to {a.spread_m:.2f} m)"


def _way(shift_enu_m: FloatArray) -> str:
    east_m, north_m = shift_enu_m[:2]
    return (
        f"{abs(east_m):.2f} m {'east' if east_m >= 0 else 'west'} and "
        f"{abs(north_m):.2f} m {'north' if north_m >= 0 else 'south'}"
    )
