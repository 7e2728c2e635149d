"""The passes of an inspection, each around or along one piece of the building, and the tour from one to the next."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mavspiral.curve import Path
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.limits import Limits
from mavspiral.motion.sight import Sight
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg
from mavspiral.motion.turn import LEVEL, Gaze
from mavspiral.tour.transit import Look, Ways

__all__ = ["Kind", "Pass", "Piece", "flown_in_order", "retimed", "tour_of"]

Kind = Literal["spiral", "courtyard", "facade", "roof", "fill"]
LENGTH_SAMPLES = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One curve past a piece of the building, and where the camera looks along it, without time.

    `pace` is what its time law keeps, and `standoff_m` how far the walls are.
    """

    name: str
    kind: Kind
    path: Path
    gaze: Gaze
    rings: int
    harmonics: int
    standoff_m: float
    pace: Limits
    gimbal_pitch: Gaze = LEVEL


@dataclass(frozen=True, slots=True, eq=False)
class Pass:
    """A piece as it is flown, from rest to rest."""

    name: str
    kind: Kind
    rings: int
    harmonics: int
    standoff_m: float
    pace: Limits
    leg: Leg

    @property
    def path(self) -> Path:
        """The curve."""
        return self.leg.path

    @property
    def leg_name(self) -> str:
        """What its leg is called, unless it is the only one."""
        return _leg_name(self.name)

    @property
    def entry(self) -> Look:
        """Where nose and camera point at its entry."""
        return Look.at(self.leg, 0.0)

    @property
    def exit(self) -> Look:
        """Where nose and camera point at its exit."""
        return Look.at(self.leg, self.path.u_end_rad)

    @property
    def length_m(self) -> float:
        """The way from its entry to its exit."""
        u = np.linspace(0.0, self.path.u_end_rad, LENGTH_SAMPLES)
        return float(np.sqrt((np.diff(self.path(u), axis=0) ** 2).sum(axis=1)).sum())


def flown_in_order(
    pieces: Sequence[Piece], sharp_mps: Callable[[float], float] = lambda standoff_m: math.inf
) -> tuple[Pass, ...]:
    """The pieces with their time laws. The leg of a lone one is called "inspection", else "inspection-NAME".

    `sharp_mps` tells how fast what is so far away may pass through the picture.
    """
    lone = len(pieces) == 1
    passes = []
    for piece in pieces:
        name = "inspection" if lone else _leg_name(piece.name)
        fast_mps = sharp_mps(piece.standoff_m)
        sight = Sight(piece.standoff_m, fast_mps) if math.isfinite(fast_mps) else None
        law = fastest_law(piece.path, piece.gaze, piece.pace, sight=sight, pitch=piece.gimbal_pitch)
        leg = Leg(name, piece.path, piece.gaze, law, piece.gimbal_pitch, sight)
        passes.append(
            Pass(
                name=piece.name,
                kind=piece.kind,
                rings=piece.rings,
                harmonics=piece.harmonics,
                standoff_m=piece.standoff_m,
                pace=piece.pace,
                leg=leg,
            )
        )
    return tuple(passes)


def _leg_name(piece: str) -> str:
    return f"inspection-{piece.replace(' ', '-')}"


def retimed(leg: Leg, whole: Pass) -> TimeLaw:
    """The law of a part of a pass's leg, from rest to rest."""
    return fastest_law(leg.path, leg.gaze, whole.pace, sight=leg.sight, pitch=leg.gimbal_pitch)


def tour_of(passes: Sequence[Pass], ways: Ways) -> tuple[Leg, ...]:
    """The legs from the first pass's entry to the last one's exit: passes, and transits "transit-K-…" between them.

    Raises:
        LimitError: there is no safe way between two of them.
    """
    legs = [passes[0].leg]
    for number, (before, after) in enumerate(itertools.pairwise(passes), start=1):
        legs += ways.legs(
            before.path(before.path.u_end_rad),
            after.path(0.0),
            f"transit-{number}",
            (before.exit, after.entry),
            (before.name, after.name),
        )
        legs.append(after.leg)
    return tuple(legs)
