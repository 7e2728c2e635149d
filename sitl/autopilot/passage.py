"""A setpoint that passes waypoints without stopping, as PX4's trajectory generator does.

Sources: PX4 v1.17, PositionSmoothing.cpp and TrajectoryConstraints.hpp. The speed is what still allows to
turn at the next waypoint and to stop at the one after it: PX4 looks no further, so that close waypoints are
flown slowly. Simpler than PX4: the speed is followed by the law of `glide` and not axis by axis in least time.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass

from sitl.autopilot.glide import Glide, GlideLimits, follow_speed
from sitl.autopilot.modes import Waypoint

__all__ = ["Leg", "Passage", "step_passage", "turned"]

_L1_M = 5.0
_ALIGNED = 0.98
_TURNING_MPS = 0.2
_SAME_PLACE_M = 1e-3
_CREEP_MPS = 0.3
_YAW_JERK = 10.0  # 1/s, yaw jerk per yaw acceleration


@dataclass(frozen=True, slots=True)
class Leg:
    """From where, to where, and what comes after; None is a stop. `radius_m` is where the next leg begins."""

    begin: Waypoint
    end: Waypoint
    after: Waypoint | None
    radius_m: float


@dataclass(frozen=True, slots=True)
class Passage:
    """A setpoint on a leg, and the speed that it had when it last flew straight."""

    glide: Glide
    straight_mps: float = math.inf


def step_passage(
    passage: Passage,
    leg: Leg,
    yaw_ned_rad: float,
    limits: GlideLimits,
    parameters: Mapping[str, float],
    behind_m: complex,
    dt_s: float,
) -> Passage:
    """The setpoint `dt_s` later. It waits for a vehicle that is `behind_m` short of it."""
    glide, a, jerk = passage.glide, limits.acceleration_mps2, limits.jerk_mps3
    turning = _is_turning(glide, leg)
    aim_m, aim_down_m = _on_line(glide, leg) if turning else (leg.end.place_m, leg.end.down_m)
    speed_mps = _horizontal_mps(glide, leg, limits, parameters["MPC_XY_TRAJ_P"])
    straight_mps = speed_mps
    if turning:
        straight_mps = passage.straight_mps
        speed_mps = min(straight_mps, speed_mps)
    velocity, down_speed = _towards(
        aim_m - glide.position_m, aim_down_m - glide.down_m, speed_mps, _vertical_mps(glide, leg, limits)
    )
    moving_s = dt_s * _patience(behind_m, glide.velocity_mps, parameters["MPC_XY_ERR_MAX"])
    p, v, acc = follow_speed(
        glide.position_m, glide.velocity_mps, glide.acceleration_mps2, velocity, a, jerk, moving_s
    )
    down, down_v, down_a = follow_speed(
        glide.down_m, glide.down_speed_mps, glide.down_acceleration_mps2, down_speed, a, jerk, dt_s
    )
    yaw, rate = turned(glide.yaw_ned_rad, glide.yaw_rate_ned_radps, yaw_ned_rad, parameters, dt_s)
    return Passage(Glide(p, v, acc, down, down_v, down_a, yaw, rate), straight_mps)


def turned(
    yaw_rad: float, rate_radps: float, wanted_rad: float, parameters: Mapping[str, float], dt_s: float
) -> tuple[float, float]:
    """Heading and its rate, a step nearer to the one that is wanted (PX4's HeadingSmoothing)."""
    most_radps = math.radians(parameters["MPC_YAWRAUTO_MAX"])
    a = max(math.radians(parameters["MPC_YAWRAUTO_ACC"]), 1e-6)
    error = math.remainder(wanted_rad - yaw_rad, math.tau)
    wanted = math.copysign(min(most_radps, _speed_for(_YAW_JERK * a, a, abs(error), 0.0)), error)
    rate = rate_radps + max(-a * dt_s, min(a * dt_s, wanted - rate_radps))
    return math.remainder(yaw_rad + rate * dt_s, math.tau), rate


def _is_turning(glide: Glide, leg: Leg) -> bool:
    """Whether it flies past its waypoint rather than to it."""
    way, speed = leg.end.place_m - glide.position_m, abs(glide.velocity_mps)
    if speed <= _TURNING_MPS or abs(way) <= leg.radius_m:
        return False
    return (glide.velocity_mps.conjugate() * way).real < _ALIGNED * speed * abs(way)


def _on_line(glide: Glide, leg: Leg) -> tuple[complex, float]:
    """The point of the leg's line that lies the L1 distance ahead."""
    way, climb = leg.end.place_m - leg.begin.place_m, leg.end.down_m - leg.begin.down_m
    length = math.hypot(abs(way), climb)
    if length < _SAME_PLACE_M:
        return leg.end.place_m, leg.end.down_m
    way, climb = way / length, climb / length
    gone, sunk = glide.position_m - leg.begin.place_m, glide.down_m - leg.begin.down_m
    along = (gone.conjugate() * way).real + sunk * climb
    off = math.hypot(abs(gone - along * way), sunk - along * climb)
    along += math.sqrt(max(0.0, max(leg.radius_m, _L1_M) ** 2 - off**2))
    return leg.begin.place_m + along * way, leg.begin.down_m + along * climb


def _horizontal_mps(glide: Glide, leg: Leg, limits: GlideLimits, gain: float) -> float:
    """How fast it may go now, for the turn at the leg's end and the stop after it."""
    a, jerk = limits.acceleration_mps2, limits.jerk_mps3
    way, turn_mps = leg.end.place_m - glide.position_m, 0.0
    if leg.after is not None:
        onward = leg.after.place_m - leg.end.place_m
        if abs(onward) >= max(leg.radius_m, _SAME_PLACE_M):
            angle = math.pi - abs(cmath.phase(onward * way.conjugate())) if way else math.pi / 2.0
            tangent = math.tan(0.5 * min(angle, math.pi - 1e-7))
            in_turn_mps = math.sqrt(gain * a * leg.radius_m * tangent)
            turn_mps = min(in_turn_mps, _speed_for(jerk, a, abs(onward), 0.0), limits.speed_mps)
    return min(limits.speed_mps, _speed_for(jerk, a, abs(way), turn_mps))


def _vertical_mps(glide: Glide, leg: Leg, limits: GlideLimits) -> float:
    """How fast it may climb or sink now; it passes a height only on the way to one further on."""
    way = leg.end.down_m - glide.down_m
    limit_mps = limits.down_mps if way > 0.0 else limits.up_mps
    passes = leg.after is not None and (leg.after.down_m - leg.end.down_m) * way > 0.0
    onward_m = abs(leg.after.down_m - leg.end.down_m) if leg.after is not None and passes else 0.0
    a, jerk = limits.acceleration_mps2, limits.jerk_mps3
    exit_mps = min(limit_mps, _speed_for(jerk, a, onward_m, 0.0))
    return min(limit_mps, _speed_for(jerk, a, abs(way), exit_mps))


def _speed_for(jerk: float, acceleration: float, distance: float, final_speed: float) -> float:
    """The greatest speed that can be brought down to the final one within the distance (PX4's formula)."""
    b = 4.0 * acceleration**2 / jerk
    c = 2.0 * acceleration * distance + final_speed**2
    return max(0.5 * (math.sqrt(b * b + 4.0 * c) - b), final_speed)


def _towards(way: complex, sink: float, most_mps: float, most_down_mps: float) -> tuple[complex, float]:
    """The velocity along a straight line in space that exceeds neither limit.

    As in PX4, an axis that has almost arrived, and creeps, holds the other one up no longer.
    """
    across, depth = abs(way), abs(sink)
    length = math.hypot(across, depth)
    if length == 0.0:
        return 0j, 0.0
    speed = min(
        max(most_mps, _CREEP_MPS) * length / across if across > 0.0 else math.inf,
        max(most_down_mps, _CREEP_MPS) * length / depth if depth > 0.0 else math.inf,
    )
    level_mps, down_mps = min(speed * across / length, most_mps), min(speed * depth / length, most_down_mps)
    return way * (level_mps / across) if across else 0j, math.copysign(down_mps, sink)


def _patience(behind_m: complex, velocity_mps: complex, most_m: float) -> float:
    """How much slower time runs for a setpoint that has left its vehicle behind."""
    if most_m <= 0.0 or (behind_m.conjugate() * velocity_mps).real < 0.0:
        return 1.0
    return 1.0 - min(abs(behind_m) / most_m, 1.0)
