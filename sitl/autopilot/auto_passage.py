"""A target on the legs of a mission in AUTO: how far along it is, how fast, and where the nose points.

Source: ArduPilot 4.6, AC_WPNav.cpp and mode_auto.cpp.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sitl.autopilot.auto_route import AnyLeg
from sitl.autopilot.curves import CircleLeg
from sitl.autopilot.glide import Glide, stopping_point
from sitl.autopilot.scurve import Leg, joins
from sitl.autopilot.shaping import shape_yaw
from sitl.autopilot.trip import Stop, acceleration_of, yaw_limits
from sitl.condition import Condition

__all__ = ["NEVER", "AutoPassage"]

NEVER = 0
"""Of WP_YAW_BEHAVIOR: the nose is not turned along the way."""
_SLACK_M = 5.0
"""A target that is so far ahead of its vehicle waits for it."""


@dataclass(frozen=True, slots=True)
class AutoPassage:
    """A target `leg_s` into a leg, and `after_s` into the one `after` it once their motions are added up.

    `pace` is how fast the legs' time goes by: `paused`, it comes to rest. `heading_rad` is CONDITION_YAW's.
    """

    glide: Glide
    leg: AnyLeg | None = None
    leg_s: float = 0.0
    after: Leg | None = None
    after_s: float = -1.0
    paused: bool = False
    pace: float = 1.0
    heading_rad: float = math.nan
    heading_rate_radps: float = math.nan

    @property
    def is_over(self) -> bool:
        """Whether the leg has been flown to its end."""
        return self.leg is not None and self.leg_s >= self.leg.duration_s

    @property
    def goes_on(self) -> bool:
        """Whether it does not come to rest at the end of the leg."""
        return self.after is not None or (self.leg is not None and self.leg.end_mps > 0.0)

    @property
    def joined(self) -> Leg | None:
        """The leg after this one, if it is flown already."""
        return self.after if self.after_s >= 0.0 else None

    @property
    def goal_ned_m(self) -> tuple[float, float, float] | None:
        """Where the leg ends."""
        if self.leg is None:
            return None
        end = self.leg.motion(self.leg.duration_s)
        return end.place_m.real, end.place_m.imag, end.down_m

    def end(self, parameters: Mapping[str, float]) -> Stop:
        """Where the leg ends; without one, where the target comes to rest."""
        if self.leg is not None:
            end = self.leg.motion(self.leg.duration_s)
            return Stop(end.place_m, end.down_m)
        return Stop(*stopping_point(self.glide, acceleration_of(parameters, "WPNAV_ACCEL")))

    def onto(self, leg: AnyLeg | None, leg_s: float = 0.0) -> AutoPassage:
        """On that leg, with none after it."""
        return replace(self, leg=leg, leg_s=leg_s, after=None, after_s=-1.0)

    def headed(self, heading_rad: float, rate_radps: float) -> AutoPassage:
        """With CONDITION_YAW's heading; a rate that is not positive leaves the nose its own."""
        return replace(self, heading_rad=heading_rad, heading_rate_radps=rate_radps)

    def step(
        self, condition: Condition, dt: float, parameters: Mapping[str, float], bearing_rad: float
    ) -> AutoPassage:
        """The target `dt` seconds later. `bearing_rad` is where the region of interest lies, if there is one."""
        glide = self.glide
        if self.leg is None or dt <= 0.0:
            return self
        north_m, east_m, _ = condition.estimate.position_ned_m.tolist()
        ahead_m = abs(glide.position_m - complex(north_m, east_m))
        moving = dt * max(0.0, 1.0 - max(0.0, ahead_m - 1.0) / _SLACK_M)
        speed_mps = abs(glide.velocity_mps) or abs(glide.down_speed_mps)
        braking = dt * acceleration_of(parameters, "WPNAV_ACCEL") / max(1.0, speed_mps)
        pace = max(0.0, self.pace - braking) if self.paused else min(1.0, self.pace + braking)
        moving *= pace
        leg_s, after_s = min(self.leg_s + moving, self.leg.duration_s), self.after_s
        radius_m, corner_mps2 = 0.01 * parameters["WPNAV_RADIUS"], 0.01 * parameters["WPNAV_ACCEL_C"]
        corner_mps2 = corner_mps2 or 2.0 * acceleration_of(parameters, "WPNAV_ACCEL")
        motion = self.leg.motion(leg_s)
        if self.after is not None:
            if after_s >= 0.0:
                after_s += moving
            elif isinstance(self.leg, Leg) and joins(self.leg, leg_s, self.after, radius_m, corner_mps2):
                after_s = moving
            second = self.after.motion(max(0.0, after_s))
            begin_m, begin_down_m = self.after.begin_m, self.after.begin_down_m
            motion = motion._replace(
                place_m=motion.place_m + second.place_m - begin_m,
                velocity_mps=motion.velocity_mps + second.velocity_mps,
                acceleration_mps2=motion.acceleration_mps2 + second.acceleration_mps2,
                down_m=motion.down_m + second.down_m - begin_down_m,
                down_speed_mps=motion.down_speed_mps + second.down_speed_mps,
                down_acceleration_mps2=motion.down_acceleration_mps2 + second.down_acceleration_mps2,
            )
        if pace < 1.0:
            motion = motion._replace(
                velocity_mps=motion.velocity_mps * pace,
                acceleration_mps2=motion.acceleration_mps2 * pace**2,
                down_speed_mps=motion.down_speed_mps * pace,
                down_acceleration_mps2=motion.down_acceleration_mps2 * pace**2,
            )
        yaw, rate = self._turning(motion.velocity_mps, parameters, bearing_rad, dt)
        return replace(self, pace=pace, leg_s=leg_s, after_s=after_s, glide=Glide(*motion, yaw, rate))

    def _turning(
        self, velocity_mps: complex, parameters: Mapping[str, float], bearing_rad: float, dt: float
    ) -> tuple[float, float]:
        """Heading and yaw rate: to the region of interest, else CONDITION_YAW's, else WP_YAW_BEHAVIOR's."""
        yaw, rate = self.glide.yaw_ned_rad, self.glide.yaw_rate_ned_radps
        constant_s, acceleration, most = yaw_limits(parameters)
        wanted = yaw
        if math.isfinite(bearing_rad):
            wanted = bearing_rad
        elif isinstance(self.leg, CircleLeg):
            wanted = cmath.phase(self.leg.centre_m - self.glide.position_m)
        elif math.isfinite(self.heading_rad):
            wanted = self.heading_rad
            most = self.heading_rate_radps if self.heading_rate_radps > 0.0 else most
        elif int(parameters["WP_YAW_BEHAVIOR"]) != NEVER:
            creeping = abs(velocity_mps) <= 0.05 * 0.01 * parameters["WPNAV_SPEED"]
            wanted = yaw if creeping else math.atan2(velocity_mps.imag, velocity_mps.real)
        limits = constant_s, acceleration, most
        rate = shape_yaw(math.remainder(wanted - yaw, math.tau), 0.0, rate, limits, dt)
        return math.remainder(yaw + rate * dt, math.tau), rate
