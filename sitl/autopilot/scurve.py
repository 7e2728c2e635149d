"""Along a straight leg, mostly from rest to rest, limited in speed, acceleration and jerk, and how two legs are joined.

ArduPilot (since 4.1) flies past a waypoint by starting the next leg while the last one still brakes: the motions of
both add up. Source: ArduPilot 4.6, SCurve.cpp, advance_target_along_track. Simpler: its jerk has no ramp of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

__all__ = ["Along", "Leg", "Motion", "joins", "leg_between", "reaches_within", "stops_within"]


class Along(NamedTuple):
    """Way, speed and acceleration along a leg."""

    way_m: float
    speed_mps: float
    acceleration_mps2: float


class Motion(NamedTuple):
    """The same in space: horizontal parts as north + i·east, vertical parts down."""

    place_m: complex
    velocity_mps: complex
    acceleration_mps2: complex
    down_m: float
    down_speed_mps: float
    down_acceleration_mps2: float


@dataclass(frozen=True)
class Leg:
    """A straight leg from `begin_m`, `begin_down_m` along the unit vector (`level`, `down`).

    It begins at `begin_mps` and ends at `end_mps`, or as near to that as its length allows.
    """

    begin_m: complex
    begin_down_m: float
    level: complex
    down: float
    length_m: float
    speed_mps: float
    acceleration_mps2: float
    jerk_mps3: float
    begin_mps: float = 0.0
    end_mps: float = 0.0

    @cached_property
    def _phases(self) -> tuple[tuple[float, float], ...]:
        """(seconds, jerk) of each phase: speeding up, cruising, braking."""
        a, j, length = self.acceleration_mps2, self.jerk_mps3, self.length_m
        begin, end, v = self.begin_mps, self.end_mps, self.speed_mps
        if not begin and not end:
            if _run_up_m(v, a, j) > 0.5 * length:
                v = _speed_within(0.5 * length, a, j)
        else:
            v = _bisected(
                lambda v: _change_m(begin, v, a, j) + _change_m(v, end, a, j), length, max(begin, end), v
            )
        cruise_m = length - _change_m(begin, v, a, j) - _change_m(v, end, a, j)
        cruise_s = max(0.0, cruise_m) / v if v > 0.0 else 0.0
        return (*_change(begin, v, a, j), (cruise_s, 0.0), *_change(v, end, a, j))

    @cached_property
    def duration_s(self) -> float:
        """From its begin to its end."""
        return sum(seconds for seconds, _ in self._phases)

    @cached_property
    def speeding_s(self) -> float:
        """Until it cruises; so long before its end it brakes."""
        return sum(seconds for seconds, _ in self._phases[:3])

    def along(self, t_s: float) -> Along:
        """Where on the leg, after `t_s`."""
        way, speed, acceleration = 0.0, self.begin_mps, 0.0
        left_s = min(max(t_s, 0.0), self.duration_s)
        for seconds, jerk in self._phases:
            dt = min(seconds, left_s)
            way += (speed + (0.5 * acceleration + jerk * dt / 6.0) * dt) * dt
            speed += (acceleration + 0.5 * jerk * dt) * dt
            acceleration += jerk * dt
            left_s -= dt
            if left_s <= 0.0:
                break
        return Along(way, speed, acceleration)

    def motion(self, t_s: float) -> Motion:
        """Where in space, after `t_s`."""
        way, speed, acceleration = self.along(t_s)
        return Motion(
            self.begin_m + self.level * way,
            self.level * speed,
            self.level * acceleration,
            self.begin_down_m + self.down * way,
            self.down * speed,
            self.down * acceleration,
        )


def stops_within(leg: Leg) -> float:
    """How fast the leg may be entered so that it can end at rest."""
    a, j = leg.acceleration_mps2, leg.jerk_mps3
    return _bisected(lambda v: _change_m(v, 0.0, a, j), leg.length_m, 0.0, leg.speed_mps)


def reaches_within(leg: Leg, begin_mps: float, end_mps: float) -> float:
    """The speed nearest to `end_mps` that the leg can end at, when it begins at `begin_mps`."""
    a, j = leg.acceleration_mps2, leg.jerk_mps3
    if end_mps <= begin_mps:
        return end_mps
    return _bisected(lambda v: _change_m(begin_mps, v, a, j), leg.length_m, begin_mps, end_mps)


def leg_between(
    begin_m: complex,
    begin_down_m: float,
    end_m: complex,
    end_down_m: float,
    speeds_mps: tuple[float, float, float],
    accelerations_mps2: tuple[float, float],
    jerk_mps3: float,
) -> Leg:
    """The leg between two places; `speeds_mps` are level, up and down, `accelerations_mps2` level and vertical."""
    across, sink = end_m - begin_m, end_down_m - begin_down_m
    length = math.hypot(abs(across), sink)
    level_mps, up_mps, down_mps = speeds_mps
    if length < 1e-6:
        return Leg(begin_m, begin_down_m, 0j, 0.0, 0.0, level_mps, accelerations_mps2[0], jerk_mps3)
    level, down = across / length, sink / length
    flat, steep = max(abs(level), 1e-9), max(abs(down), 1e-9)
    speed = min(level_mps / flat, (down_mps if down > 0.0 else up_mps) / steep)
    acceleration = min(accelerations_mps2[0] / flat, accelerations_mps2[1] / steep)
    return Leg(begin_m, begin_down_m, level, down, length, speed, acceleration, jerk_mps3)


def joins(leg: Leg, t_s: float, after: Leg, radius_m: float, corner_mps2: float) -> bool:
    """Whether the next leg may start now: it would pass within the radius, and turn no harder than allowed.

    Half way through what is left, both motions are looked at together.
    """
    left_s = leg.duration_s - t_s
    if t_s < leg.duration_s - after.speeding_s or leg.along(t_s).way_m < 0.5 * leg.length_m:
        return False
    if left_s >= 0.5 * after.duration_s:
        return False
    first, second = leg.motion(t_s + 0.5 * left_s), after.motion(0.5 * left_s)
    off = first.place_m - after.begin_m + second.place_m - after.begin_m
    off_down = first.down_m - after.begin_down_m + second.down_m - after.begin_down_m
    slowest = min(leg.along(t_s).speed_mps, max(after.speed_mps, 1e-3))
    return (
        math.hypot(abs(off), off_down) < radius_m
        and abs(first.velocity_mps + second.velocity_mps) <= slowest + 1e-6
        and abs(first.acceleration_mps2 + second.acceleration_mps2) < corner_mps2
    )


def _change(before: float, after: float, a: float, j: float) -> tuple[tuple[float, float], ...]:
    """(seconds, jerk) of the three phases from one speed to another."""
    difference = abs(after - before)
    peak = min(a, math.sqrt(difference * j))
    ramp_s = peak / j
    steady_s = max(0.0, difference / peak - ramp_s) if peak > 0.0 else 0.0
    jerk = math.copysign(j, after - before)
    return (ramp_s, jerk), (steady_s, 0.0), (ramp_s, -jerk)


def _change_m(before: float, after: float, a: float, j: float) -> float:
    """The way that takes: the mean of both speeds, times how long it takes."""
    return 0.5 * (before + after) * sum(seconds for seconds, _ in _change(before, after, a, j))


def _bisected(way_m: Callable[[float], float], length_m: float, low: float, high: float) -> float:
    """The greatest speed between these two whose way fits into the length; the lower one when none does."""
    if way_m(high) <= length_m:
        return high
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if way_m(middle) <= length_m else (low, middle)
    return low


def _run_up_m(v: float, a: float, j: float) -> float:
    """The way from rest to the speed `v`: half of it, times how long it takes."""
    peak = min(a, math.sqrt(v * j))
    return 0.5 * v * (v / peak + peak / j) if peak > 0.0 else 0.0


def _speed_within(way_m: float, a: float, j: float) -> float:
    """The speed that is reached on that way."""
    v = math.cbrt(way_m * way_m * j)
    if v * j > a * a:
        v = 0.5 * (-a * a / j + math.sqrt((a * a / j) ** 2 + 8.0 * a * way_m))
    return v
