"""Does the battery last for the way home? From what it has taken so far, and how far home is."""

from __future__ import annotations

import math

from mavspiral.flight.situation import Situation

__all__ = ["Battery"]

_KNOWN_FROM_PCT = 3
"""Its level comes in whole per cents: a rate from fewer of them is a guess."""

_ACROSS_MPS, _UP_MPS, _DOWN_MPS = 4.0, 1.5, 1.5
_LANDING_S = 15.0


class Battery:
    """Learns what a second in the air takes, and says when it is time to return."""

    def __init__(self) -> None:
        self._full_pct: int | None = None
        self._since_us = 0.0

    def time_to_return(self, s: Situation) -> str | None:
        """Why the inspection must end now, in words; None while it need not, or the level is not known."""
        pct = s.vehicle.status.battery_pct if s.vehicle.status else None
        now_us = s.clock.at(s.now_us)
        if pct is None:
            return None
        if self._full_pct is None or pct > self._full_pct:
            self._full_pct, self._since_us = pct, now_us
        used_pct = self._full_pct - pct
        if used_pct < _KNOWN_FROM_PCT or now_us <= self._since_us:
            return None
        rate_pct_per_s = used_pct / ((now_us - self._since_us) * 1e-6)
        home_s = _home_s(s)
        if pct - rate_pct_per_s * home_s > s.config.battery_reserve_pct:
            return None
        return f"battery at {pct} %, and home is up to {home_s:.0f} s away"


def _home_s(s: Situation) -> float:
    """How long the way home may take: up above everything, straight there, down."""
    assert s.to_vehicle is not None
    here_enu_m: list[float] = s.to_vehicle.position_enu_m(s.vehicle.position_ned_m).tolist()
    east_m, north_m, up_m = here_enu_m
    home_east_m, home_north_m, home_up_m = s.begins_enu_m
    top_m = max(up_m, s.config.safe_height_enu_m, home_up_m)
    across_m = math.dist((east_m, north_m), (home_east_m, home_north_m))
    up_s, down_s = (top_m - up_m) / _UP_MPS, (top_m - home_up_m) / _DOWN_MPS
    return up_s + across_m / _ACROSS_MPS + down_s + _LANDING_S
