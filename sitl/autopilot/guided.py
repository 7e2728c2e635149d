"""GUIDED: a target streamed from outside, extrapolated between messages and followed by ArduPilot's shaping.

Source: ArduPilot 4.6, mode_guided.cpp, as it was seen to behave. A group of three axes is commanded whole or not at all.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import Enum, auto
from typing import NamedTuple

from sitl.autopilot.glide import Glide, start_glide
from sitl.autopilot.shaping import Motion, pursue, shape_yaw
from sitl.autopilot.trip import Speeds, Trip, by_parameters, climb, speeds_of, vertical_limits, yaw_limits
from sitl.condition import Condition
from sitl.kernels import Triple
from sitl.orders import TurnTo
from sitl.signals import Setpoint

__all__ = ["Guided", "begin_guided"]

_THERE_RAD = 1e-6
_ALONG_FROM = 0.05
"""Of the greatest speed: slower than that the nose does not turn along the way."""


class _Limits(NamedTuple):
    """How fast the target may move and turn: in speed, acceleration and jerk, and as `shape_yaw` takes it."""

    level: Triple
    up: Triple
    down: Triple
    yaw: Triple


@by_parameters(
    "WPNAV_SPEED",
    "WPNAV_SPEED_UP",
    "WPNAV_SPEED_DN",
    "WPNAV_ACCEL",
    "WPNAV_ACCEL_Z",
    "PSC_JERK_XY",
    "PSC_JERK_Z",
    "ATC_SLEW_YAW",
    "ATC_ACCEL_Y_MAX",
    "ATC_INPUT_TC",
)
def _limits(speeds: Speeds, parameters: Mapping[str, float]) -> _Limits:
    most, vertical = speeds_of(speeds, parameters), vertical_limits(parameters)
    level = most.speed_mps, most.acceleration_mps2, most.jerk_mps3
    return _Limits(level, (most.up_mps, *vertical), (most.down_mps, *vertical), yaw_limits(parameters))


class _Aim(Enum):
    REST = auto()
    POSITION = auto()
    VELOCITY = auto()
    MOTION = auto()


class Guided(NamedTuple):
    """What GUIDED does. `trip` is a take-off, `climbed` once it has come to its height; `goal` is the target as it was told, moved on since `told_us`.

    `along` turns the nose along the way; `to_turn_rad` is what is left of a CONDITION_YAW, at `pace_radps` (0: ATC_SLEW_YAW).
    """

    glide: Glide
    goal: Glide
    aim: _Aim = _Aim.REST
    told_us: int = 0
    along: bool = False
    trip: Trip | None = None
    to_turn_rad: float = 0.0
    pace_radps: float = 0.0
    climbed: bool = False

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now."""
        return self.glide.setpoint() if self.trip is None else self.trip.setpoint

    @property
    def goal_ned_m(self) -> Triple | None:
        """The place that it was told to go to; None for a take-off and for what moves."""
        if self.trip is not None or self.aim is not _Aim.POSITION:
            return None
        return self.goal.position_m.real, self.goal.position_m.imag, self.goal.down_m

    def lifted(self, down_m: float) -> Guided:
        """A take-off to that height, from here."""
        return self._replace(trip=climb(self.glide, down_m), climbed=False)

    def turned(self, turn: TurnTo) -> Guided:
        """With CONDITION_YAW's heading, also in a take-off. An absolute one is come to clockwise or not as it says."""
        yaw = self.glide.yaw_ned_rad if self.along else self.goal.yaw_ned_rad
        if turn.relative:
            left = turn.yaw_rad if turn.sign >= 0 else -turn.yaw_rad
        else:
            left = math.remainder(turn.yaw_rad - yaw, math.tau)
            if turn.sign * left < -_THERE_RAD:
                left += turn.sign * math.tau
        goal = self.goal._replace(yaw_ned_rad=yaw, yaw_rate_ned_radps=0.0)
        return self._replace(along=False, goal=goal, to_turn_rad=left, pace_radps=turn.rate_radps)

    def told(self, setpoint: Setpoint, now_us: int) -> Guided:
        """With a target from outside: it ends a take-off. Groups that do not belong together stop the vehicle."""
        north, east, down = setpoint.position_ned_m
        v_north, v_east, v_down = setpoint.velocity_ned_mps
        a_north, a_east, a_down = setpoint.acceleration_ned_mps2
        placed, moving, pushed = math.isfinite(north), math.isfinite(v_north), math.isfinite(a_north)
        before = self if self.trip is None else self._replace(glide=self.trip.glide, trip=None)
        if not (placed or moving or pushed) or (placed and pushed and not moving):
            return before.stopped(now_us)
        if not (placed or moving):  # an acceleration alone goes on from the speed that it has
            v_north, v_east = before.glide.velocity_mps.real, before.glide.velocity_mps.imag
            v_down, moving = before.glide.down_speed_mps, True
        goal = Glide(
            complex(north, east) if placed else before.glide.position_m,
            complex(v_north, v_east) if moving else 0j,
            complex(a_north, a_east) if pushed else 0j,
            down if placed else before.glide.down_m,
            v_down if moving else 0.0,
            a_down if pushed else 0.0,
            *before._yaw_told(setpoint),
        )
        aim = _Aim.MOTION if placed and moving else _Aim.POSITION if placed else _Aim.VELOCITY
        along = math.isnan(setpoint.yaw_ned_rad) and math.isnan(setpoint.yaw_rate_ned_radps)
        return Guided(before.glide, goal, aim, now_us, along)

    def _yaw_told(self, setpoint: Setpoint) -> tuple[float, float]:
        yaw, rate = setpoint.yaw_ned_rad, setpoint.yaw_rate_ned_radps
        if not math.isfinite(yaw):
            yaw = self.goal.yaw_ned_rad if math.isfinite(rate) else self.glide.yaw_ned_rad
        return yaw, rate if math.isfinite(rate) else 0.0

    def stopped(self, now_us: int) -> Guided:
        """Brake and stay."""
        rest = self.glide._replace(
            velocity_mps=0j,
            acceleration_mps2=0j,
            down_speed_mps=0.0,
            down_acceleration_mps2=0.0,
            yaw_rate_ned_radps=0.0,
        )
        return Guided(self.glide, rest, _Aim.REST, now_us)

    def step(
        self, condition: Condition, dt_s: float, parameters: Mapping[str, float], speeds: Speeds
    ) -> Guided:
        """The target `dt_s` later."""
        if self.trip is not None:
            turning = _limits(speeds, parameters).yaw
            yaw_goal, left = self._turn_on(self.goal, turning[2], dt_s)
            trip = self.trip.step(condition, dt_s, parameters, speeds)
            yaw, rate = _nose(yaw_goal, 0.0, *self.glide[6:], turning, dt_s)
            glide = trip.glide._replace(yaw_ned_rad=yaw, yaw_rate_ned_radps=rate)
            goal = self.goal._replace(yaw_ned_rad=yaw_goal)
            return self._replace(
                trip=trip._replace(glide=glide),
                glide=glide,
                goal=goal,
                to_turn_rad=left,
                climbed=self.climbed or trip.is_over(condition, parameters),
            )
        return self.moved(condition.time_us, dt_s, parameters, speeds)

    def moved(self, now_us: int, dt_s: float, parameters: Mapping[str, float], speeds: Speeds) -> Guided:
        """The streamed target `dt_s` later: it needs no look at the vehicle."""
        late = now_us - self.told_us > 1e6 * parameters["GUID_TIMEOUT"]
        goal = _at_rest(self.goal) if late else self.goal
        level, up, down, turning = _limits(speeds, parameters)
        to_place = self.aim in (_Aim.POSITION, _Aim.MOTION)
        motion, wanted = pursue(self.glide[:6], goal[:6], to_place, level, up, down, dt_s)
        yaw, rate = self.glide[6:]
        yaw_rate_goal = goal.yaw_rate_ned_radps
        yaw_goal, left = self._turn_on(goal, turning[2], dt_s)
        goal = Glide(*wanted, yaw_goal, yaw_rate_goal)
        if self.along:
            yaw_goal, yaw_rate_goal = _along(motion, yaw, parameters)
        glide = Glide(*motion, *_nose(yaw_goal, yaw_rate_goal, yaw, rate, turning, dt_s))
        return Guided(glide, goal, self.aim, self.told_us, self.along, None, left, self.pace_radps)

    def _turn_on(self, goal: Glide, slew_radps: float, dt_s: float) -> tuple[float, float]:
        """The heading that is wanted `dt_s` later, and what is left of CONDITION_YAW's turn."""
        yaw, left = goal.yaw_ned_rad + goal.yaw_rate_ned_radps * dt_s, self.to_turn_rad
        if not left:
            return yaw, left
        most = dt_s * min(self.pace_radps or slew_radps, slew_radps)
        turn = min(max(left, -most), most)
        return yaw + turn, left - turn


