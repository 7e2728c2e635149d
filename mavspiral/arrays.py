"""Locked arrays: what every value type of mavspiral holds."""

from __future__ import annotations

from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["FloatArray", "locked"]

FloatArray = NDArray[np.float64]


def locked(values: ArrayLike, *, shape: tuple[int | None, ...], name: str) -> FloatArray:
    """`values` as a read-only float64 array: a copy, unless they are one of their own already.

    Args:
        values: what to lock.
        shape: the demanded shape; None allows any length on that axis.
        name: how an error calls the array.

    Raises:
        ValueError: the shape differs, or an element is NaN or infinite (its index is named).
    """
    array = values if _is_locked(values) else np.array(values, dtype=np.float64)
    if array.ndim != len(shape) or any(
        want is not None and have != want for have, want in zip(array.shape, shape, strict=True)
    ):
        wanted = tuple("any" if want is None else want for want in shape)
        raise ValueError(f"{name} has shape {array.shape}, wanted {wanted}")
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise ValueError(f"{name} is not finite at index {index}: {array[index]}")
    array.setflags(write=False)
    return array


def _is_locked(values: ArrayLike) -> TypeGuard[FloatArray]:
    """Whether nobody can write to them, not even through another array."""
    return (
        isinstance(values, np.ndarray)
        and values.dtype == np.float64
        and values.base is None
        and not values.flags.writeable
    )
