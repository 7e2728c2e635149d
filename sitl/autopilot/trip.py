"""A route that ArduCopter flies by itself: places one after another, and at the end perhaps the ground.

Simpler than ArduPilot: between the places the target moves by the law of `glide`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from operator import itemgetter
from typing import NamedTuple, TypeVar

from sitl.autopilot.glide import Glide, GlideLimits, step_glide, stopping_point
from sitl.condition import Condition
from sitl.rotation import to_yaw
from sitl.signals import Setpoint
from sitl.status import Home

__all__ = [
    "Speeds",
    "Stop",
    "Trip",
    "acceleration_of",
    "arrived",
    "by_parameters",
    "climb",
    "fly_home",
    "hold_here",
    "land_here",
    "speeds_of",
    "vertical_limits",
    "yaw_limits",
]

Values = Mapping[str, float]
Found = TypeVar("Found")

_FAR_BELOW_M = 1000.0
_LEAST_SPEED, _LEAST_ACCELERATION, _LEAST_JERK = 0.1, 0.1, 0.1
_LEAST_TIME_S, _LEAST_TURN, _ANY_TURN = 0.01, math.radians(1.0), 100.0
_SINK_MOST_M = 3.0
"""A landing's target runs no further ahead of the vehicle than this."""


@dataclass(frozen=True, slots=True)
class Stop:
    """A place: north + i·east, and down; infinite is the ground. NaN keeps the heading."""

    place_m: complex
    down_m: float
    yaw_ned_rad: float = math.nan
    hold_s: float = 0.0

    @property
    def is_landing(self) -> bool:
        """Whether this is the ground, wherever it is."""
        return math.isinf(self.down_m)


class Speeds(NamedTuple):
    """How fast it flies by itself. NaN is what the parameters say; DO_CHANGE_SPEED sets them."""

    level_mps: float = math.nan
    up_mps: float = math.nan
    down_mps: float = math.nan


class Trip(NamedTuple):
    """What is left of a route, and the target that glides along it. `ground_down_m` is where the ground may be."""

    stops: tuple[Stop, ...]
    glide: Glide
    ground_down_m: float = math.nan
    arrived_at_us: int | None = None

    @property
    def setpoint(self) -> Setpoint:
        """What the cascade shall follow now. A landing has no height to go to, only a speed."""
        return self.glide.setpoint(height=not self.stops[0].is_landing)

    @property
    def goal_ned_m(self) -> tuple[float, float, float] | None:
        """The next stop, but for the ground."""
        stop = self.stops[0]
        return None if stop.is_landing else (stop.place_m.real, stop.place_m.imag, stop.down_m)

    def step(
        self, condition: Condition, dt_s: float, parameters: Mapping[str, float], speeds: Speeds
    ) -> Trip:
        """The trip `dt_s` later."""
        trip = self._moved_on(condition, parameters)
        goal, glide = trip.stops[0], trip.glide
        limits = speeds_of(speeds, parameters)
        if goal.is_landing:
            limits = limits._replace(down_mps=_landing_mps(trip.ground_down_m - glide.down_m, parameters))
        glide = step_glide(
            glide,
            goal.place_m,
            glide.down_m + _FAR_BELOW_M if goal.is_landing else goal.down_m,
            goal.yaw_ned_rad if math.isfinite(goal.yaw_ned_rad) else glide.yaw_ned_rad,
            limits,
            dt_s,
        )
        if goal.is_landing:
            lowest_m = float(condition.estimate.position_ned_m[2]) + _SINK_MOST_M
            glide = glide._replace(down_m=min(glide.down_m, lowest_m))
        return trip._replace(glide=glide)

    def is_over(self, condition: Condition, parameters: Mapping[str, float]) -> bool:
        """Whether the last place has been reached; the ground never counts."""
        return len(self.stops) == 1 and arrived(self.stops[0], condition, parameters)

    def _moved_on(self, condition: Condition, parameters: Mapping[str, float]) -> Trip:
        if len(self.stops) == 1:
            return self
        since_us = self.arrived_at_us
        if since_us is None:
            if not arrived(self.stops[0], condition, parameters):
                return self
            since_us = condition.time_us
        if condition.time_us - since_us < 1e6 * self.stops[0].hold_s:
            return self._replace(arrived_at_us=since_us)
        return self._replace(stops=self.stops[1:], arrived_at_us=None)


def by_parameters(
    *names: str,
) -> Callable[[Callable[[Speeds, Values], Found]], Callable[[Speeds, Values], Found]]:
    """Makes of a function of speeds and those parameters one that remembers: it is asked in every frame, and hardly ever anew."""
    values_of = itemgetter(*names)

    def remembering(work: Callable[[Speeds, Values], Found]) -> Callable[[Speeds, Values], Found]:
        @lru_cache(maxsize=64)
        def worked_out(speeds: Speeds, *values: float) -> Found:
            return work(speeds, dict(zip(names, values, strict=True)))

        return lambda speeds, parameters: worked_out(speeds, *values_of(parameters))

    return remembering


