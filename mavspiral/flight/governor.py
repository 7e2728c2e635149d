"""How fast path time runs. A `Pace` is where it stands; `advance` moves it on by some of the vehicle's time.

Path time follows the vehicle's clock at rate 1 while the vehicle keeps up, slower as it falls behind, and not
at all before the error has eaten the clearance reserve. It never runs backwards and never faster than the
vehicle's clock: a flight that was held up finishes late.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

__all__ = ["GovernorLimits", "Pace", "advance", "wanted_rate"]

_SLOWEST_MPS = 0.5  # below this speed any change of rate is gentle


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


class Pace(NamedTuple):
    """Path time, its rate in path seconds per vehicle second, and how that rate changes."""

    path_t_s: float = 0.0
    rate: float = 1.0
    rate_change_per_s: float = 0.0


def wanted_rate(error_m: float, limits: GovernorLimits) -> float:
    """The rate to aim for with a position error of `error_m`: 1 when small, 0 from `stop_at` on."""
    slow_m, stop_m = limits.slow_at * limits.reserve_m, limits.stop_at * limits.reserve_m
    return min(1.0, max(0.0, (stop_m - error_m) / (stop_m - slow_m)))


def advance(pace: Pace, dt_s: float, wanted: float, speed_mps: float, limits: GovernorLimits) -> Pace:
    """`pace` after `dt_s` of the vehicle's time, drawn towards the rate `wanted`.

    Args:
        pace: where path time stands.
        dt_s: the vehicle's time that has passed; nothing changes unless it is positive.
        wanted: the rate to aim for, in [0, 1].
        speed_mps: the reference's speed here at rate 1, by which braking is turned into a change of rate.
        limits: how hard the rate may change.
    """
    if dt_s <= 0:
        return pace
    scale = dt_s / max(speed_mps, _SLOWEST_MPS)
    if wanted < pace.rate:
        rate = max(wanted, pace.rate - limits.brake_mps2 * scale)
    else:
        rate = min(wanted, pace.rate + limits.recover_mps2 * scale)
    return Pace(pace.path_t_s + dt_s * (pace.rate + rate) / 2, rate, (rate - pace.rate) / dt_s)
