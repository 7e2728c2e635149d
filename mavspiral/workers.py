"""The threads that kernels run on beside each other, for they run without the interpreter."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

__all__ = ["by_stretches", "workers"]

WORKERS = 2
LONGEST = 8192
"""So many places are worked out at once: what lies between then stays in the processor's cache."""
WORTH = 4096
"""Fewer are done sooner than they are handed over."""

Found = TypeVar("Found")


@cache
def workers() -> ThreadPoolExecutor:
    """The process's own, begun when first asked for. What runs on them must not wait for them."""
    return ThreadPoolExecutor(WORKERS, thread_name_prefix="kernels")


# A process that is forked has no threads but the one that forked it.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=workers.cache_clear)


def by_stretches(work: Callable[[int, int], Found], places: int) -> list[Found]:
    """What `work(first, last)` makes of each stretch of so many places, in order; the workers share them evenly."""
    if places < WORTH:
        return [work(0, places)]
    stretches = WORKERS * -(-places // (WORKERS * LONGEST))
    edges = [places * i // stretches for i in range(stretches + 1)]
    return list(workers().map(work, edges[:-1], edges[1:]))
