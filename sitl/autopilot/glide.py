"""A setpoint that moves to where it is wanted without a step in position, velocity or acceleration.

The horizontal plane is the complex plane (north + i·east), so that one rule serves it and the vertical line.
Far from the goal the speed follows the braking parabola √(2A(d − A/2K²)), near it the line K·d, and both meet
smoothly; the acceleration follows the missing speed in the same two ways. Only half of the acceleration and
half of the jerk are planned with: the rest makes up for their lag, so that nothing overshoots.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

from sitl.rotation import to_yaw
from sitl.signals import Estimate, Setpoint

__all__ = [
    "AT_REST_MPS",
    "Glide",
    "GlideLimits",
    "climbing",
    "follow_speed",
    "led_across",
    "start_glide",
    "step_glide",
    "stopping_point",
]

AT_REST_MPS = 0.1
"""What sticks lead stands, once it is slower and they are let go."""

_K = 0.8  # 1/s, speed per distance near the goal
_PLANNED = 0.5
_K_SPEED = 4.0 * _K  # 1/s, acceleration per missing speed: critically damped with _K

_Number = TypeVar("_Number", float, complex)


class GlideLimits(NamedTuple):
    """How fast a setpoint may move and turn."""

    speed_mps: float
    up_mps: float
    down_mps: float
    acceleration_mps2: float
    jerk_mps3: float
    yaw_rate_radps: float


class Glide(NamedTuple):
    """A moving setpoint: horizontal parts as north + i·east, vertical parts positive down."""

    position_m: complex
    velocity_mps: complex
    acceleration_mps2: complex
    down_m: float
    down_speed_mps: float
    down_acceleration_mps2: float
    yaw_ned_rad: float
    yaw_rate_ned_radps: float

    def setpoint(self, *, height: bool = True) -> Setpoint:
        """This moment as the cascade takes it; without `height` the vertical axis follows its speed alone."""
        down_m = self.down_m if height else math.nan
        place, speed, push = self.position_m, self.velocity_mps, self.acceleration_mps2
        return Setpoint(
            (place.real, place.imag, down_m),
            (speed.real, speed.imag, self.down_speed_mps),
            (push.real, push.imag, self.down_acceleration_mps2),
            self.yaw_ned_rad,
            self.yaw_rate_ned_radps,
        )


def start_glide(estimate: Estimate) -> Glide:
    """A setpoint that moves as the vehicle does."""
    north, east, down = estimate.position_ned_m.tolist()
    north_speed, east_speed, down_speed = estimate.velocity_ned_mps.tolist()
    yaw = to_yaw(estimate.q_ned_frd)
    return Glide(complex(north, east), complex(north_speed, east_speed), 0j, down, down_speed, 0.0, yaw, 0.0)


def stopping_point(glide: Glide, acceleration_mps2: float) -> tuple[complex, float]:
    """Where a gliding setpoint comes to rest when it brakes now: horizontal place and height (down)."""
    return (
        glide.position_m + _stopping_distance(glide.velocity_mps, acceleration_mps2),
        glide.down_m + _stopping_distance(glide.down_speed_mps, acceleration_mps2),
    )


def step_glide(
    glide: Glide, place_m: complex, down_m: float, yaw_ned_rad: float, limits: GlideLimits, dt_s: float
) -> Glide:
    """The setpoint `dt_s` later, on its way to that place, height and heading."""
    a, jerk = limits.acceleration_mps2, limits.jerk_mps3
    vertical_mps = limits.down_mps if down_m > glide.down_m else limits.up_mps
    position, velocity, acceleration = _approach(
        glide.position_m,
        glide.velocity_mps,
        glide.acceleration_mps2,
        place_m,
        limits.speed_mps,
        a,
        jerk,
        dt_s,
    )
    down, down_speed, down_acceleration = _approach(
        glide.down_m, glide.down_speed_mps, glide.down_acceleration_mps2, down_m, vertical_mps, a, jerk, dt_s
    )
    turn = math.remainder(yaw_ned_rad - glide.yaw_ned_rad, math.tau)
    turn = math.copysign(min(abs(turn), limits.yaw_rate_radps * dt_s), turn)
    yaw = math.remainder(glide.yaw_ned_rad + turn, math.tau)
    return Glide(
        position,
        velocity,
        acceleration,
        down,
        down_speed,
        down_acceleration,
        yaw,
        turn / dt_s if dt_s else 0.0,
    )


def _approach(
    p: _Number,
    v: _Number,
    a: _Number,
    goal: _Number,
    speed: float,
    acceleration: float,
    jerk: float,
    dt: float,
) -> tuple[_Number, _Number, _Number]:
    """Position, velocity and acceleration one step nearer to rest at the goal."""
    way = goal - p
    distance = abs(way)
    wanted_v = way * (min(speed, _braking_speed(distance, acceleration)) / distance) if distance else 0 * way
    return follow_speed(p, v, a, wanted_v, acceleration, jerk, dt)


def follow_speed(
    p: _Number, v: _Number, a: _Number, wanted_v: _Number, acceleration: float, jerk: float, dt: float
) -> tuple[_Number, _Number, _Number]:
    """Position, velocity and acceleration a step later, on the way to the wanted velocity."""
    missing_v = wanted_v - v
    settling = math.sqrt(2.0 * _PLANNED * jerk * abs(missing_v))
    wanted_a = _limited(missing_v * _K_SPEED, min(acceleration, settling))
    a = a + _limited(wanted_a - a, jerk * dt)
    v = v + a * dt
    return p + v * dt, v, a


def led_across(
    glide: Glide,
    here_m: complex,
    wanted_mps: complex,
    acceleration_mps2: float,
    jerk_mps3: float,
    dt_s: float,
) -> Glide:
    """The target `dt_s` later on its way to that level speed. As long as it moves its place is the vehicle's own, `here_m`."""
    moves = wanted_mps != 0.0 or abs(glide.velocity_mps) > AT_REST_MPS
    place, velocity, push = follow_speed(
        here_m if moves else glide.position_m,
        glide.velocity_mps,
        glide.acceleration_mps2,
        wanted_mps,
        acceleration_mps2,
        jerk_mps3,
        dt_s,
    )
    return glide._replace(position_m=place, velocity_mps=velocity, acceleration_mps2=push)


def climbing(
    glide: Glide, climb_mps: float, acceleration_mps2: float, jerk_mps3: float, dt_s: float
) -> Glide:
    """The target `dt_s` later on its way to that rate of climb."""
    down, speed, push = follow_speed(
        glide.down_m,
        glide.down_speed_mps,
        glide.down_acceleration_mps2,
        -climb_mps,
        acceleration_mps2,
        jerk_mps3,
        dt_s,
    )
    return glide._replace(down_m=down, down_speed_mps=speed, down_acceleration_mps2=push)


def _limited(value: _Number, most: float) -> _Number:
    size = abs(value)
    return value if size <= most else value * (most / size)


def _braking_speed(distance: float, acceleration: float) -> float:
    brake = _PLANNED * acceleration
    knee = brake / _K**2
    return _K * distance if distance <= knee else math.sqrt(2.0 * brake * (distance - 0.5 * knee))


def _stopping_distance(v: _Number, acceleration: float) -> _Number:
    brake = _PLANNED * acceleration
    speed = abs(v)
    if speed <= brake / _K:
        return v * (1.0 / _K)
    return v * ((0.5 * speed**2 / brake + 0.5 * brake / _K**2) / speed)
