"""ArduCopter's CIRCLE: around a place that lies CIRCLE_RADIUS before the nose where it came to rest, looking inwards.

Source: ArduPilot 4.6, mode_circle.cpp and AC_Circle.cpp. Simpler than ArduPilot: it comes to rest before it sets off, and of
CIRCLE_OPTIONS only those for the nose and for the centre count; sticks change nothing.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from typing import NamedTuple

from sitl.autopilot.glide import Glide, start_glide
from sitl.autopilot.trip import Speeds, Trip, acceleration_of, hold_here, speeds_of
from sitl.condition import Condition
from sitl.signals import Setpoint

__all__ = ["Circle", "begin_circle"]

_ALONG, _FROM_THE_CENTRE = 2, 4
"""CIRCLE_OPTIONS."""
_SLOWEST_TURN_UP_RADPS2 = math.radians(2.0)
_AT_REST_MPS = 0.05
_TURN_RADPS = math.radians(60.0)
"""How fast the nose comes round before it follows the circle."""


class Circle(NamedTuple):
    """A target on its way round; it only comes to rest on a `trip` at first. Angles are compass directions seen from the centre."""

    trip: Trip | None
    glide: Glide
    centre_m: complex = 0j
    radius_m: float = 0.0
    angle_rad: float = 0.0
    rate_radps: float = 0.0

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now."""
        return self.glide.setpoint()

    @property
    def goal_ned_m(self) -> None:
        """It flies to no place."""

    def step(
        self, condition: Condition, dt_s: float, parameters: Mapping[str, float], speeds: Speeds
    ) -> Circle:
        """The target `dt_s` later."""
        if self.trip is not None:
            trip = self.trip.step(condition, dt_s, parameters, speeds)
            stands = abs(trip.glide.velocity_mps) < _AT_REST_MPS
            resting = self._replace(trip=trip, glide=trip.glide)
            return resting._about(parameters) if stands else resting
        radius_m, most = self.radius_m, speeds_of(speeds, parameters)
        push_mps2 = acceleration_of(parameters, "WPNAV_ACCEL")
        wanted_radps = math.radians(parameters["CIRCLE_RATE"])
        turn_up_radps2 = max(abs(wanted_radps), _SLOWEST_TURN_UP_RADPS2)
        if radius_m > 0.0:
            fastest_radps = min(most.speed_mps, math.sqrt(0.5 * push_mps2 * radius_m)) / radius_m
            wanted_radps = min(max(wanted_radps, -fastest_radps), fastest_radps)
            turn_up_radps2 = max(push_mps2 / radius_m, _SLOWEST_TURN_UP_RADPS2)
        missing_radps = wanted_radps - self.rate_radps
        change_radps = math.copysign(min(abs(missing_radps), turn_up_radps2 * dt_s), missing_radps)
        rate_radps = self.rate_radps + change_radps
        angle_rad = math.remainder(self.angle_rad + rate_radps * dt_s, math.tau)
        out_m = cmath.rect(radius_m, angle_rad)
        along = int(parameters["CIRCLE_OPTIONS"]) & _ALONG
        nose_rad = angle_rad + (math.copysign(math.pi / 2.0, rate_radps) if along else math.pi)
        yaw_rad, turn_radps = _turned(self.glide.yaw_ned_rad, nose_rad, rate_radps, dt_s)
        return self._replace(
            angle_rad=angle_rad,
            rate_radps=rate_radps,
            glide=self.glide._replace(
                position_m=self.centre_m + out_m,
                velocity_mps=1j * rate_radps * out_m,
                acceleration_mps2=(1j * change_radps / dt_s - rate_radps**2) * out_m,
                yaw_ned_rad=yaw_rad,
                yaw_rate_ned_radps=turn_radps,
            ),
        )

    def _about(self, parameters: Mapping[str, float]) -> Circle:
        """The circle that begins where it stands."""
        glide, radius_m = self.glide, max(0.0, 0.01 * parameters["CIRCLE_RADIUS"])
        ahead = cmath.rect(radius_m, glide.yaw_ned_rad)
        from_centre = int(parameters["CIRCLE_OPTIONS"]) & _FROM_THE_CENTRE
        centre_m = glide.position_m if from_centre else glide.position_m + ahead
        still = glide._replace(velocity_mps=0j, acceleration_mps2=0j)
        return Circle(None, still, centre_m, radius_m, glide.yaw_ned_rad - math.pi)


def begin_circle(condition: Condition, parameters: Mapping[str, float]) -> Circle:
    """CIRCLE as it begins: it comes to rest."""
    trip = hold_here(start_glide(condition.estimate), parameters)
    return Circle(trip, trip.glide)


def _turned(yaw_rad: float, nose_rad: float, rate_radps: float, dt_s: float) -> tuple[float, float]:
    """The heading a frame nearer to that of the circle, and how fast it turns."""
    missing_rad = math.remainder(nose_rad - yaw_rad, math.tau)
    most_rad = _TURN_RADPS * dt_s
    if abs(missing_rad) <= most_rad:
        return math.remainder(nose_rad, math.tau), rate_radps
    turn_rad = math.copysign(most_rad, missing_rad)
    return math.remainder(yaw_rad + turn_rad, math.tau), turn_rad / dt_s
