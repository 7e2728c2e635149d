"""Whether the vehicle's position can be trusted, by what the vehicle itself says: beside a wall a wrong one is a collision.

Fixes that are gone, or repeat themselves, leave it some seconds of dead reckoning (PX4: 5 s, EKF2_NOAID_TOUT): time to get
away from the wall. Fixes that are wrong look like any others, but an estimate that follows them moves otherwise than its own
speed says: at once where the filter gives in to fixes that it had refused (PX4: after 7 s), slowly where they creep. What
neither jumps nor creeps nobody can know.
"""

from __future__ import annotations

import math
from collections import deque

from mavspiral.flight.messages import GpsFix, LocalPosition

__all__ = ["Doubts"]

_WINDOW_MS, _EVERY_MS = 10_000, 500
_GAP_MS = 500
"""Over a longer silence nobody knows how fast it was."""

_LOST_MS, _SILENT_MS = 800, 2400
"""A receiver that says nothing: of the five words a second so many in a row do not get lost with three packets in ten."""

_LEARNS = 0.1
"""How fast it learns how often the receiver's words come."""

_MISSED_N, _POSITION_MS, _WHOLE = 5, 20.0, 0.95
"""Where that share of the positions comes, which are asked for every 20 ms, the link loses nothing: then so many words suffice."""

_FROZEN_MS, _MOVING_MPS = 1800, 0.5
_FIX_3D, _FIX_RTK = 3, 5
_FROZEN = "its GPS repeats itself"


class Doubts:
    """Takes in what comes, and says in words why the position is not to be trusted.

    Args:
        allowed_m: how far the estimate may move within 10 s beside what its speed explains, horizontally. Half of it where
            the receiver says that it has RTK. (The bundled vehicle round the kiosk: 0.1 m with RTK, 0.9 m without.)
            Also how far it may jump up or down.

    Attributes:
        fault: why the position will soon not be known, in words: as long as it is so.
        jump: why it is not what it was, in words, until that is said (`jumped`).
        shift_ned_m: by how much it is not; and `at_once`: from one position to the next.
    """

    def __init__(self, allowed_m: float) -> None:
        self._allowed_m = self._most_m = allowed_m
        self._last: LocalPosition | None = None
        self._beside_ned_m = (0.0, 0.0)
        self._before: deque[tuple[int, float, float]] = deque()
        self._fix: GpsFix | None = None
        self._fixed_ms = self._changed_ms = self._told_ms = 0
        self._every_ms, self._positions_n = float(_SILENT_MS), 0
        self.fault: str | None = None
        self.jump: str | None = None
        self.shift_ned_m = (0.0, 0.0, 0.0)
        self.at_once = False

    @property
    def misleads(self) -> bool:
        """Whether the estimate is wrong soon: refused for some seconds, fixes and speeds of a moment long ago are followed then."""
        return self.fault == _FROZEN

    def jumped(self) -> str | None:
        """Why the position is not what it was, in words: said once."""
        words, self.jump = self.jump, None
        return words

    def moved(self, now: LocalPosition) -> None:
        """Take in a position."""
        then, self._last = self._last, now
        self._positions_n += 1
        if then is None:
            return
        if not 0 < (dt_ms := now[0] - then[0]) < _GAP_MS:
            if dt_ms:
                self._before.clear()
                self._told_ms = self._fixed_ms = now[0] if self._fixed_ms else 0
            return
        half_s = 0.0005 * dt_ms
        north_m = now[1] - then[1] - half_s * (now[4] + then[4])
        east_m = now[2] - then[2] - half_s * (now[5] + then[5])
        was = self._beside_ned_m
        here = self._beside_ned_m = was[0] + north_m, was[1] + east_m
        before = self._before
        down_m = now[3] - then[3] - half_s * (now[6] + then[6])
        across = north_m * north_m + east_m * east_m > self._allowed_m**2
        if across or abs(down_m) > self._most_m:
            self.jump = (
                f"its position jumped by {math.hypot(north_m, east_m):.1f} m"
                if across
                else f"its height jumped by {-down_m:+.1f} m"
            )
            self.shift_ned_m, self.at_once = (north_m, east_m, down_m), True
            before.clear()
        elif not before or now[0] - before[-1][0] >= _EVERY_MS:
            moved = max(
                ((here[0] - n, here[1] - e) for _, n, e in before),
                key=lambda m: math.hypot(*m),
                default=(0.0, 0.0),
            )
            if (away_m := math.hypot(*moved)) > self._allowed_m:
                self.jump = f"its position moved by {away_m:.1f} m in 10 s otherwise than its speed says"
                self.shift_ned_m, self.at_once = (*moved, 0.0), False
                before.clear()
            before.append((now[0], *here))
            while now[0] - before[0][0] > _WINDOW_MS:
                before.popleft()
            if self._fixed_ms and self._silent(now[0] - self._told_ms):
                self.fault = "its GPS is silent"

    def _silent(self, since_ms: int) -> bool:
        """Whether the receiver itself is, and not the link, after so long without a word of it."""
        link_is_whole = self._positions_n * _POSITION_MS > _WHOLE * since_ms
        return since_ms > (min(_MISSED_N * self._every_ms, _SILENT_MS) if link_is_whole else _SILENT_MS)

    def fixed(self, fix: GpsFix) -> None:
        """Take in what the receiver says."""
        if self._last is None:
            return
        now_ms, then = self._last.time_boot_ms, self._fix
        self._every_ms += _LEARNS * (min(now_ms - self._told_ms, _SILENT_MS) - self._every_ms)
        self._told_ms, self._positions_n = now_ms, 0
        if fix.fix_type >= _FIX_3D:
            self._fixed_ms = now_ms
            self._allowed_m = self._most_m * (0.5 if fix.fix_type >= _FIX_RTK else 1.0)
        if then is None or (fix.lat_deg, fix.lon_deg) != (then.lat_deg, then.lon_deg):
            self._changed_ms = now_ms
        if math.hypot(self._last.north_mps, self._last.east_mps) < _MOVING_MPS:
            self._changed_ms = max(self._changed_ms, now_ms - round(self._frozen_ms / 2))
        self._fix = fix
        self.fault = None
        if self._fixed_ms and now_ms - self._fixed_ms > _LOST_MS:
            self.fault = "its GPS has no fix"
        elif self._fixed_ms and now_ms - self._changed_ms > self._frozen_ms:
            self.fault = _FROZEN

    @property
    def _frozen_ms(self) -> float:
        """How long fixes may repeat themselves."""
        return min(_MISSED_N * self._every_ms, _FROZEN_MS)
