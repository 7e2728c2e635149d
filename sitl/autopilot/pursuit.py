"""GUIDED's target and nose a frame later, in one call: all that moves as one array of numbers.

PURSUIT numbers: the target as a setpoint has it (position, velocity, acceleration, each north, east, down; yaw, yaw
rate), the goal that it is after in the same order, what is left of a CONDITION_YAW's turn, and its pace (0: as fast as
may be). LIMITS numbers: speed, acceleration and jerk of the plane, of the way up and of the way down; the nose's as
`shape_yaw` takes them; and the speed from which on a nose that is to point the way it flies does so.
"""

from __future__ import annotations

import math

from sitl.autopilot.shaping import Motion, pursue, shape_yaw
from sitl.kernels import FloatArray, kernel

__all__ = [
    "GOAL",
    "GOAL_AND_TURN",
    "GOAL_PLACE",
    "GOAL_RATES",
    "GOAL_YAW",
    "LIMITS_N",
    "MOTION",
    "NOSE",
    "PLACE",
    "PURSUIT_N",
    "TARGET",
    "TURN",
    "VELOCITY",
    "YAW",
    "angle_between",
    "pursue_on",
    "turn_on",
]

PURSUIT_N, LIMITS_N = 24, 13
TARGET, PLACE, VELOCITY, MOTION, NOSE = slice(0, 11), slice(0, 3), slice(3, 6), slice(0, 9), slice(9, 11)
GOAL, GOAL_PLACE, GOAL_RATES = slice(11, 22), slice(11, 14), slice(14, 20)
TURN, GOAL_AND_TURN = slice(22, 24), slice(11, 24)
YAW, GOAL_YAW = 9, 20
"""Where they lie in a PURSUIT; a yaw rate comes after its yaw."""
_GOAL, _LEFT, _PACE = 11, 22, 23
_UP, _DOWN, _NOSE, _ALONG_FROM = 3, 6, 9, 12
_FULL_TURN = math.tau


@kernel
def angle_between(yaw_rad: float, from_rad: float) -> float:
    """The turn from one heading to the other, -π…π: as `math.remainder` by a full turn, to the bit."""
    angle = yaw_rad - from_rad
    size = abs(angle) % _FULL_TURN
    rest = _FULL_TURN - size
    if size > rest or (size == rest and abs(angle) % (2.0 * _FULL_TURN) > _FULL_TURN):
        size = -rest
    return math.copysign(1.0, angle) * size


@kernel
def _motion_at(numbers: FloatArray, at: int) -> Motion:
    return (
        complex(numbers[at], numbers[at + 1]),
        complex(numbers[at + 3], numbers[at + 4]),
        complex(numbers[at + 6], numbers[at + 7]),
        numbers[at + 2],
        numbers[at + 5],
        numbers[at + 8],
    )


@kernel
def _put_motion(numbers: FloatArray, at: int, motion: Motion) -> None:
    p, v, a, low, sink, push = motion
    numbers[at], numbers[at + 1], numbers[at + 2] = p.real, p.imag, low
    numbers[at + 3], numbers[at + 4], numbers[at + 5] = v.real, v.imag, sink
    numbers[at + 6], numbers[at + 7], numbers[at + 8] = a.real, a.imag, push


@kernel
def _turn_goal(numbers: FloatArray, slew_radps: float, dt: float) -> None:
    """The heading that is wanted `dt` later, and what is left of CONDITION_YAW's turn."""
    yaw, left = numbers[GOAL_YAW] + numbers[GOAL_YAW + 1] * dt, numbers[_LEFT]
    if left != 0.0:
        pace = numbers[_PACE] if numbers[_PACE] != 0.0 else slew_radps
        most = dt * min(pace, slew_radps)
        turn = min(max(left, -most), most)
        yaw, numbers[_LEFT] = yaw + turn, left - turn
    numbers[GOAL_YAW] = yaw


@kernel
def _turn_nose(numbers: FloatArray, limits: FloatArray, yaw_goal: float, rate_goal: float, dt: float) -> None:
    """Heading and yaw rate `dt` later, on the way to those that are wanted."""
    yaw, rate = numbers[YAW], numbers[YAW + 1]
    turning = limits[_NOSE], limits[_NOSE + 1], limits[_NOSE + 2]
    rate = shape_yaw(angle_between(yaw_goal, yaw), rate_goal, rate, turning, dt)
    numbers[YAW], numbers[YAW + 1] = angle_between(yaw + rate * dt, 0.0), rate


@kernel
def turn_on(numbers: FloatArray, limits: FloatArray, dt: float) -> None:
    """Turn the nose alone: after the goal's heading, as in a take-off."""
    _turn_goal(numbers, limits[_NOSE + 2], dt)
    _turn_nose(numbers, limits, numbers[GOAL_YAW], 0.0, dt)


@kernel
def pursue_on(
    numbers: FloatArray, limits: FloatArray, late: bool, to_place: bool, along: bool, dt: float
) -> None:
    """Move goal, target and nose on by `dt`; a goal of which nothing was heard for too long stays where it is first.

    `to_place` or at the goal's velocity; `along` the nose points the way that is flown, but where it creeps.
    """
    if late:
        for i in range(3, 9):
            numbers[_GOAL + i] = 0.0
        numbers[GOAL_YAW + 1] = 0.0
    level = limits[0], limits[1], limits[2]
    up = limits[_UP], limits[_UP + 1], limits[_UP + 2]
    down = limits[_DOWN], limits[_DOWN + 1], limits[_DOWN + 2]
    target, goal = _motion_at(numbers, 0), _motion_at(numbers, _GOAL)
    target, goal = pursue(target, goal, to_place, level, up, down, dt)
    _put_motion(numbers, 0, target)
    _put_motion(numbers, _GOAL, goal)
    _turn_goal(numbers, limits[_NOSE + 2], dt)
    yaw_goal, rate_goal = numbers[GOAL_YAW], numbers[GOAL_YAW + 1]
    if along:
        _, v, a, _, _, _ = target
        yaw_goal, rate_goal = numbers[YAW], 0.0
        if abs(v) > limits[_ALONG_FROM]:
            yaw_goal, rate_goal = math.atan2(v.imag, v.real), (v.conjugate() * a).imag / abs(v) ** 2
    _turn_nose(numbers, limits, yaw_goal, rate_goal, dt)
