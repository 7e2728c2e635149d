"""The passes of an inspection, each around or along one piece of the building, and the tour from one to the next."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mavspiral.curve import Path
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import LEVEL, Leg
from mavspiral.motion.turn import Gaze
from mavspiral.transit import Look, Ways

__all__ = ["Kind", "Pass", "Piece", "flown_in_order", "tour_of"]

Kind = Literal["spiral", "courtyard", "facade", "roof"]
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
    leg: Leg

    @property
    def path(self) -> Path:
        """The curve."""
        return self.leg.path

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


def flown_in_order(pieces: Sequence[Piece]) -> tuple[Pass, ...]:
    """The pieces with their time laws. The leg of a lone one is called "inspection", else "inspection-NAME"."""
    lone = len(pieces) == 1
    return tuple(
        Pass(
            piece.name,
            piece.kind,
            piece.rings,
            piece.harmonics,
            piece.standoff_m,
            Leg(
                "inspection" if lone else f"inspection-{piece.name.replace(' ', '-')}",
                piece.path,
                piece.gaze,
                fastest_law(piece.path, piece.gaze, piece.pace),
                piece.gimbal_pitch,
            ),
        )
        for piece in pieces
    )


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
            f"{before.name} and {after.name}",
        )
        legs.append(after.leg)
    return tuple(legs)
