"""GUIDED by SET_ATTITUDE_TARGET: an attitude that turns at the rates told, and a rate of climb or a thrust.

Source: ArduPilot 4.6, mode_guided.cpp, set_angle and angle_control_run. Simpler than ArduPilot: where thrust is a rate of
climb the lean is made by the position cascade, which keeps it within ANGLE_MAX.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from sitl.autopilot.glide import Glide, climbing, start_glide
from sitl.autopilot.lean import leaning, push_of, turned
from sitl.autopilot.trip import Speeds, speeds_of, vertical_limits
from sitl.condition import Condition
from sitl.kernels import Quaternion
from sitl.rotation import euler_rad
from sitl.signals import AttitudeSetpoint, Setpoint, vector

__all__ = ["Angled", "angled"]

_THRUST_IS_THRUST = 8
"""GUID_OPTIONS: else it is a rate of climb."""
_HOLD = 0.5
"""The thrust that keeps the height where thrust is a rate of climb."""


class Angled(NamedTuple):
    """A target attitude: its rates turn it, in the vehicle's own axes. `thrust` is as it was told."""

    q_ned_frd: Quaternion
    rate_frd_radps: tuple[float, float, float]
    thrust: float
    told_us: int
    glide: Glide
    setpoint: Setpoint

    @property
    def goal_ned_m(self) -> None:
        """It flies to no place."""

    def lifts(self, parameters: Mapping[str, float]) -> bool:
        """Whether it would leave the ground."""
        return self.thrust > (0.0 if _takes_thrust(parameters) else _HOLD)

    def step(self, condition: Condition, dt_s: float, parameters: Mapping[str, float], _: Speeds) -> Angled:
        """The target `dt_s` later: level and holding its height once GUID_TIMEOUT has passed without another."""
        q, rates, thrust = self.q_ned_frd, self.rate_frd_radps, self.thrust
        by_thrust = _takes_thrust(parameters)
        if condition.time_us - self.told_us > 1e6 * parameters["GUID_TIMEOUT"]:
            half_rad = 0.5 * euler_rad(vector(q, 4))[2]
            q, rates, thrust = (math.cos(half_rad), 0.0, 0.0, math.sin(half_rad)), (0.0, 0.0, 0.0), _HOLD
            by_thrust = False
        q = turned(q, rates, dt_s)
        wanted = vector(q, 4)
        if by_thrust:
            attitude = AttitudeSetpoint(wanted, vector((0.0, 0.0, rates[2])), thrust)
            moved = start_glide(condition.estimate)
            return self._replace(
                q_ned_frd=q, glide=moved, setpoint=leaning(moved, 0j)._replace(attitude=attitude)
            )
        most = speeds_of(Speeds(), parameters)
        climb_mps = 2.0 * (thrust - _HOLD) * (most.up_mps if thrust > _HOLD else most.down_mps)
        moved = climbing(self.glide, climb_mps, *vertical_limits(parameters), dt_s)
        moved = moved._replace(yaw_ned_rad=euler_rad(wanted)[2], yaw_rate_ned_radps=rates[2])
        return self._replace(q_ned_frd=q, glide=moved, setpoint=leaning(moved, push_of(q)))


def angled(before: object, told: AttitudeSetpoint, condition: Condition) -> Angled:
    """The target that was told just now; without an attitude the rates go on from the one before, or from how it leans."""
    glide = before.glide if isinstance(before, Angled) else start_glide(condition.estimate)
    if told.q_ned_frd is not None:
        w, x, y, z = told.q_ned_frd.tolist()
    elif isinstance(before, Angled):
        w, x, y, z = before.q_ned_frd
    else:
        w, x, y, z = condition.estimate.q_ned_frd.tolist()
    roll, pitch, yaw = told.rate_frd_radps.tolist()
    return Angled((w, x, y, z), (roll, pitch, yaw), told.thrust, condition.time_us, glide, leaning(glide, 0j))


def _takes_thrust(parameters: Mapping[str, float]) -> bool:
    return bool(int(parameters["GUID_OPTIONS"]) & _THRUST_IS_THRUST)
