"""In which order places are visited: the quickest tour from home through all of them and back."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.motion.limits import Limits

__all__ = ["quickest_order"]

EXHAUSTIVE = 7
"""Up to so many places every order is tried."""


def quickest_order(
    entry_enu_m: FloatArray, exit_enu_m: FloatArray, home_enu_m: FloatArray, limits: Limits
) -> tuple[int, ...]:
    """The order of places, each entered and left at its own rows `(n, 3)`, that takes the least time between them.

    A way takes its horizontal length at full speed and its vertical one at the climb's or the descent's. Beyond
    `EXHAUSTIVE` places: the nearest next, then 2-opt.
    """

    def ways_s(start_m: FloatArray, end_m: FloatArray) -> FloatArray:
        across = np.hypot(*np.moveaxis(end_m[..., :2] - start_m[..., :2], -1, 0)) / limits.speed_mps
        rise_m = end_m[..., 2] - start_m[..., 2]
        return np.asarray(
            across + np.where(rise_m > 0, rise_m / limits.climb_mps, -rise_m / limits.descent_mps)
        )

    between_s = ways_s(exit_enu_m[:, None], entry_enu_m[None, :])
    first_s, last_s = ways_s(home_enu_m, entry_enu_m), ways_s(exit_enu_m, home_enu_m)

    def cost_s(order: tuple[int, ...]) -> float:
        along = sum(float(between_s[a, b]) for a, b in itertools.pairwise(order))
        return float(first_s[order[0]]) + along + float(last_s[order[-1]])

    count = len(entry_enu_m)
    if count <= EXHAUSTIVE:
        return min(itertools.permutations(range(count)), key=cost_s)
    return _improved(_nearest_next(first_s, between_s), cost_s)


def _nearest_next(first_s: FloatArray, between_s: FloatArray) -> tuple[int, ...]:
    order = [int(np.argmin(first_s))]
    while len(order) < len(first_s):
        left = [index for index in range(len(first_s)) if index not in order]
        order.append(min(left, key=lambda index: float(between_s[order[-1], index])))
    return tuple(order)


def _improved(order: tuple[int, ...], cost_s: Callable[[tuple[int, ...]], float]) -> tuple[int, ...]:
    """2-opt: stretches are turned round as long as that is quicker."""
    best, best_s = order, cost_s(order)
    while True:
        turned = min(
            (
                best[:i] + best[i:j][::-1] + best[j:]
                for i, j in itertools.combinations(range(len(best) + 1), 2)
            ),
            key=cost_s,
        )
        if (turned_s := cost_s(turned)) >= best_s - 1e-9:
            return best
        best, best_s = turned, turned_s
