"""A circle round a place: to its nearest point in a straight line, then along it.

Source: PX4 v1.17, FlightTaskOrbit: on the circle a velocity along it, pulled back to it in proportion to the distance
from it, with the centripetal acceleration as feedforward; position is not commanded. Its limits are PX4's own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sitl.autopilot.glide import Glide, GlideLimits, step_glide
from sitl.condition import Condition
from sitl.geo import geodetic_of_ned, ned_of_geodetic
from sitl.orders import Mode, Orbit
from sitl.signals import GeoPoint, Setpoint
from sitl.status import OrbitRun

__all__ = ["OrbitCourse", "begin_orbit"]

_RADIUS_M = (1.0, 100.0)
_SPEED_MAX_MPS = 10.0
_ACCELERATION_MAX_MPS2 = 2.0
_PULL_PER_S = 1.0
_ON_CIRCLE_M = 2.0
_YAW_CENTRE, _YAW_UNCONTROLLED, _YAW_TANGENT = 0, 2, 3


@dataclass(frozen=True, slots=True)
class OrbitCourse:
    """An orbit under way; `speed_mps` is positive clockwise. `approaching` ends on the circle."""

    centre_m: complex
    down_m: float
    radius_m: float
    speed_mps: float
    yaw_behaviour: int
    initial_yaw_rad: float
    glide: Glide
    setpoint: Setpoint
    approaching: bool = True

    def follows(self, _condition: Condition, _parameters: Mapping[str, float]) -> Mode | None:
        """Nothing: it goes round until it is told otherwise."""
        return None

    def step(self, condition: Condition, dt_s: float, parameters: Mapping[str, float]) -> OrbitCourse:
        """The orbit `dt_s` later."""
        north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
        arm_m = complex(north_m, east_m) - self.centre_m
        outward = arm_m / abs(arm_m) if abs(arm_m) > 1e-3 else 1.0 + 0.0j
        off_m = self.radius_m - abs(arm_m)
        approaching = self.approaching and (
            abs(off_m) > _ON_CIRCLE_M or abs(down_m - self.down_m) > parameters["NAV_MC_ALT_RAD"]
        )
        towards = outward if off_m > 0.0 else -outward
        yaw_rad = _angle(towards) if approaching else self._yaw_rad(outward)
        goal_m = self.centre_m + self.radius_m * outward
        limits = _limits(parameters)
        glide = step_glide(self.glide, goal_m, self.down_m, yaw_rad, limits, dt_s)
        if approaching:
            return replace(self, glide=glide, setpoint=glide.setpoint())
        # The setpoint goes with the vehicle, so that a later approach begins where it is.
        glide = glide._replace(position_m=complex(north_m, east_m), velocity_mps=0j, acceleration_mps2=0j)
        return replace(self, glide=glide, setpoint=self._round(outward, off_m, glide), approaching=False)

    def _round(self, outward: complex, off_m: float, glide: Glide) -> Setpoint:
        """Along the circle from there."""
        velocity_mps = 1j * outward * self.speed_mps + _PULL_PER_S * off_m * outward
        acceleration_mps2 = -outward * self.speed_mps**2 / self.radius_m
        turns = self.yaw_behaviour in (_YAW_CENTRE, _YAW_TANGENT)
        return Setpoint(
            (math.nan, math.nan, glide.down_m),
            (velocity_mps.real, velocity_mps.imag, glide.down_speed_mps),
            (acceleration_mps2.real, acceleration_mps2.imag, glide.down_acceleration_mps2),
            math.nan if self.yaw_behaviour == _YAW_UNCONTROLLED else glide.yaw_ned_rad,
            self.speed_mps / self.radius_m if turns else math.nan,
        )

    def _yaw_rad(self, outward: complex) -> float:
        match self.yaw_behaviour:
            case 1 | 2:
                return self.initial_yaw_rad
            case 3:
                return _angle(1j * outward * math.copysign(1.0, self.speed_mps))
            case _:
                return _angle(-outward)

    def run(self, origin: GeoPoint) -> OrbitRun:
        """What there is to tell of it."""
        anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
        centre = GeoPoint(*geodetic_of_ned(anchor, (self.centre_m.real, self.centre_m.imag, self.down_m)))
        return OrbitRun(centre, math.copysign(self.radius_m, self.speed_mps), self.yaw_behaviour)


def begin_orbit(
    order: Orbit, before: OrbitCourse | None, origin: GeoPoint, here: Glide, stop_down_m: float
) -> OrbitCourse:
    """The orbit as it is ordered; what is left out stays as it was `before`, or is PX4's default.

    Too wide or too fast a circle is flown as PX4 clips it.
    """
    radius_m = _RADIUS_M[0] if before is None else math.copysign(before.radius_m, before.speed_mps)
    speed_mps = 1.0 if before is None else abs(before.speed_mps)
    centre_m = here.position_m if before is None else before.centre_m
    down_m = stop_down_m if before is None else before.down_m
    behaviour = _YAW_CENTRE if before is None else before.yaw_behaviour
    radius_m = order.radius_m if math.isfinite(order.radius_m) else radius_m
    speed_mps = order.speed_mps if math.isfinite(order.speed_mps) else speed_mps
    if math.isfinite(order.yaw_behaviour):
        behaviour = int(order.yaw_behaviour)
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    north_m, east_m, _ = ned_of_geodetic(anchor, (order.lat_deg, order.lon_deg, origin.alt_amsl_m))
    centre_m = complex(north_m, east_m) if math.isfinite(north_m + east_m) else centre_m
    down_m = origin.alt_amsl_m - order.alt_amsl_m if math.isfinite(order.alt_amsl_m) else down_m
    clockwise = math.copysign(1.0, radius_m)
    radius_m = min(max(abs(radius_m), _RADIUS_M[0]), _RADIUS_M[1])
    fastest_mps = min(_SPEED_MAX_MPS, math.sqrt(_ACCELERATION_MAX_MPS2 * radius_m))
    speed_mps = min(max(speed_mps, -fastest_mps), fastest_mps)
    return OrbitCourse(
        centre_m=centre_m,
        down_m=down_m,
        radius_m=radius_m,
        speed_mps=clockwise * speed_mps,
        yaw_behaviour=behaviour,
        initial_yaw_rad=here.yaw_ned_rad,
        glide=here,
        setpoint=here.setpoint(),
    )


def _angle(way: complex) -> float:
    return math.atan2(way.imag, way.real)


def _limits(parameters: Mapping[str, float]) -> GlideLimits:
    return GlideLimits(
        speed_mps=parameters["MPC_XY_CRUISE"],
        up_mps=parameters["MPC_Z_V_AUTO_UP"],
        down_mps=parameters["MPC_Z_V_AUTO_DN"],
        acceleration_mps2=parameters["MPC_ACC_HOR"],
        jerk_mps3=parameters["MPC_JERK_AUTO"],
        yaw_rate_radps=math.radians(parameters["MPC_YAWRAUTO_MAX"]),
    )
