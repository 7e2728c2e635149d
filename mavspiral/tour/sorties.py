"""An inspection in sorties: which stretch of it each battery flies, and the legs of that stretch.

The inspection is all that lies between the way to it and the way back. Its own time, `…_s` here, is as planned
in one go and begins with its first leg, wherever home is. A stretch is the same curve, cut, and timed anew from
rest to rest; nothing is fitted again. Cuts are at shots, and every sortie but the first begins some shots
before the last one ended.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray, locked
from mavspiral.curve.stretch import Stretch
from mavspiral.errors import LimitError
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.trajectory import Leg, Trajectory, belongs

__all__ = [
    "OVERLAP_SHOTS_N",
    "Sortie",
    "digest_of",
    "flies",
    "plan_sorties",
    "stretch",
]

OVERLAP_SHOTS_N = 3
"""A sortie begins so many shots before the last one ended.

Two shots tie the pictures of both: at a side overlap of 0.6 pictures two apart still share a fifth. The third is for
what a killed process may not have written down.
"""

Retime = Callable[[Leg], TimeLaw]
"""The law from rest to rest of a cut leg, whose own law is still that of the whole."""

_MOMENT_S = 0.05
_CUTS_N = 64
"""At so many places a cut is thought of: the way home is short on one side of a tower and leads over it on the other."""

_HALVINGS_N = 20
_DIGEST_N = 500
_MORE_N = 3


@dataclass(frozen=True, slots=True, eq=False)
class Sortie:
    """The stretch of the inspection from `begin_s` to `end_s` of its own time, and the legs that fly it.

    The i-th of `planned_s` (n,) is the inspection's own time when `flown_s` (n,) have passed on the legs.
    """

    begin_s: float
    end_s: float
    legs: tuple[Leg, ...]
    flown_s: FloatArray
    planned_s: FloatArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the tables."""
        for name in ("flown_s", "planned_s"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(None,), name=name))

    def inspection_s(self, t_s: FloatArray | list[float] | float) -> FloatArray:
        """The inspection's own time, `t_s` after the first of the legs has begun; NaN before and after them."""
        return np.asarray(np.interp(t_s, self.flown_s, self.planned_s, left=np.nan, right=np.nan))


def flies(sortie: Sortie, shots_s: FloatArray) -> NDArray[np.bool_]:
    """Which of those shots, `(n,)` of the inspection's own time, the sortie flies."""
    return np.asarray((shots_s >= sortie.begin_s - _MOMENT_S) & (shots_s <= sortie.end_s + _MOMENT_S))


def shots_on(sortie: Sortie, shots_s: FloatArray, route: Trajectory) -> FloatArray:
    """The path times on `route` of those shots, `(n,)` of the inspection's own time, that the sortie flies."""
    flown_s = np.interp(shots_s[flies(sortie, shots_s)], sortie.planned_s, sortie.flown_s)
    begins_s, ends_s = route.span_s("inspection")
    return np.clip(begins_s + flown_s, begins_s, ends_s - _MOMENT_S / 2)


def digest_of(legs: tuple[Leg, ...], shots_s: FloatArray) -> str:
    """Sixteen hex digits that change with where and when the inspection is flown, by a millimetre or so, and its shots."""
    told = hashlib.sha256()
    for leg in legs:
        u = leg.law(np.linspace(0.0, leg.law.duration_s, _DIGEST_N))
        told.update(leg.name.encode())
        for values in (leg.path(u), leg.gaze(u), np.array([leg.law.duration_s])):
            told.update(np.round(np.asarray(values) * 1e3).astype("<i8").tobytes())
    told.update(np.round(shots_s * 1e3).astype("<i8").tobytes())
    return told.hexdigest()[:16]


def stretch(legs: tuple[Leg, ...], begin_s: float, end_s: float, retime: Retime) -> Sortie:
    """The part of the inspection `legs` from `begin_s` to `end_s`. Whole legs stay as they are.

    Raises:
        ValueError: it holds nothing to inspect.
    """
    pieces: list[tuple[Leg, FloatArray]] = []
    start_s = 0.0
    for leg in legs:
        first_s, last_s = max(begin_s - start_s, 0.0), min(end_s - start_s, leg.law.duration_s)
        if last_s - first_s > _MOMENT_S:
            pieces.append(_piece(leg, first_s, last_s, start_s, retime))
        start_s += leg.law.duration_s
    while pieces and not belongs(pieces[0][0].name, "inspection"):
        pieces.pop(0)
    while pieces and not belongs(pieces[-1][0].name, "inspection"):
        pieces.pop()
    if not pieces:
        raise ValueError(f"nothing is inspected from {begin_s:.2f} to {end_s:.2f} s")
    begins_s = np.cumsum([0.0, *(leg.law.duration_s for leg, _ in pieces)])
    flown_s = [begin_s + _knots_s(leg.law) for begin_s, (leg, _) in zip(begins_s, pieces, strict=False)]
    planned_s = [planned for _, planned in pieces]
    return Sortie(
        float(planned_s[0][0]),
        float(planned_s[-1][-1]),
        tuple(leg for leg, _ in pieces),
        np.concatenate(flown_s),
        np.concatenate(planned_s),
    )


