"""When setpoints go out: on absolute deadlines, and never two for one."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Schedule", "StreamFigures"]


@dataclass(frozen=True, slots=True)
class StreamFigures:
    """How steadily the setpoints went out."""

    sent_n: int
    rate_hz: float
    worst_gap_s: float


class Schedule:
    """Deadlines `period_us` apart. After a stall the missed ones are dropped, not made up for."""

    def __init__(self, period_us: int) -> None:
        self.due_us = 0
        self._period_us = period_us
        self._sent_n = 0
        self._gaps_n = 0
        self._gaps_us = 0
        self._last_us: int | None = None
        self._worst_us = 0

    def start(self, now_us: int) -> None:
        """Make `now_us` the first deadline."""
        self.due_us = now_us

    def take(self, now_us: int) -> bool:
        """Whether a deadline has come; if so, the next is the first one after `now_us`."""
        if now_us < self.due_us:
            return False
        self.due_us += self._period_us * ((now_us - self.due_us) // self._period_us + 1)
        return True

    def sent(self, now_us: int) -> float:
        """Count a setpoint; the gap to the one before in seconds, 0 for the first of a stream."""
        self._sent_n += 1
        last_us, self._last_us = self._last_us, now_us
        if last_us is None:
            return 0.0
        gap_us = now_us - last_us
        self._gaps_n += 1
        self._gaps_us += gap_us
        self._worst_us = max(self._worst_us, gap_us)
        return gap_us * 1e-6

    def paused(self) -> None:
        """The stream has ended: the next setpoint begins another."""
        self._last_us = None

    @property
    def figures(self) -> StreamFigures:
        """Count, mean rate and worst gap so far."""
        rate_hz = self._gaps_n * 1e6 / self._gaps_us if self._gaps_us else 0.0
        return StreamFigures(self._sent_n, rate_hz, self._worst_us * 1e-6)
