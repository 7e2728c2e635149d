"""Asking for the streams that we live on and switching all others off, again and again until it has taken."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from mavspiral.flight.messages import Command
from mavspiral.flight.profile import Profile

__all__ = ["TelemetryRequest"]

_BURST_N = 6  # commands at once: an autopilot's queue is short, and a datagram stays small
_TAKES_US = 300_000  # what is still under way when we have asked does not count
_LISTEN_US = 1_000_000
_ENOUGH = 0.5  # of the rate that was asked for
_OFF = -1.0


class TelemetryRequest:
    """Asks for the profile's streams, listens for a second, asks for what differs, listens again.

    Nothing is assumed about what a vehicle streams by itself: whatever comes unwanted is switched off.
    """

    def __init__(self, profile: Profile) -> None:
        self.settled = False
        self._profile = profile
        self._pending = [(message_id, 1e6 / hz) for message_id, hz in profile.telemetry_hz.items()]
        self._pending += [(message_id, _OFF) for message_id in sorted(profile.quiet)]
        self._listen_us = 0
        self._before: Counter[int] | None = None

    def ask(self, now_us: int, arrivals: Counter[int], command: Callable[..., bytes]) -> list[bytes]:
        """The next requests to send; none while listening."""
        if not self._pending:
            if self._before is None:
                if now_us >= self._listen_us:
                    self._listen_us, self._before = now_us, arrivals.copy()
                return []
            if now_us < self._listen_us + _LISTEN_US:
                return []
            heard_s = (now_us - self._listen_us) * 1e-6
            self._pending = self._differences(arrivals - self._before, heard_s)
            self.settled = not self._pending
        batch, self._pending = self._pending[:_BURST_N], self._pending[_BURST_N:]
        self._listen_us, self._before = now_us + _TAKES_US, None
        return [command(Command.SET_MESSAGE_INTERVAL, message_id, interval) for message_id, interval in batch]

    def _differences(self, came: Counter[int], heard_s: float) -> list[tuple[int, float]]:
        wanted = self._profile.telemetry_hz
        scarce = [(i, 1e6 / hz) for i, hz in wanted.items() if came[i] < max(1, int(_ENOUGH * hz * heard_s))]
        unwanted = came.keys() - wanted.keys() - self._profile.kept
        return scarce + [(message_id, _OFF) for message_id in sorted(unwanted)]
