"""How fast path time runs. A `Pace` is where it stands; `steering` moves it on by some of the vehicle's time.

Path time follows the vehicle's clock at rate 1 while the vehicle keeps up, slower as it falls behind, and not
at all before the error has eaten the clearance reserve. It never runs backwards and never faster than the
vehicle's clock: a flight that was held up finishes late.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

__all__ = ["GovernorLimits", "Pace"]


@dataclass(frozen=True, slots=True)
class GovernorLimits:
    """When to slow down and how hard.

    Args:
        reserve_m: the position error that the plan's clearance has room for.
        slow_at: share of the reserve up to which the pace is full.
        stop_at: share of the reserve from which path time stands still.
        brake_mps2: how hard the reference may brake along its path.
        recover_mps2: how hard it may speed up again.
    """

    reserve_m: float = 1.5
    slow_at: float = 0.4
    stop_at: float = 0.8
    brake_mps2: float = 3.0
    recover_mps2: float = 1.0

    @property
    def slow_m(self) -> float:
        """The position error up to which the pace is full."""
        return self.slow_at * self.reserve_m

    @property
    def stop_m(self) -> float:
        """The position error from which path time stands still."""
        return self.stop_at * self.reserve_m


class Pace(NamedTuple):
    """Path time, its rate in path seconds per vehicle second, and how that rate changes."""

    path_t_s: float = 0.0
    rate: float = 1.0
    rate_change_per_s: float = 0.0
