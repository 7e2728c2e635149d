"""GUIDED: a target streamed from outside, extrapolated between messages and followed by ArduPilot's shaping.

Source: ArduPilot 4.6, mode_guided.cpp, as it was seen to behave. A group of three axes is commanded whole or not at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import Enum, auto
from functools import cache
from itertools import chain
from typing import NamedTuple

import numpy as np

from sitl.autopilot.glide import Glide, start_glide
from sitl.autopilot.pursuit import (
    GOAL,
    GOAL_AND_TURN,
    GOAL_PLACE,
    GOAL_RATES,
    GOAL_YAW,
    LIMITS_N,
    MOTION,
    NOSE,
    PLACE,
    PURSUIT_N,
    TARGET,
    TURN,
    VELOCITY,
    YAW,
    pursue_on,
    turn_on,
)
from sitl.autopilot.trip import Speeds, Trip, by_parameters, climb, speeds_of, vertical_limits, yaw_limits
from sitl.condition import Condition
from sitl.kernels import FloatArray, Triple, prepared
from sitl.orders import TurnTo
from sitl.signals import Setpoint, vector

__all__ = ["Guided", "begin_guided"]

_THERE_RAD = 1e-6
_ALONG_FROM = 0.05
"""Of the greatest speed: slower than that the nose does not turn along the way."""
_STILL, _NO_TURN = (0.0, 0.0, 0.0), (0.0, 0.0)


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
def _limits(speeds: Speeds, parameters: Mapping[str, float]) -> FloatArray:
    """LIMITS: how fast the target may move and turn."""
    most, vertical = speeds_of(speeds, parameters), vertical_limits(parameters)
    level = most.speed_mps, most.acceleration_mps2, most.jerk_mps3
    ways = (*level, most.up_mps, *vertical, most.down_mps, *vertical)
    along_from_mps = _ALONG_FROM * 0.01 * parameters["WPNAV_SPEED"]
    return vector((*ways, *yaw_limits(parameters), along_from_mps), LIMITS_N)


@cache
def _pursue_on() -> Callable[[FloatArray, FloatArray, bool, bool, bool, float], None]:
    limits = vector(np.zeros(LIMITS_N), LIMITS_N)
    return prepared(pursue_on, np.zeros(PURSUIT_N), limits, True, True, True, 0.0)


class _Aim(Enum):
    REST = auto()
    POSITION = auto()
    VELOCITY = auto()
    MOTION = auto()


class Guided(NamedTuple):
    """What GUIDED does: a PURSUIT of the target that it was told at `told_us`, whose numbers are never written to.

    `along` turns the nose along the way; `trip` is a take-off, `climbed` once it has come to its height.
    """

    numbers: FloatArray
    aim: _Aim = _Aim.REST
    told_us: int = 0
    along: bool = False
    trip: Trip | None = None
    climbed: bool = False

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now."""
        if self.trip is not None:
            return self.trip.setpoint
        n, e, d, v_n, v_e, v_d, a_n, a_e, a_d, yaw, yaw_rate = self.numbers[TARGET].tolist()
        return Setpoint((n, e, d), (v_n, v_e, v_d), (a_n, a_e, a_d), yaw, yaw_rate)

    @property
    def _glide(self) -> Glide:
        (n, e, d), (v_n, v_e, v_d), (a_n, a_e, a_d), *nose = self.setpoint[:5]
        return Glide(complex(n, e), complex(v_n, v_e), complex(a_n, a_e), d, v_d, a_d, *nose)

    @property
    def goal_ned_m(self) -> Triple | None:
        """The place that it was told to go to; None for a take-off and for what moves."""
        if self.trip is not None or self.aim is not _Aim.POSITION:
            return None
        north_m, east_m, down_m = self.numbers[GOAL_PLACE].tolist()
        return north_m, east_m, down_m

    def lifted(self, down_m: float) -> Guided:
        """A take-off to that height, from here."""
        return self._replace(trip=climb(self._glide, down_m), climbed=False)

    def turned(self, turn: TurnTo) -> Guided:
        """With CONDITION_YAW's heading, also in a take-off. An absolute one is come to clockwise or not as it says."""
        yaw = self.numbers.item(YAW if self.along else GOAL_YAW)
        if turn.relative:
            left = turn.yaw_rad if turn.sign >= 0 else -turn.yaw_rad
        else:
            left = math.remainder(turn.yaw_rad - yaw, math.tau)
            if turn.sign * left < -_THERE_RAD:
                left += turn.sign * math.tau
        numbers = self.numbers.copy()
        numbers[GOAL_YAW:] = yaw, 0.0, left, turn.rate_radps
        return self._replace(along=False, numbers=numbers)

    def told(self, setpoint: Setpoint, now_us: int) -> Guided:
        """With a target from outside: it ends a take-off. Groups that do not belong together stop the vehicle."""
        placed = math.isfinite(setpoint.position_ned_m[0])
        moving = math.isfinite(setpoint.velocity_ned_mps[0])
        pushed = math.isfinite(setpoint.acceleration_ned_mps2[0])
        if not (placed or moving or pushed) or (placed and pushed and not moving):
            return self.stopped(now_us)
        numbers = self.numbers.copy()
        yaw, yaw_rate = setpoint.yaw_ned_rad, setpoint.yaw_rate_ned_radps
        if not math.isfinite(yaw):
            yaw = numbers.item(GOAL_YAW if math.isfinite(yaw_rate) else YAW)
        numbers[GOAL_AND_TURN] = (
            *(setpoint.position_ned_m if placed else numbers[PLACE].tolist()),
            # An acceleration alone goes on from the speed that it has.
            *(setpoint.velocity_ned_mps if moving else _STILL if placed else numbers[VELOCITY].tolist()),
            *(setpoint.acceleration_ned_mps2 if pushed else _STILL),
            yaw,
            yaw_rate if math.isfinite(yaw_rate) else 0.0,
            *_NO_TURN,
        )
        aim = _Aim.MOTION if placed and moving else _Aim.POSITION if placed else _Aim.VELOCITY
        along = math.isnan(setpoint.yaw_ned_rad) and math.isnan(setpoint.yaw_rate_ned_radps)
        return Guided(numbers, aim, now_us, along)

    def stopped(self, now_us: int) -> Guided:
        """Brake and stay."""
        numbers = self.numbers.copy()
        numbers[GOAL] = numbers[TARGET]
        numbers[GOAL_RATES], numbers[GOAL_YAW + 1], numbers[TURN] = 0.0, 0.0, 0.0
        return Guided(numbers, _Aim.REST, now_us)

    def step(
        self, condition: Condition, dt_s: float, parameters: Mapping[str, float], speeds: Speeds
    ) -> Guided:
        """The target `dt_s` later."""
        if self.trip is None:
            return self.moved(condition.time_us, dt_s, parameters, speeds)
        trip = self.trip.step(condition, dt_s, parameters, speeds)
        numbers = self.numbers.copy()
        numbers[MOTION] = list(chain(*trip.glide.setpoint()[:3]))
        turn_on(numbers, _limits(speeds, parameters), dt_s)
        yaw, yaw_rate = numbers[NOSE].tolist()
        glide = trip.glide._replace(yaw_ned_rad=yaw, yaw_rate_ned_radps=yaw_rate)
        climbed = self.climbed or trip.is_over(condition, parameters)
        return self._replace(numbers=numbers, trip=trip._replace(glide=glide), climbed=climbed)

    def moved(self, now_us: int, dt_s: float, parameters: Mapping[str, float], speeds: Speeds) -> Guided:
        """The streamed target `dt_s` later: it needs no look at the vehicle."""
        late = now_us - self.told_us > 1e6 * parameters["GUID_TIMEOUT"]
        to_place = self.aim in (_Aim.POSITION, _Aim.MOTION)
        numbers = self.numbers.copy()
        _pursue_on()(numbers, _limits(speeds, parameters), late, to_place, self.along, dt_s)
        return Guided(numbers, self.aim, self.told_us, self.along)


def begin_guided(condition: Condition) -> Guided:
    """GUIDED as it begins: it comes to rest where it is."""
    numbers = np.zeros(PURSUIT_N)
    glide = start_glide(condition.estimate)
    numbers[TARGET] = *chain(*glide.setpoint()[:3]), glide.yaw_ned_rad, glide.yaw_rate_ned_radps
    return Guided(numbers).stopped(condition.time_us)
