"""Legs that are not straight: ArduPilot's splines, and circles.

Source: ArduPilot 4.6, SplineCurve.cpp and AC_WPNav.cpp (set_spline_destination): a cubic Hermite curve whose end vectors are shortened
together where they are longer than four times the chord. Simpler: its speed along the curve has no limit in jerk.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from sitl.autopilot.scurve import Leg, Motion
from sitl.signals import FloatArray

__all__ = ["CircleLeg", "SplineLeg", "spline_between"]

_SAMPLES = 200
_LEAST_MPS = 1e-3
_SHORT = 4.0


@dataclass(frozen=True, eq=False)
class SplineLeg:
    """A cubic `coefficients_m` (4, 3) of u in 0…1, NED, and when each sample of it is passed how fast.

    `exit_m` is the vector at its end that the next spline begins with, `entry_mps` how fast it may be entered.
    """

    coefficients_m: FloatArray
    exit_m: FloatArray
    entry_mps: float
    end_mps: float
    way_m: FloatArray
    speed_mps: FloatArray
    time_s: FloatArray

    @property
    def duration_s(self) -> float:
        """From its begin to its end."""
        return float(self.time_s[-1])

    def motion(self, t_s: float) -> Motion:
        """Where in space, after `t_s`."""
        i = int(np.clip(np.searchsorted(self.time_s, t_s, side="right") - 1, 0, _SAMPLES - 1))
        dt = min(max(t_s, 0.0), self.duration_s) - float(self.time_s[i])
        step_m = float(self.way_m[i + 1] - self.way_m[i])
        begin_mps, end_mps = float(self.speed_mps[i]), float(self.speed_mps[i + 1])
        push_mps2 = (end_mps**2 - begin_mps**2) / (2.0 * step_m) if step_m > 0.0 else 0.0
        speed_mps = begin_mps + push_mps2 * dt
        share = (begin_mps + 0.5 * push_mps2 * dt) * dt / step_m if step_m > 0.0 else 0.0
        place, first, second = _at(self.coefficients_m, (i + min(max(share, 0.0), 1.0)) / _SAMPLES)
        length = float(np.sqrt(first @ first)) or 1.0
        ahead = first / length
        bend = (second - (second @ ahead) * ahead) / length**2
        velocity, acceleration = ahead * speed_mps, ahead * push_mps2 + bend * speed_mps**2
        return Motion(
            complex(place[0], place[1]),
            complex(velocity[0], velocity[1]),
            complex(acceleration[0], acceleration[1]),
            float(place[2]),
            float(velocity[2]),
            float(acceleration[2]),
        )


def spline_between(
    begin_ned_m: FloatArray,
    end_ned_m: FloatArray,
    vectors_m: tuple[FloatArray, FloatArray],
    speeds_mps: tuple[float, float, float],
    accelerations_mps2: tuple[float, float],
    ends_mps: tuple[float, float],
) -> SplineLeg | None:
    """The spline with these vectors at its ends; None where it has no length.

    `speeds_mps` are level, up and down, `accelerations_mps2` level and vertical, `ends_mps` at begin and end.
    """
    chord = end_ned_m - begin_ned_m
    if not float(chord @ chord) > 1e-6:
        return None
    long_m = sum(float(np.sqrt(vector @ vector)) for vector in vectors_m)
    scale = min(1.0, _SHORT * float(np.sqrt(chord @ chord)) / long_m) if long_m > 0.0 else 1.0
    first, last = vectors_m[0] * scale, vectors_m[1] * scale
    coefficients = np.stack(
        (begin_ned_m, first, 3.0 * chord - 2.0 * first - last, first + last - 2.0 * chord)
    )
    u = np.linspace(0.0, 1.0, _SAMPLES + 1)[:, None]
    places, slopes = _at(coefficients, u)[0], _at(coefficients, u)[1]
    way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    limit, push = _limits(slopes, _at(coefficients, u)[2], speeds_mps, accelerations_mps2)
    steps = np.diff(way)
    limit[-1] = min(float(limit[-1]), max(ends_mps[1], 0.0))
    for i in range(_SAMPLES - 1, -1, -1):
        limit[i] = min(limit[i], np.sqrt(limit[i + 1] ** 2 + 2.0 * push[i] * steps[i]))
    entry, limit[0] = float(limit[0]), min(float(limit[0]), max(ends_mps[0], 0.0))
    for i in range(_SAMPLES):
        limit[i + 1] = min(limit[i + 1], np.sqrt(limit[i] ** 2 + 2.0 * push[i] * steps[i]))
    seconds = steps / np.maximum(0.5 * (limit[1:] + limit[:-1]), _LEAST_MPS)
    time = np.concatenate(([0.0], np.cumsum(seconds)))
    return SplineLeg(coefficients, vectors_m[1], entry, float(limit[-1]), way, limit, time)


def _at(coefficients: FloatArray, u: float | FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Place, first and second derivative by u."""
    c0, c1, c2, c3 = coefficients
    return c0 + (c1 + (c2 + c3 * u) * u) * u, c1 + (2.0 * c2 + 3.0 * c3 * u) * u, 2.0 * c2 + 6.0 * c3 * u


def _limits(
    slopes: FloatArray,
    bends: FloatArray,
    speeds_mps: tuple[float, float, float],
    accelerations_mps2: tuple[float, float],
) -> tuple[FloatArray, FloatArray]:
    """Speed and acceleration that are allowed along each sample: by direction, and by what the bend needs across."""
    length = np.maximum(np.linalg.norm(slopes, axis=1), 1e-6)
    ahead = slopes / length[:, None]
    level, down = np.maximum(np.hypot(ahead[:, 0], ahead[:, 1]), 1e-9), ahead[:, 2]
    steep = np.maximum(np.abs(down), 1e-9)
    upright = np.where(down > 0.0, speeds_mps[2], speeds_mps[1])
    limit = np.minimum(speeds_mps[0] / level, upright / steep)
    across = bends - np.sum(bends * ahead, axis=1)[:, None] * ahead
    curvature = np.maximum(np.linalg.norm(across, axis=1) / length**2, 1e-9)
    push = np.minimum(accelerations_mps2[0] / level, accelerations_mps2[1] / steep)
    return np.minimum(limit, np.sqrt(accelerations_mps2[0] / curvature)), push


@dataclass(frozen=True)
class CircleLeg:
    """Round a centre, from the direction `begin_rad` on; `arc` is the law along it, `turn` 1 clockwise, -1 the other way."""

    centre_m: complex
    down_m: float
    radius_m: float
    begin_rad: float
    turn: int
    arc: Leg
    end_mps: float = 0.0

    @property
    def duration_s(self) -> float:
        """From rest to rest."""
        return self.arc.duration_s

    def motion(self, t_s: float) -> Motion:
        """Where in space, after `t_s`."""
        way, speed, push = self.arc.along(t_s)
        outwards = cmath.rect(1.0, self.begin_rad + self.turn * way / self.radius_m)
        ahead = 1j * self.turn * outwards
        return Motion(
            self.centre_m + self.radius_m * outwards,
            ahead * speed,
            ahead * push - outwards * speed**2 / self.radius_m,
            self.down_m,
            0.0,
            0.0,
        )