def plan_sorties(
    legs: tuple[Leg, ...],
    shots_s: FloatArray,
    *,
    endurance_s: float,
    flight_s: Callable[[Sortie], float],
    retime: Retime,
    begin_s: float = 0.0,
    end_s: float = math.inf,
) -> tuple[Sortie, ...]:
    """The fewest sorties of about equal length that fly the inspection from `begin_s` to `end_s`, or its end.

    Args:
        legs: the inspection: passes and the ways between them.
        shots_s: its shots, in its own time, rising.
        endurance_s: what no flight may exceed.
        flight_s: how long a sortie takes from home to home.
        retime: the law for a cut leg.
        begin_s: where the inspection goes on.
        end_s: and to where.

    Raises:
        LimitError: however short, a sortie takes longer than `endurance_s`.
    """
    whole = stretch(legs, begin_s, min(end_s, sum(leg.law.duration_s for leg in legs)), retime)
    if flight_s(whole) <= endurance_s:
        return (whole,)
    shots_s = shots_s[flies(whole, shots_s)]
    cuts = np.unique(np.linspace(0, len(shots_s) - 1, _CUTS_N).astype(int))
    moments_s = _moments_s(legs, shots_s[cuts])
    flights_s = [flight_s(stretch(legs, at_s, at_s + 3 * _MOMENT_S, retime)) for at_s in moments_s]
    ways_s = np.interp(np.arange(len(shots_s)), cuts, flights_s)
    least_n = len(_filled(shots_s, ways_s, cuts, endurance_s))
    for count in range(least_n, least_n + _MORE_N) if least_n else ():
        rows = _even(shots_s, ways_s, cuts, count)
        sorties = tuple(stretch(legs, shots_s[a], shots_s[b], retime) for a, b in rows)
        if max(map(flight_s, sorties)) <= endurance_s:
            return sorties
    raise LimitError(
        f"[vehicle] endurance_s = {endurance_s:g} leaves nothing to inspect: the way there and back alone takes "
        f"{min(flights_s):.0f} to {max(flights_s):.0f} s. "
        "Fix: a home nearer to the building, a smaller band (bottom_m, top_m), or another battery"
    )


def _moments_s(legs: tuple[Leg, ...], shots_s: FloatArray) -> list[float]:
    """When a moment of three `_MOMENT_S` begins at each shot, within its own pass: what there and back takes, and no more.

    The last shot of a pass is at its very end, and what follows is a way on which nothing is inspected.
    """
    ends_s = np.cumsum([leg.law.duration_s for leg in legs])
    ends_s = ends_s[[belongs(leg.name, "inspection") for leg in legs]]
    own = np.searchsorted(ends_s, shots_s - _MOMENT_S / 2).clip(max=len(ends_s) - 1)
    begins_s: list[float] = np.minimum(shots_s, ends_s[own] - 3 * _MOMENT_S).tolist()
    return begins_s


def _even(
    shots_s: FloatArray, ways_s: FloatArray, cuts: NDArray[np.intp], count: int
) -> list[tuple[int, int]]:
    """At most `count` sorties whose longest is as short as can be."""
    shortest_s, longest_s = 0.0, float(shots_s[-1] - shots_s[0] + ways_s.max())
    for _ in range(_HALVINGS_N):
        each_s = (shortest_s + longest_s) / 2
        if 0 < len(_filled(shots_s, ways_s, cuts, each_s)) <= count:
            longest_s = each_s
        else:
            shortest_s = each_s
    return _filled(shots_s, ways_s, cuts, longest_s)


def _filled(
    shots_s: FloatArray, ways_s: FloatArray, cuts: NDArray[np.intp], each_s: float
) -> list[tuple[int, int]]:
    """Sorties of at most `each_s`, first and last shot of each, as long as they come; none if that is too short."""
    rows: list[tuple[int, int]] = []
    first = 0
    while True:
        flights_s = shots_s[cuts] - shots_s[first] + (ways_s[first] + ways_s[cuts]) / 2
        within = cuts[(flights_s <= each_s) & (cuts > first + OVERLAP_SHOTS_N)]
        if not len(within):
            return []
        rows.append((first, int(within[-1])))
        if within[-1] == len(shots_s) - 1:
            return rows
        first = int(within[-1]) - OVERLAP_SHOTS_N


def _piece(leg: Leg, first_s: float, last_s: float, start_s: float, retime: Retime) -> tuple[Leg, FloatArray]:
    """The leg between two of its own times, and when the plan comes to each knot of its law."""
    if last_s - first_s >= leg.law.duration_s:
        return leg, start_s + _knots_s(leg.law)
    u_begin_rad, u_end_rad = leg.law([first_s, last_s])
    path, gaze, pitch = (
        Stretch(whole, float(u_begin_rad), float(u_end_rad - u_begin_rad))
        for whole in (leg.path, leg.gaze, leg.gimbal_pitch)
    )
    cut = replace(leg, path=path, gaze=gaze, gimbal_pitch=pitch)
    law = retime(cut)
    planned_s = np.interp(u_begin_rad + law.phase_rad, leg.law.phase_rad, _knots_s(leg.law))
    return replace(cut, law=law), start_s + planned_s


def _knots_s(law: TimeLaw) -> FloatArray:
    knots_s: FloatArray = law.step_s * np.arange(len(law.phase_rad), dtype=np.float64)
    return knots_s
