"""A stretch of a curve, or of what goes with it: the same, from a phase on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray
from mavspiral.curve import Differentiable

__all__ = ["Stretch"]


class _Whole(Protocol):
    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The value and its derivatives, `(orders, …)`."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretch(Differentiable):
    """`whole`, a path or a gaze along it, from the phase `u_begin_rad` on, for `u_end_rad`."""

    whole: _Whole
    u_begin_rad: float
    u_end_rad: float

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The whole's, `u_begin_rad` further on."""
        return self.whole.jet(np.asarray(u_rad, dtype=np.float64) + self.u_begin_rad)
