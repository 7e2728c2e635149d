"""A reference that is being flown: path time, led by the governor, on the vehicle's clock."""

from __future__ import annotations

import math
from operator import sub

from mavspiral.flight.feedforward import DRAG_TYPICAL_PER_S, compensated, learned_drag
from mavspiral.flight.governor import GovernorLimits, Pace, advance, wanted_rate
from mavspiral.flight.messages import Target, Triple
from mavspiral.flight.reference import Reference

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
        due: where the vehicle is meant to be by now: the reference without the lead.
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
        self.error_m = 0.0
        self.below_m = self.climb_mps = 0.0
        self._limits = limits
        self._leads_s = lead_s, tilt_lead_s, turn_lead_s
        self._damping = damping
        self._vehicle_us = vehicle_us
        self._speed_mps = 0.0
        self._heard_us = vehicle_us
        self._feels_drag = feels_drag
        self.drag_per_s = DRAG_TYPICAL_PER_S if feels_drag else 0.0
        self.due = reference.at(*self.pace)

    @property
    def finished(self) -> bool:
        """Whether path time has reached the end."""
        return self.pace.path_t_s >= self.reference.duration_s

    def heard(self, vehicle_us: float, position_ned_m: Triple) -> None:
        """Take in where the vehicle was at `vehicle_us`, and how far that was from the reference then."""
        ago_s = (self._vehicle_us - vehicle_us) * 1e-6
        pace = self.pace
        meant, velocity, *_ = self.reference.at(pace.path_t_s - pace.rate * ago_s)
        self.error_m = math.dist(meant, position_ned_m)
        self.below_m, self.climb_mps = position_ned_m[2] - meant[2], -velocity[2]
        self._speed_mps = math.hypot(*velocity)
        dt_s, self._heard_us = (vehicle_us - self._heard_us) * 1e-6, vehicle_us
        if self._feels_drag and pace.rate == 1.0 and self._speed_mps > 0.0:
            off_n, off_e, off_d = map(sub, meant, position_ned_m)
            v_n, v_e, v_d = velocity
            lag_m = (off_n * v_n + off_e * v_e + off_d * v_d) / self._speed_mps
            self.drag_per_s = learned_drag(self.drag_per_s, lag_m, self._speed_mps, dt_s)

    def advance(self, vehicle_us: float, *, longest_s: float, hold: bool) -> Target:
        """Move path time on to `vehicle_us` and return the setpoint there.

        Args:
            vehicle_us: the vehicle's time now; where its clock has jumped, path time does not.
            longest_s: a stall of ours or of the link moves path time by no more than this.
            hold: brake and stand still.
        """
        dt_s = min((vehicle_us - self._vehicle_us) * 1e-6, longest_s)
        if dt_s > 0 or dt_s < -1.0:
            self._vehicle_us = vehicle_us
        wanted = 0.0 if hold else wanted_rate(self.error_m, self._limits)
        self.pace = advance(self.pace, dt_s, wanted, self._speed_mps, self._limits)
        self.due, target = self.reference.led(self.pace, *self._leads_s)
        return compensated(target, self._damping, self.drag_per_s)
