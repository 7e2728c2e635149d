"""Where to fly, without time: curves of a phase `u`, and the gaze along them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Protocol

from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray

__all__ = ["Differentiable", "Path"]


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


class Differentiable(ABC):
    """What knows itself and its derivatives along a phase all at once, and is called for one of them."""

    __slots__ = ()

    @abstractmethod
    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The value and its derivatives, `(orders, …)`."""

    def __call__(self, u_rad: ArrayLike, order: int = 0) -> FloatArray:
        """The value, or its derivative of `order`, as far as the `jet` goes.

        Raises:
            ValueError: it does not go so far.
        """
        jet = self.jet(u_rad)
        if order not in range(len(jet)):
            raise ValueError(f"order is {order}, wanted 0 to {len(jet) - 1}")
        derivative: FloatArray = jet[order]
        return derivative
