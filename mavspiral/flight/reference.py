"""The motion to follow, as the vehicle is to be told it: a table of quintics in its own NED frame.

Between knots each of north, east, down and yaw is the quintic that has the value, the rate and the
acceleration of both knots (quintic Hermite), so the reference is C² and equals the trajectory at every knot.
One quintic from rest to rest is also the minimum-jerk move (Flash and Hogan 1985): `Reference.move`.

A path time that runs at `rate` r stretches the motion: velocity r·v, acceleration r²·a + ṙ·v.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray, locked
from mavspiral.flight.messages import Target, Triple
from mavspiral.frames import RigidMap, wrap_rad, yaw_enu_to_ned
from mavspiral.motion.trajectory import Trajectory

__all__ = ["Extremes", "Reference"]

KNOTS_S = 0.02
_TAU = 2 * math.pi
# Power coefficients of the quintic on [0, 1] whose ends are p0, v0, a0, p1, v1, a1.
_HERMITE = np.array(
    [
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [0, 0, 0.5, 0, 0, 0],
        [-10, -6, -1.5, 10, -4, 0.5],
        [15, 8, 1.5, -15, 7, -1],
        [-6, -3, -0.5, 6, -3, 0.5],
    ]
)


@dataclass(frozen=True, slots=True)
class Extremes:
    """The fastest that a reference asks of the vehicle."""

    horizontal_mps: float
    climb_mps: float
    descent_mps: float


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A motion over [0, duration_s]; beyond either end it rests there.

    Args:
        knot_s: time between knots.
        values: north, east, down in metres and yaw_ned in radians (unwrapped) at the knots, `(n, 4)`.
        rates: their first derivatives.
        accelerations: their second derivatives.
    """

    knot_s: float
    values: FloatArray
    rates: FloatArray
    accelerations: FloatArray
    _coefficients: FloatArray

    def __init__(
        self, knot_s: float, values: FloatArray, rates: FloatArray, accelerations: FloatArray
    ) -> None:
        assign = object.__setattr__
        assign(self, "knot_s", knot_s)
        assign(self, "values", locked(values, shape=(None, 4), name="values"))
        assign(self, "rates", locked(rates, shape=(len(values), 4), name="rates"))
        assign(self, "accelerations", locked(accelerations, shape=(len(values), 4), name="accelerations"))
        ends = np.stack([self.values, self.rates * knot_s, self.accelerations * knot_s**2])  # (3, n, 4)
        both = np.concatenate([ends[:, :-1], ends[:, 1:]])  # (6, n-1, 4)
        powers = np.einsum("cd,dna->nac", _HERMITE, both)
        assign(self, "_coefficients", locked(powers, shape=(len(values) - 1, 4, 6), name="coefficients"))

    @classmethod
    def of(cls, trajectory: Trajectory, to_vehicle: RigidMap) -> Reference:
        """The whole `trajectory` in the frame of the vehicle."""
        knots_n = max(1, math.ceil(trajectory.duration_s / KNOTS_S))
        knot_s = trajectory.duration_s / knots_n
        state = trajectory.sampled(knot_s)
        rotation = to_vehicle.R_ned_enu.T
        position_ned_m = to_vehicle.position_ned_m(state.position_enu_m)
        return cls(
            knot_s,
            np.column_stack([position_ned_m, yaw_enu_to_ned(state.yaw_enu_rad)]),
            np.column_stack([state.velocity_enu_mps @ rotation, -state.yaw_rate_enu_radps]),
            np.column_stack([state.acceleration_enu_mps2 @ rotation, -state.yaw_acceleration_enu_radps2]),
        )

    @classmethod
    def move(cls, start: Target, end: Target, *, speed_mps: float, yaw_rate_radps: float) -> Reference:
        """The minimum-jerk move from rest at `start` to rest at `end`, the short way round in yaw."""
        turn_rad = float(wrap_rad(end.yaw_ned_rad - start.yaw_ned_rad))
        distance_m = math.dist(start.position_ned_m, end.position_ned_m)
        peak = 15 / 8  # of a minimum-jerk move's speed, in units of its mean speed
        duration_s = max(1.0, peak * distance_m / speed_mps, peak * abs(turn_rad) / yaw_rate_radps)
        first = (*start.position_ned_m, start.yaw_ned_rad)
        last = (*end.position_ned_m, start.yaw_ned_rad + turn_rad)
        return cls(duration_s, np.array([first, last]), np.zeros((2, 4)), np.zeros((2, 4)))

    @property
    def duration_s(self) -> float:
        """Time from the first knot to the last."""
        return self.knot_s * len(self._coefficients)

    def at(self, t_s: float, rate: float = 1.0, rate_change_per_s: float = 0.0) -> Target:
        """The setpoint at path time `t_s`, when path time runs at `rate`, which itself changes."""
        last = len(self._coefficients) - 1
        x = min(max(t_s / self.knot_s, 0.0), last + 1.0)
        row = min(int(x), last)
        s = x - row
        c = self._coefficients[row].tolist()
        north, east, down, yaw = (
            _quintic(s, *c[0]),
            _quintic(s, *c[1]),
            _quintic(s, *c[2]),
            _quintic(s, *c[3]),
        )
        r1 = rate / self.knot_s
        r2 = r1 * r1
        rr = rate_change_per_s / self.knot_s
        return Target(
            (north[0], east[0], down[0]),
            (r1 * north[1], r1 * east[1], r1 * down[1]),
            (r2 * north[2] + rr * north[1], r2 * east[2] + rr * east[1], r2 * down[2] + rr * down[1]),
            (yaw[0] + math.pi) % _TAU - math.pi,
            r1 * yaw[1],
        )

    def extremes(self) -> Extremes:
        """The largest speeds at the knots."""
        north, east, down, _ = self.rates.T
        return Extremes(
            float(np.hypot(north, east).max()), float(max(0.0, -down.min())), float(max(0.0, down.max()))
        )


def _quintic(s: float, c0: float, c1: float, c2: float, c3: float, c4: float, c5: float) -> Triple:
    """Value and two derivatives in s of the quintic with these power coefficients."""
    return (
        ((((c5 * s + c4) * s + c3) * s + c2) * s + c1) * s + c0,
        (((5 * c5 * s + 4 * c4) * s + 3 * c3) * s + 2 * c2) * s + c1,
        ((20 * c5 * s + 12 * c4) * s + 6 * c3) * s + 2 * c2,
    )
