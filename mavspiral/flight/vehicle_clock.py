"""The vehicle's own time, read off its telemetry: offset and rate against the clock that drives us.

A straight line is fitted to the pairs (now, time since boot) by an expanding-memory alpha-beta filter:
recursive least squares until its memory is full, forgetting after that (Brookner, *Tracking and Kalman
Filtering Made Easy*, §1.2.10). A simulator at 20 times real time and one at 0.9 are both followed, and in
lockstep the line is exact.
"""

from __future__ import annotations

__all__ = ["VehicleClock"]

_MEMORY_N = 100
_SURE_N = 5
"""So many observations after a jump: one that was overtaken on its way is none."""

_JUMP_US = 1e6
_GAINS = [(min(1.0, 2 * (2 * n - 1) / (n * (n + 1))), 6 / (n * (n + 1))) for n in range(1, _MEMORY_N + 1)]
"""Alpha and beta of the n-th observation, from 1 on."""


class VehicleClock:
    """Vehicle time as a function of ours; both in microseconds.

    Attributes:
        rate: its microseconds in one of ours.
        jump_s: by how much it has jumped, once that is sure; whoever has acted on it makes it 0 again.
    """

    def __init__(self) -> None:
        self.rate = 1.0
        self.jump_s = 0.0
        self._jumped_us = 0.0
        self._n = 0
        self._now_us = 0
        self._vehicle_us = 0.0
        self._interval_us = 0.0  # mean, because packets bunch and one interval may be next to nothing

    @property
    def known(self) -> bool:
        """Whether anything has been heard yet."""
        return self._n > 0

    @property
    def jumps(self) -> bool:
        """Whether it may just have jumped."""
        return self._jumped_us != 0.0

    @property
    def interval_s(self) -> float:
        """How far apart the observations are on our clock, in the mean of the last hundred; 0 before the second."""
        return self._interval_us * 1e-6

    def observe(self, now_us: int, time_boot_ms: int) -> None:
        """Take in that the vehicle's clock showed `time_boot_ms` in a message that came at `now_us`."""
        heard_us = time_boot_ms * 1000.0
        elapsed_us = now_us - self._now_us
        expected_us = self._vehicle_us + self.rate * elapsed_us
        error_us = heard_us - expected_us
        if self._n == 0 or (abs(error_us) > _JUMP_US and abs(error_us) > _JUMP_US * self.rate):
            self._jumped_us += error_us if self._n else 0.0
            self._n, self._now_us, self._vehicle_us, self._interval_us = 1, now_us, heard_us, 0.0
            return
        if elapsed_us <= 0:
            return
        n = self._n
        if n < _MEMORY_N:
            self._n = n = n + 1
            if n == _SURE_N and abs(self._jumped_us) > _JUMP_US:
                self.jump_s = self._jumped_us * 1e-6
            if n == _SURE_N:
                self._jumped_us = 0.0
        alpha, beta = _GAINS[n - 1]
        self._interval_us += (elapsed_us - self._interval_us) / (n - 1)
        self._vehicle_us = expected_us + alpha * error_us
        self._now_us = now_us
        self.rate = max(0.01, self.rate + beta * error_us / self._interval_us)

    def at(self, now_us: int) -> float:
        """Vehicle time at `now_us`, carried on from the newest message."""
        return self._vehicle_us + self.rate * (now_us - self._now_us)
