"""Which threads the machine runs first: the one that sends setpoints, and those that it may have to wait for.

A thread that writes the log holds the interpreter's lock for some microseconds at a time. If another program takes its processor
just then, the stream waits for that program too; so whoever shares the interpreter with the stream is run first as well.
"""

from __future__ import annotations

import contextlib
import os
from typing import Any

__all__ = ["run_as", "run_first"]

_PRIORITY = 10  # of SCHED_FIFO, 1 to 99


def run_first() -> Any:
    """How this thread was run until now, for `run_as`; None where the system does not let us change it."""
    with contextlib.suppress(OSError, AttributeError):  # not allowed, or not on this system
        before = os.sched_getscheduler(0), os.sched_getparam(0)
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(_PRIORITY))
        return before
    return None


def run_as(before: Any) -> None:
    """Run this thread as `before` again."""
    if before is not None:
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, *before)
