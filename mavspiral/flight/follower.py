"""A reference that is being flown: path time, led by the governor, on the vehicle's clock."""

from __future__ import annotations

import math

from mavspiral.flight.feedforward import DRAG_TYPICAL_PER_S, damped_gain, learned_drag
from mavspiral.flight.governor import GovernorLimits, Pace
from mavspiral.flight.messages import Setpoint, Triple
from mavspiral.flight.reference import Reference
from mavspiral.flight.steering import PACE_N, SETPOINT_N, setpoint_at, steered

__all__ = ["Follower"]


class Follower:
    """Where on `reference` the vehicle is asked to be.

    Args:
        reference: the motion.
        limits: of the governor.
        lead_s: how far ahead of path time the setpoint is taken, for what the vehicle takes to act on it.
        tilt_lead_s: the same for its acceleration, which the vehicle must tilt for.
        turn_lead_s: the same for its yaw rate; None for `lead_s`.
        damping: what share of its measured acceleration the vehicle takes off again (`feedforward`).
        feels_drag: the setpoint's acceleration makes up for the air's drag, learned on the way.
        vehicle_us: the vehicle's time now.
        pace: the path time and its rate to begin with.

    Attributes:
        due: where the vehicle is meant to be by now, as a setpoint: the reference without the lead.
        error_m: how far it was from there when it was last heard, `below_m` of it down, on a path that climbs with `climb_mps`.
    """

    def __init__(
        self,
        reference: Reference,
        limits: GovernorLimits,
        vehicle_us: float,
        *,
        lead_s: float = 0.0,
        tilt_lead_s: float = 0.0,
        turn_lead_s: float | None = None,
        damping: float = 0.0,
        feels_drag: bool = True,
        pace: Pace | None = None,
    ) -> None:
        self.reference = reference
        self.pace = pace or Pace()
        self._duration_s = reference.duration_s
        self.error_m = 0.0
        self.below_m = self.climb_mps = 0.0
        self._governor = limits.slow_m, limits.stop_m
        self._changes_mps2 = limits.brake_mps2, limits.recover_mps2
        self._ways = (
            lead_s,
            tilt_lead_s,
            lead_s if turn_lead_s is None else turn_lead_s,
            damped_gain(damping),
        )
        self._vehicle_us = vehicle_us
        self._speed_mps = 0.0
        self._heard_us = vehicle_us
        self._feels_drag = feels_drag
        self.drag_per_s = DRAG_TYPICAL_PER_S if feels_drag else 0.0
        self.due: Setpoint = setpoint_at(reference.coefficients, reference.knot_s, *self.pace)

    @property
    def finished(self) -> bool:
        """Whether path time has reached the end."""
        return self.pace.path_t_s >= self._duration_s

    @property
    def yaw_ned_rad(self) -> float:
        """Where the reference looks now."""
        return self.due[9]

    def heard(self, vehicle_us: float, position_ned_m: Triple) -> None:
        """Take in where the vehicle was at `vehicle_us`, and how far that was from the reference then."""
        ago_s = (self._vehicle_us - vehicle_us) * 1e-6
        pace = self.pace
        there = self.reference.on_time(pace.path_t_s - pace.rate * ago_s)
        n, e, d, v_n, v_e, v_d = there[:6]
        self.error_m = math.dist((n, e, d), position_ned_m)
        self.below_m, self.climb_mps = position_ned_m[2] - d, -v_d
        self._speed_mps = math.hypot(v_n, v_e, v_d)
        dt_s, self._heard_us = (vehicle_us - self._heard_us) * 1e-6, vehicle_us
        if self._feels_drag and pace.rate == 1.0 and self._speed_mps > 0.0:
            is_n, is_e, is_d = position_ned_m
            lag_m = ((n - is_n) * v_n + (e - is_e) * v_e + (d - is_d) * v_d) / self._speed_mps
            self.drag_per_s = learned_drag(self.drag_per_s, lag_m, self._speed_mps, dt_s)

    def advance(self, vehicle_us: float, *, longest_s: float, hold: bool) -> Setpoint:
        """Move path time on to `vehicle_us` and return the setpoint there.

        Args:
            vehicle_us: the vehicle's time now; where its clock has jumped, path time does not.
            longest_s: a stall of ours or of the link moves path time by no more than this.
            hold: brake and stand still.
        """
        dt_s = min((vehicle_us - self._vehicle_us) * 1e-6, longest_s)
        if dt_s > 0 or dt_s < -1.0:
            self._vehicle_us = vehicle_us
        numbers = steered(
            self.reference.coefficients,
            self.reference.knot_s,
            *self.pace,
            dt_s,
            math.inf if hold else self.error_m,
            *self._governor,
            self._speed_mps,
            *self._changes_mps2,
            *self._ways,
            self.drag_per_s,
        )
        self.pace = tuple.__new__(Pace, numbers[:PACE_N])
        self.due = numbers[PACE_N : PACE_N + SETPOINT_N]
        setpoint: Setpoint = numbers[PACE_N + SETPOINT_N :]
        return setpoint