@by_parameters(
    "WPNAV_SPEED", "WPNAV_SPEED_UP", "WPNAV_SPEED_DN", "WPNAV_ACCEL", "PSC_JERK_XY", "ATC_SLEW_YAW"
)
def speeds_of(speeds: Speeds, parameters: Values) -> GlideLimits:
    """The limits of flying by itself, by the parameters WPNAV_ and PSC_."""
    return GlideLimits(
        speed_mps=max(_LEAST_SPEED, _or(speeds.level_mps, 0.01 * parameters["WPNAV_SPEED"])),
        up_mps=max(_LEAST_SPEED, _or(speeds.up_mps, 0.01 * parameters["WPNAV_SPEED_UP"])),
        down_mps=max(_LEAST_SPEED, _or(speeds.down_mps, 0.01 * parameters["WPNAV_SPEED_DN"])),
        acceleration_mps2=acceleration_of(parameters, "WPNAV_ACCEL"),
        jerk_mps3=max(_LEAST_JERK, parameters["PSC_JERK_XY"]),
        yaw_rate_radps=_slew_radps(parameters["ATC_SLEW_YAW"]),
    )


def acceleration_of(parameters: Mapping[str, float], name: str) -> float:
    """The acceleration of that parameter, which is in cm/s², and never so little that nothing moves."""
    return max(_LEAST_ACCELERATION, 0.01 * parameters[name])


def vertical_limits(parameters: Mapping[str, float]) -> tuple[float, float]:
    """Acceleration and jerk on the way up and down."""
    return acceleration_of(parameters, "WPNAV_ACCEL_Z"), max(_LEAST_JERK, parameters["PSC_JERK_Z"])


def yaw_limits(parameters: Mapping[str, float]) -> tuple[float, float, float]:
    """Time constant, angular acceleration and rate of a turning nose; an acceleration of 0 is no limit."""
    acceleration = math.radians(0.01 * parameters["ATC_ACCEL_Y_MAX"]) or _ANY_TURN
    return (
        max(_LEAST_TIME_S, parameters["ATC_INPUT_TC"]),
        max(_LEAST_TURN, acceleration),
        _slew_radps(parameters["ATC_SLEW_YAW"]),
    )


def _slew_radps(slew: float) -> float:
    return max(_LEAST_TURN, math.radians(0.01 * slew))


def arrived(stop: Stop, condition: Condition, parameters: Mapping[str, float]) -> bool:
    """Whether the vehicle is within WPNAV_RADIUS of the place."""
    north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
    off_m = math.hypot(abs(complex(north_m, east_m) - stop.place_m), down_m - stop.down_m)
    return off_m <= 0.01 * parameters["WPNAV_RADIUS"]


def hold_here(glide: Glide, parameters: Mapping[str, float]) -> Trip:
    """Come to rest and stay."""
    place_m, down_m = stopping_point(glide, acceleration_of(parameters, "WPNAV_ACCEL"))
    return Trip((Stop(place_m, down_m),), glide)


def climb(glide: Glide, down_m: float) -> Trip:
    """Straight up to that height."""
    return Trip((Stop(glide.position_m, down_m),), glide)


def land_here(glide: Glide, home: Home | None, parameters: Mapping[str, float]) -> Trip:
    """Come to rest over the ground and go down. Home's height stands for the ground's."""
    place_m, _ = stopping_point(glide, acceleration_of(parameters, "WPNAV_ACCEL"))
    return Trip((Stop(place_m, math.inf),), glide, _ground_m(home))


def fly_home(glide: Glide, home: Home | None, parameters: Mapping[str, float]) -> Trip:
    """Up to RTL_ALT inside RTL_CONE_SLOPE, home, wait there with the heading that it was armed with, down.

    Source: ArduPilot 4.6, mode_rtl.cpp, compute_return_target. RTL_ALT_FINAL 0 lands.
    """
    if home is None:
        return land_here(glide, home, parameters)
    north_m, east_m, home_down_m = home.position_ned_m.tolist()
    home_m = complex(north_m, east_m)
    place_m, down_m = stopping_point(glide, acceleration_of(parameters, "WPNAV_ACCEL"))
    here_m = home_down_m - down_m
    height_m = max(here_m + max(0.0, 0.01 * parameters["RTL_CLIMB_MIN"]), 0.01 * parameters["RTL_ALT"])
    slope = parameters["RTL_CONE_SLOPE"]
    if slope > 0.0:
        least_m = max(0.5, here_m + max(0.0, 0.01 * parameters["RTL_CLIMB_MIN"]))
        height_m = max(min(height_m, slope * abs(home_m - place_m)), least_m)
    high_m = home_down_m - height_m
    final_m = 0.01 * parameters["RTL_ALT_FINAL"]
    last = Stop(home_m, home_down_m - final_m if final_m > 0.0 else math.inf)
    wait_s = 1e-3 * parameters["RTL_LOIT_TIME"]
    stops = (Stop(place_m, high_m), Stop(home_m, high_m, to_yaw(home.q_ned_frd), wait_s), last)
    return Trip(stops, glide, _ground_m(home))


def _ground_m(home: Home | None) -> float:
    return math.nan if home is None else float(home.position_ned_m[2])


def _landing_mps(height_m: float, parameters: Mapping[str, float]) -> float:
    """WPNAV_SPEED_DN (or LAND_SPEED_HIGH) down to LAND_ALT_LOW, from there LAND_SPEED."""
    slow_mps = 0.01 * parameters["LAND_SPEED"]
    fast_mps = 0.01 * (parameters["LAND_SPEED_HIGH"] or parameters["WPNAV_SPEED_DN"])
    return fast_mps if height_m > 0.01 * parameters["LAND_ALT_LOW"] else slow_mps


def _or(value: float, otherwise: float) -> float:
    return value if value > 0.0 else otherwise
