"""ArduPilot's shaping: a moving target follows the one that was asked for, limited in acceleration and jerk.

Source: ArduPilot 4.6, AP_Math/control.cpp (sqrt_controller, shape_accel, shape_vel_accel, shape_pos_vel_accel) and
AC_AttitudeControl.cpp (input_shaping_angle). The horizontal plane is the complex plane (north + i·east), so that one
rule serves it and the vertical line. A position alone is followed at v²/A + A/(4K²) behind, with K = J/(2A). GUIDED
shapes in every frame: these are kernels, and take plain tuples.
"""

from __future__ import annotations

import math
from typing import TypeVar

from sitl.kernels import Triple, kernel

__all__ = ["Motion", "limited", "pursue", "shape_position", "shape_velocity", "shape_yaw", "square_root"]

Motion = tuple[complex, complex, complex, float, float, float]
"""Position, velocity and acceleration: horizontally, then downwards."""

_Number = TypeVar("_Number", float, complex)


@kernel
def limited(value: _Number, most: float) -> _Number:
    """The value, no longer than `most`."""
    size = abs(value)
    return value if size <= most else value * (most / size)


@kernel
def square_root(error: _Number, gain: float, second_order: float, dt: float) -> _Number:
    """The rate that takes an error away: gain·e near zero, √(2L(e − L/(2·gain²))) beyond, never past it in `dt`."""
    size = abs(error)
    if size == 0.0:
        return 0.0 * error
    linear = second_order / gain**2
    rate = gain * size if size <= linear else math.sqrt(2.0 * second_order * (size - 0.5 * linear))
    return error * (min(rate, size / dt) / size)


@kernel
def shape_velocity(
    wanted_v: _Number, wanted_a: _Number, v: _Number, a: _Number, accel: float, jerk: float, dt: float
) -> _Number:
    """The acceleration a step later, on the way to that velocity and acceleration."""
    correction = limited(square_root(wanted_v - v, jerk / accel, jerk, dt), accel)
    return a + limited(correction + wanted_a - a, jerk * dt)


@kernel
def shape_position(
    wanted: tuple[_Number, _Number, _Number],
    p: _Number,
    v: _Number,
    a: _Number,
    limits: tuple[float, float, float],
    dt: float,
) -> _Number:
    """The acceleration a step later, on the way to that position, velocity and acceleration.

    `limits` are of the speed that corrects the position (what is fed forward comes on top), of the acceleration
    and of the jerk.
    """
    wanted_p, wanted_v, wanted_a = wanted
    speed, accel, jerk = limits
    correction = limited(square_root(wanted_p - p, 0.5 * jerk / accel, 0.5 * accel, dt), speed)
    return shape_velocity(correction + wanted_v, wanted_a, v, a, accel, jerk, dt)


@kernel
def shape_yaw(
    error_rad: float, wanted_rate: float, rate: float, limits: tuple[float, float, float], dt: float
) -> float:
    """The yaw rate a step later. `limits` are the time constant, the angular acceleration and the rate."""
    time_constant_s, accel, most = limits
    wanted = square_root(error_rad, 1.0 / time_constant_s, accel, dt) + wanted_rate
    return rate + limited(limited(wanted, most) - rate, accel * dt)


@kernel
def pursue(
    target: Motion, goal: Motion, to_place: bool, level: Triple, up: Triple, down: Triple, dt: float
) -> tuple[Motion, Motion]:
    """Target and goal a step later: the goal moves on by itself, the target after it, `to_place` or at its velocity.

    `level`, `up` and `down` are limits as `shape_position` takes them.
    """
    p, v, a, low, sink, push = target
    wanted_p, wanted_v, wanted_a, wanted_low, wanted_sink, wanted_push = goal
    wanted_p += (wanted_v + 0.5 * wanted_a * dt) * dt
    wanted_v += wanted_a * dt
    wanted_low += (wanted_sink + 0.5 * wanted_push * dt) * dt
    wanted_sink += wanted_push * dt
    vertical = down if wanted_low > low else up
    if to_place:
        a = shape_position((wanted_p, wanted_v, wanted_a), p, v, a, level, dt)
        upright = wanted_low, wanted_sink, wanted_push
        push = shape_position(upright, low, sink, push, vertical, dt)
    else:
        a = shape_velocity(wanted_v, wanted_a, v, a, level[1], level[2], dt)
        push = shape_velocity(wanted_sink, wanted_push, sink, push, vertical[1], vertical[2], dt)
    v += a * dt
    sink += push * dt
    return (
        (p + v * dt, v, a, low + sink * dt, sink, push),
        (wanted_p, wanted_v, wanted_a, wanted_low, wanted_sink, wanted_push),
    )