def _nose(
    yaw_goal: float, rate_goal: float, yaw: float, rate: float, turning: Triple, dt_s: float
) -> tuple[float, float]:
    """Heading and yaw rate `dt_s` later, on the way to those that are wanted."""
    rate = shape_yaw(math.remainder(yaw_goal - yaw, math.tau), rate_goal, rate, turning, dt_s)
    return math.remainder(yaw + rate * dt_s, math.tau), rate


def begin_guided(condition: Condition) -> Guided:
    """GUIDED as it begins: it comes to rest where it is."""
    glide = start_glide(condition.estimate)
    return Guided(glide, glide).stopped(condition.time_us)


def _at_rest(goal: Glide) -> Glide:
    """After GUID_TIMEOUT without a message."""
    return goal._replace(
        velocity_mps=0j,
        acceleration_mps2=0j,
        down_speed_mps=0.0,
        down_acceleration_mps2=0.0,
        yaw_rate_ned_radps=0.0,
    )


def _along(motion: Motion, yaw_ned_rad: float, parameters: Mapping[str, float]) -> tuple[float, float]:
    """Heading and yaw rate of a nose that points the way it flies; where it creeps, it keeps its heading."""
    _, v, a, *_ = motion
    if abs(v) <= _ALONG_FROM * 0.01 * parameters["WPNAV_SPEED"]:
        return yaw_ned_rad, 0.0
    return math.atan2(v.imag, v.real), (v.conjugate() * a).imag / abs(v) ** 2
