"""Whether the vehicle's position has jumped, or only the frame that it is told in.

An estimator that is given another origin, or hands over to another with an origin of its own, tells another local position of
the same place. Its origin tells it apart: where that has moved as much the other way, nothing but numbers has changed, and
the flight goes on in the frame that it began in. Until that is known it goes on so, too: after a jump of numbers
the vehicle would otherwise fly, and towards the wall as well as away from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from mavspiral.flight.doubts import Doubts
from mavspiral.flight.messages import Command, MessageId, Origin, Triple
from mavspiral.flight.origin import moved_ned_m, origin_at
from mavspiral.flight.schedule import Schedule
from mavspiral.flight.situation import Situation

__all__ = ["Anchor"]

_AGREES_M = 0.3
_OPEN_S = 0.6
"""Of the vehicle's time: three questions and their answers, on a slow link one."""

_ASK_US = 150_000
_STILL = (0.0, 0.0, 0.0)


class Anchor:
    """Keeps the frame that a flight began in, when the vehicle's own has moved.

    Args:
        situation: of the session.
        send: takes what is asked of the vehicle.

    Attributes:
        known: the vehicle's origin as it was last looked at.
    """

    def __init__(self, situation: Situation, send: Callable[[bytes], None]) -> None:
        self.known: Origin | None = None
        self._s = situation
        self._send = send
        self._asks = Schedule(_ASK_US)
        self._since_us: int | None = None
        self._told: Origin | None = None  # the vehicle's origin when it opened
        self._before: Triple | None = None  # the vehicle's offset when it opened

    def settled(self, doubts: Doubts) -> bool:
        """Whether a jump, or an origin that moved, is what it looks like; False as long as the other may yet be heard of."""
        s = self._s
        now = s.vehicle.origin
        known = self.known or s.origin
        moved = _STILL if now is None or known is None or now is known else moved_ned_m(known, now)
        jump = doubts.shift_ned_m if doubts.jump and doubts.at_once else None
        if jump is None and math.hypot(*moved) <= s.config.governor.reserve_m:
            self._close(self._before)
            return True
        if self._since_us is None:
            self._since_us, self._told, self._before = s.now_us, now, s.vehicle.offset_ned_m
            self._asks.start(s.now_us)
            if jump is not None:
                s.vehicle.reckon_from(_sum(self._before, jump))
        if jump is not None and math.hypot(*_sum(moved, jump)) < _AGREES_M:
            doubts.jumped()
            self._close(_sum(self._before, _times(moved, -1.0)))
            self.known = now
            words = f"the vehicle's local frame has moved by {math.hypot(*moved):.1f} m, not the vehicle"
            s.tell("warning", f"{words}; the flight goes on where it was")
            return True
        answered = jump is not None and now is not self._told
        if answered or (s.now_us - self._since_us) * 1e-6 * max(1.0, s.clock.rate) > _OPEN_S:
            self._close(self._before)
            return True
        if self._asks.take(s.now_us):
            self._send(s.link.command(Command.REQUEST_MESSAGE, MessageId.GPS_GLOBAL_ORIGIN))
        return False

    def origin(self, told: Origin) -> Origin:
        """Where the frame that the flight began in begins, when the vehicle tells that its own begins at `told`."""
        self.known = told
        offset = self._s.vehicle.offset_ned_m
        return told if offset is None else origin_at(told, offset)

    def _close(self, offset_ned_m: Triple | None) -> None:
        if self._since_us is not None:
            self._since_us = None
            self._s.vehicle.reckon_from(offset_ned_m)


def _sum(a: Triple | None, b: Triple) -> Triple:
    n, e, d = _STILL if a is None else a
    return n + b[0], e + b[1], d + b[2]


def _times(a: Triple, factor: float) -> Triple:
    return a[0] * factor, a[1] * factor, a[2] * factor
