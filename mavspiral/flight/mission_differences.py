"""Two lists of mission items, the one that was sent and the one that came back, compared as MAVLink rounds them."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from mavspiral.flight.mission_messages import MissionItem

__all__ = ["differences"]

_PLACELESS = 2  # MAV_FRAME_MISSION


def differences(sent: Sequence[MissionItem], back: Sequence[MissionItem]) -> tuple[str, ...]:
    """What came back otherwise than it was sent, one line for each item; numbers as MAVLink rounds them.

    Nothing is a difference that means the same: the two spellings of a global frame, any frame where MAV_FRAME_MISSION
    said that there is no place (ArduPilot keeps 0), a heading one turn off, and 0 for a parameter that was left open.
    """
    if len(sent) != len(back):
        return (f"{len(sent)} items were sent, {len(back)} came back",)
    told = []
    for ours, theirs in zip(sent, back, strict=True):
        wrong = [
            f"{name} {a!r} came back as {b!r}"
            for name, a, b in (
                ("command", ours.command, theirs.command),
                (
                    "frame",
                    _frame(ours.frame),
                    _frame(ours.frame if ours.frame == _PLACELESS else theirs.frame),
                ),
                ("x", ours.x, theirs.x),
                ("y", ours.y, theirs.y),
                ("autocontinue", ours.autocontinue, theirs.autocontinue),
            )
            if a != b
        ]
        wrong += [
            f"param{number} {a:g} came back as {b:g}"
            for number, a, b in zip(
                (1, 2, 3, 4, 7), (*ours.params, ours.z), (*theirs.params, theirs.z), strict=True
            )
            if not _same(a, b, turns=number == 4)
        ]
        if wrong:
            told.append(f"item {ours.seq + 1}: {', '.join(wrong)}")
    return tuple(told)


def _same(ours: float, theirs: float, *, turns: bool) -> bool:
    if math.isnan(ours):
        return math.isnan(theirs) or theirs == 0.0
    ours, theirs = struct.unpack("<2f", struct.pack("<2f", ours, theirs))  # as MAVLink carries them
    if turns and math.isfinite(theirs):
        return abs(math.remainder(ours - theirs, 360.0)) < 1e-4
    return ours == theirs


def _frame(frame: int) -> int:
    return {5: 0, 6: 3, 11: 10}.get(frame, frame)
