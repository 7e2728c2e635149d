"""The errors that a user meets.

Each carries one line: the thing, its value, the limit, the place and a fix. `cli` maps them to exit codes:

    MavspiralError
    ├── InputError     the input contradicts itself or cannot be read       exit 2
    ├── LimitError     it was worked out, and it does not hold              exit 1
    └── LinkError      nobody at the other end, or the link was lost        exit 3
"""

from __future__ import annotations

__all__ = ["STOPPED", "InputError", "LimitError", "LinkError", "MavspiralError"]

STOPPED = 130
"""The exit code of Ctrl-C, as shells have it."""


class MavspiralError(Exception):
    """Base of every error that mavspiral raises on purpose."""

    exit_code = 1


class InputError(MavspiralError):
    """The input contradicts itself or cannot be read."""

    exit_code = 2


class LimitError(MavspiralError):
    """It was worked out and does not hold: a limit, a clearance, a plan that no autopilot takes."""

    exit_code = 1


class LinkError(MavspiralError):
    """Nobody answers at the other end of the link, or the link was lost for good."""

    exit_code = 3
