"""Whether the vehicle holds its height: one whose thrust no longer carries it must not go home over the building.

A weakened motor shows in nothing else: the autopilot gives up height before it gives up attitude.
"""

from __future__ import annotations

__all__ = ["SAG_M", "Sinking"]

SAG_M, _FOR_US = 1.0, 2_000_000
"""A healthy vehicle is within 0.3 m of its height, in gusts too; a height that its estimate jumps by is flown back sooner."""

_LATE_S = 0.5
"""What a link that is late by 200 ms each way makes of a climb."""


class Sinking:
    """Takes in how far the vehicle is below its path."""

    def __init__(self) -> None:
        self._since_us: int | None = None

    @property
    def began(self) -> bool:
        """Whether it was too low when last looked at."""
        return self._since_us is not None

    def look(self, now_us: int, below_m: float, climb_mps: float) -> str | None:
        """Why it must come down, in words; `below_m` under a path that climbs with `climb_mps`."""
        if below_m - _LATE_S * max(0.0, climb_mps) <= SAG_M:
            self._since_us = None
        elif self._since_us is None:
            self._since_us = now_us
        elif now_us - self._since_us > _FOR_US:
            return f"it sinks, {below_m:.1f} m below its path: its thrust does not carry it"
        return None
