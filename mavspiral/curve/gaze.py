"""Where the nose points along a path: a smooth, unwrapped yaw.

On a spiral the camera looks along the inward normal of the plan curve, a quarter turn to the left of the way.
The curve keeps its distance from the nearest wall, so its normal points there; but unlike the direction to
the nearest wall it never jumps where two walls are equally near. The yaw is averaged along the arc, then a
cubic B-spline, C².
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray, locked
from mavspiral.curve import Differentiable, Path

__all__ = ["GIMBAL_RADPS", "YawSpline", "box_average", "inward_gaze"]

GIMBAL_RADPS = math.radians(30.0)
"""What every gimbal in use follows; they are made for 90°/s and more."""

SAMPLES_PER_TURN = 256


@dataclass(frozen=True, slots=True, eq=False)
class YawSpline(Differentiable):
    """Yaw as a uniform cubic B-spline of the phase: `gaze(u_rad, order)`.

    Knot `i` of `yaw_enu_rad` (M,) lies at phase `(i − 1)·knot_rad`, so M knots serve up to `(M −
    3)·knot_rad`.
    """

    yaw_enu_rad: FloatArray
    knot_rad: float

    def __post_init__(self) -> None:
        """Copies, checks and locks the knots."""
        object.__setattr__(self, "yaw_enu_rad", locked(self.yaw_enu_rad, shape=(None,), name="yaw_enu_rad"))
        if len(self.yaw_enu_rad) < 4 or not self.knot_rad > 0.0:
            raise ValueError(f"{len(self.yaw_enu_rad)} knots {self.knot_rad} apart, wanted 4 or more, apart")

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The yaw and its two derivatives, `(3, …)`."""
        u = np.asarray(u_rad, dtype=np.float64)
        jet: FloatArray = _spline(u.ravel(), self.yaw_enu_rad, self.knot_rad)
        return jet.reshape(3, *u.shape)


@njit(cache=True)
def _spline(u: FloatArray, knots: FloatArray, knot_rad: float) -> FloatArray:
    """A uniform cubic B-spline and two derivatives at `u` (M,), `(3, M)`."""
    out = np.empty((3, u.size))
    per_knot = 1.0 / knot_rad
    before, value, slope, bend, twist = -1, 0.0, 0.0, 0.0, 0.0
    for i in range(u.size):
        x = u[i] * per_knot
        k = min(max(int(x), 0), knots.size - 4)
        if k != before:
            before = k
            a, b, c, d = knots[k], knots[k + 1], knots[k + 2], knots[k + 3]
            value, slope = (a + 4.0 * b + c) * (1.0 / 6.0), 0.5 * (c - a)
            bend, twist = 0.5 * (a - 2.0 * b + c), (d - a + 3.0 * (b - c)) * (1.0 / 6.0)
        t = min(max(x - k, 0.0), 1.0)
        out[0, i] = value + t * (slope + t * (bend + t * twist))
        out[1, i] = (slope + t * (2.0 * bend + t * 3.0 * twist)) * per_knot
        out[2, i] = (2.0 * bend + t * 6.0 * twist) * (per_knot * per_knot)
    return out


def inward_gaze(path: Path, *, smoothing_m: float) -> YawSpline:
    """The gaze along the inward normal of a spiral, averaged over about `smoothing_m` of the way.

    The average is a triangle of half width `smoothing_m`. Around a corner of angle α the yaw rate then stays
    below v·α/smoothing_m and the yaw acceleration below v²·α/smoothing_m².
    """
    knot_rad = 2.0 * np.pi / SAMPLES_PER_TURN
    margin = SAMPLES_PER_TURN
    knots = int(np.ceil(path.u_end_rad / knot_rad)) + 3
    u = (np.arange(-margin, knots + margin) - 1) * knot_rad
    yaw, s = _inward(path(u, 1), knot_rad)
    for _ in range(2):
        yaw = box_average(s, yaw, smoothing_m)
    yaw = yaw[margin : margin + knots]
    return YawSpline(yaw - 2.0 * np.pi * np.round((yaw[1] - np.pi) / (2.0 * np.pi)), knot_rad)


@njit(cache=True)
def _inward(along: FloatArray, du: float) -> tuple[FloatArray, FloatArray]:
    """The yaw of the inward normal, unwrapped, at places `du` apart whose p′ are `along` (M, 3), and the way to them in plan."""
    yaw, way = np.empty(len(along)), np.empty(len(along))
    turns, pace = 0.0, 0.0
    for i in range(len(along)):
        east, north = along[i, 0], along[i, 1]
        yaw[i] = np.arctan2(north, east) + 0.5 * np.pi + turns
        before, pace = pace, np.sqrt(east * east + north * north)
        if i == 0:
            way[0] = 0.0
            continue
        back = 2.0 * np.pi * np.round((yaw[i] - yaw[i - 1]) / (2.0 * np.pi))
        turns -= back
        yaw[i] -= back
        way[i] = way[i - 1] + 0.5 * (before + pace) * du
    return yaw, way


@njit(cache=True)
def box_average(s: FloatArray, values: FloatArray, width: float) -> FloatArray:
    """The mean of `values` over `s ± width/2`, the window cut short at both ends alike."""
    last = len(s) - 1
    integral = np.zeros(len(s))
    for i in range(last):
        integral[i + 1] = integral[i] + 0.5 * (values[i] + values[i + 1]) * (s[i + 1] - s[i])
    mean = values.copy()
    low = high = 0
    for i in range(len(s)):
        half = min(0.5 * width, s[i] - s[0], s[last] - s[i])
        if half <= 1e-9:
            continue
        begin, end = s[i] - half, s[i] + half
        while low < last - 1 and s[low + 1] <= begin:
            low += 1
        while high < last - 1 and s[high + 1] < end:
            high += 1
        mean[i] = (_between(s, integral, high, end) - _between(s, integral, low, begin)) / (end - begin)
    return mean


@njit(cache=True)
def _between(s: FloatArray, values: FloatArray, k: int, at: float) -> float:
    """The value at a place between the k-th and the next."""
    value: float = values[k] + (values[k + 1] - values[k]) * ((at - s[k]) / (s[k + 1] - s[k]))
    return value
