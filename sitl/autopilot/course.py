"""A mode under way: its route, how far along it the setpoint is, and how fast it may go."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from sitl.autopilot.glide import Glide, GlideLimits, step_glide
from sitl.autopilot.modes import MODES, Briefing, Route, Waypoint
from sitl.condition import Condition
from sitl.orders import Mode
from sitl.signals import Setpoint

__all__ = ["Course", "begin_course", "landing", "lifting"]

_FAR_BELOW_M = 1000.0


class Course(NamedTuple):
    """What is left of a route, and the setpoint that glides along it."""

    mode: Mode
    begun_at_us: int
    ground_down_m: float
    route: Route
    glide: Glide

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now. A landing has no height to go to, only a speed."""
        return self.glide.setpoint(height=not self.route[0].is_landing)

    def follows(self, condition: Condition, parameters: Mapping[str, float]) -> Mode | None:
        """The mode that comes after this one, once the vehicle is at the last waypoint."""
        then = MODES[self.mode].then
        if then is None or len(self.route) > 1 or not _reached(self.route[0], condition, parameters):
            return None
        return then

    def step(self, condition: Condition, dt_s: float, parameters: Mapping[str, float]) -> Course:
        """The course `dt_s` later."""
        route = self.route
        if len(route) > 1 and _reached(route[0], condition, parameters):
            route = route[1:]
        goal, glide = route[0], self.glide
        glide = step_glide(
            glide,
            goal.place_m,
            glide.down_m + _FAR_BELOW_M if goal.is_landing else goal.down_m,
            goal.yaw_ned_rad if math.isfinite(goal.yaw_ned_rad) else glide.yaw_ned_rad,
            self._limits(goal, condition.time_us, parameters),
            dt_s,
        )
        return Course(self.mode, self.begun_at_us, self.ground_down_m, route, glide)

    def _limits(self, goal: Waypoint, now_us: int, parameters: Mapping[str, float]) -> GlideLimits:
        up_mps, down_mps = parameters["MPC_Z_V_AUTO_UP"], parameters["MPC_Z_V_AUTO_DN"]
        if self.mode is Mode.TAKEOFF:
            ramp_s = max(parameters["MPC_TKO_RAMP_T"], 1e-3)
            up_mps = parameters["MPC_TKO_SPEED"] * min(1.0, 1e-6 * (now_us - self.begun_at_us) / ramp_s)
        if goal.is_landing:
            down_mps = _landing_speed_mps(self.ground_down_m - self.glide.down_m, parameters)
        return GlideLimits(
            speed_mps=goal.speed_mps if goal.speed_mps > 0.0 else parameters["MPC_XY_CRUISE"],
            up_mps=up_mps,
            down_mps=down_mps,
            acceleration_mps2=parameters["MPC_ACC_HOR"],
            jerk_mps3=parameters["MPC_JERK_AUTO"],
            yaw_rate_radps=math.radians(parameters["MPC_YAWRAUTO_MAX"]),
        )


def begin_course(mode: Mode, briefing: Briefing) -> Course:
    """The mode's route, laid from where the vehicle is now. Home's height stands for the ground's."""
    ground_down_m = math.nan if briefing.home is None else float(briefing.home.position_ned_m[2])
    return Course(
        mode, briefing.condition.time_us, ground_down_m, MODES[mode].route(briefing), briefing.glide
    )


def lifting(top: Waypoint, briefing: Briefing) -> Course:
    """A take-off to that place."""
    return Course(Mode.TAKEOFF, briefing.condition.time_us, math.nan, (top,), briefing.glide)


def landing(place_m: complex, ground_down_m: float, glide: Glide) -> Course:
    """A landing at that place."""
    return Course(Mode.LAND, 0, ground_down_m, (Waypoint(place_m, math.inf),), glide)


def _reached(goal: Waypoint, condition: Condition, parameters: Mapping[str, float]) -> bool:
    north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
    near = abs(complex(north_m, east_m) - goal.place_m) <= parameters["NAV_ACC_RAD"]
    return near and abs(down_m - goal.down_m) <= parameters["NAV_MC_ALT_RAD"]


def _landing_speed_mps(height_m: float, parameters: Mapping[str, float]) -> float:
    """Slower towards the ground: from MPC_LAND_ALT1 down to MPC_LAND_ALT2 in proportion to the height."""
    high_m, low_m = parameters["MPC_LAND_ALT1"], parameters["MPC_LAND_ALT2"]
    fast_mps, slow_mps = parameters["MPC_Z_V_AUTO_DN"], parameters["MPC_LAND_SPEED"]
    if not height_m > low_m:
        return slow_mps
    return slow_mps + (fast_mps - slow_mps) * min(1.0, (height_m - low_m) / max(high_m - low_m, 1e-3))
