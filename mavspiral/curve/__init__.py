"""Where to fly, without time: curves of a phase `u`, and the gaze along them."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray

__all__ = ["Path"]


class Path(Protocol):
    """A curve in space: `path(u_rad, order)` for `u_rad` from 0 to `u_end_rad`."""

    @property
    def u_end_rad(self) -> float:
        """The phase at which the curve ends."""
        ...

    def __call__(self, u_rad: ArrayLike, order: int = 0) -> FloatArray:
        """The ENU position `(…, 3)`, or its derivative of `order` up to 3, in m/radᵒʳᵈᵉʳ."""
        ...

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The ENU position and its three derivatives, `(4, …, 3)`."""
        ...
