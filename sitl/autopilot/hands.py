"""ArduCopter by a pilot's sticks: LOITER and POSHOLD lead a place, ALT_HOLD and STABILIZE lean.

Source: ArduPilot 4.6, mode_loiter.cpp, mode_althold.cpp, Copter::get_pilot_desired_climb_rate. Simpler than ArduPilot: LOITER's
speed follows the stick by the law of `glide`; POSHOLD is LOITER; STABILIZE's throttle asks for a rate of climb, as ALT_HOLD's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from sitl.autopilot.glide import Glide, climbing, led_across, start_glide
from sitl.autopilot.lean import leaning
from sitl.autopilot.trip import acceleration_of
from sitl.condition import Condition
from sitl.geo import GRAVITY_MPS2
from sitl.rotation import euler_rad
from sitl.signals import Setpoint, Sticks

__all__ = ["Led", "led"]

_AHEAD_MOST_RAD = math.radians(20.0)
"""So far the heading that is asked for runs ahead of the nose: who cannot turn so fast is not turned the other way round."""
_STEEPEST_RAD = math.radians(80.0)


class Led(NamedTuple):
    """A target that sticks lead; one that `leans` has a height and a heading only."""

    glide: Glide
    leans: bool
    sticks: Sticks
    push_mps2: complex = 0j

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now."""
        return leaning(self.glide, self.push_mps2) if self.leans else self.glide.setpoint()

    @property
    def goal_ned_m(self) -> None:
        """It flies to no place."""

    def step(self, condition: Condition, dt_s: float, parameters: Mapping[str, float], _: object) -> Led:
        """The target `dt_s` later."""
        sticks, estimate = self.sticks, condition.estimate
        nose_rad = euler_rad(estimate.q_ned_frd)[2]
        tilt = complex(sticks.forward, sticks.right)
        tilt *= complex(math.cos(nose_rad), math.sin(nose_rad)) / max(1.0, abs(tilt))
        down_mps = parameters["PILOT_SPEED_DN"] or parameters["PILOT_SPEED_UP"]
        climb_mps = 0.01 * sticks.up * (parameters["PILOT_SPEED_UP"] if sticks.up > 0.0 else down_mps)
        push = acceleration_of(parameters, "PILOT_ACCEL_Z")
        glide = climbing(self.glide, climb_mps, push, parameters["PSC_JERK_Z"], dt_s)
        rate_radps = sticks.clockwise * math.radians(parameters["PILOT_Y_RATE"])
        ahead_rad = math.remainder(glide.yaw_ned_rad + rate_radps * dt_s - nose_rad, math.tau)
        ahead_rad = min(max(ahead_rad, -_AHEAD_MOST_RAD), _AHEAD_MOST_RAD)
        glide = glide._replace(yaw_ned_rad=nose_rad + ahead_rad, yaw_rate_ned_radps=rate_radps)
        if self.leans:
            lean_rad = min(math.radians(0.01 * parameters["ANGLE_MAX"]) * abs(tilt), _STEEPEST_RAD)
            across = tilt / abs(tilt) if tilt else 0j
            return self._replace(glide=glide, push_mps2=GRAVITY_MPS2 * math.tan(lean_rad) * across)
        wanted_mps = 0.01 * parameters["LOIT_SPEED"] * tilt
        north_m, east_m, _down_m = estimate.position_ned_m.tolist()
        most_mps2, jerk_mps3 = (
            acceleration_of(parameters, name) for name in ("LOIT_ACC_MAX", "LOIT_BRK_JERK")
        )
        moved = led_across(glide, complex(north_m, east_m), wanted_mps, most_mps2, jerk_mps3, dt_s)
        return self._replace(glide=moved)


def led(before: object, sticks: Sticks, condition: Condition, *, leans: bool) -> Led:
    """The target under these sticks, which go on with what they led before."""
    if isinstance(before, Led) and before.leans is leans:
        return before._replace(sticks=sticks)
    return Led(start_glide(condition.estimate), leans, sticks)
