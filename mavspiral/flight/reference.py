"""The motion to follow, as the vehicle is to be told it: a table of quintics in its own NED frame.

Between knots each of north, east, down and yaw is the quintic that has the value, the rate and the
acceleration of both knots (quintic Hermite), so the reference is C² and equals the trajectory at every knot.
One quintic from rest to rest is also the minimum-jerk move (Flash and Hogan 1985): `Reference.move`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray, locked
from mavspiral.flight.messages import Setpoint, Target, Triple
from mavspiral.flight.steering import setpoint_at
from mavspiral.frames import RigidMap, wrap_rad, yaw_enu_to_ned
from mavspiral.motion.trajectory import Trajectory

__all__ = ["Extremes", "Reference", "braking_s"]

KNOTS_S = 0.02
BRAKE_MPS2 = 3.0
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
    """The most that a reference asks of the vehicle; the acceleration is the horizontal one."""

    horizontal_mps: float
    climb_mps: float
    descent_mps: float
    acceleration_mps2: float


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A motion over [0, duration_s]; beyond either end it rests there.

    Args:
        knot_s: time between knots.
        values: north, east, down in metres and yaw_ned in radians (unwrapped) at the knots, `(n, 4)`.
        rates: their first derivatives.
        accelerations: their second derivatives.
        coefficients: of the powers of each quintic on [0, 1], `(n - 1, 4, 6)`; made of the others.
    """

    knot_s: float
    values: FloatArray
    rates: FloatArray
    accelerations: FloatArray
    coefficients: FloatArray

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
        # Contiguous, long or short: numba compiles for each layout.
        powers = np.ascontiguousarray(np.einsum("cd,dna->nac", _HERMITE, both))
        assign(self, "coefficients", locked(powers, shape=(len(values) - 1, 4, 6), name="coefficients"))

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

    def begun_in_flight(self, velocity_ned_mps: Triple) -> Reference:
        """This motion, begun at that velocity from where who brakes (`braking_s`) comes to rest at its beginning.

        Braking and the motion go on at once. Speed is taken off as in a smooth step.
        """
        t_s = self.knot_s * np.arange(len(self.values))
        span_s = min(braking_s(velocity_ned_mps), self.duration_s)
        if span_s <= 0.0:
            return self
        x = np.clip(t_s / span_s, 0.0, 1.0)
        still_m = span_s * (0.5 - x + x**3 - 0.5 * x**4)  # times the velocity: what is left to go
        left, rate_per_s = 1.0 - 3.0 * x**2 + 2.0 * x**3, 6.0 * (x**2 - x) / span_s
        velocity = np.array([*velocity_ned_mps, 0.0])
        return Reference(
            self.knot_s,
            self.values - still_m[:, None] * velocity,
            self.rates + left[:, None] * velocity,
            self.accelerations + rate_per_s[:, None] * velocity,
        )

    def shifted(self, north_m: float, east_m: float, down_m: float) -> Reference:
        """The same motion elsewhere."""
        there = self.values + np.array([north_m, east_m, down_m, 0.0])
        return Reference(self.knot_s, there, self.rates, self.accelerations)

    @property
    def duration_s(self) -> float:
        """Time from the first knot to the last."""
        return self.knot_s * len(self.coefficients)

    def at(self, t_s: float, rate: float = 1.0, rate_change_per_s: float = 0.0) -> Target:
        """The setpoint at path time `t_s`, when path time runs at `rate`, which itself changes."""
        return Target.of(setpoint_at(self.coefficients, self.knot_s, t_s, rate, rate_change_per_s))

    def on_time(self, t_s: float) -> Setpoint:
        """The setpoint at path time `t_s`, when path time runs at rate 1."""
        setpoint: Setpoint = setpoint_at(self.coefficients, self.knot_s, t_s, 1.0, 0.0)
        return setpoint

    def extremes(self) -> Extremes:
        """The largest speeds and the largest horizontal acceleration at the knots."""
        north, east, down, _ = self.rates.T
        north_mps2, east_mps2, _, _ = self.accelerations.T
        return Extremes(
            float(np.hypot(north, east).max()),
            float(max(0.0, -down.min())),
            float(max(0.0, down.max())),
            float(np.hypot(north_mps2, east_mps2).max()),
        )


def braking_s(velocity_ned_mps: Triple) -> float:
    """How long a smooth step from that velocity to rest takes; it goes on for half of it at that velocity, as it were."""
    return 1.5 * math.hypot(*velocity_ned_mps) / BRAKE_MPS2
