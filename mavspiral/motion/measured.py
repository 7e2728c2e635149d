"""How much slower a law must be to keep its limits: measured on the curve itself, between its samples too.

A time law is found on rows of u, and what lies between two rows is not what a cubic through them says: where one piece
of a spline ends and the next begins, jerk and yaw acceleration have a kink, and kinks are where they are greatest. So
the law found is measured on the true curve at each of its knots. A peak between two samples is higher than they
are by no more than what the values change by from one to the next, there or beside it; where that may be more than the
limit allows at the pace of the worst seen, it is looked at more finely.
"""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.curve.gaze import GIMBAL_RADPS
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.limits import Limits
from mavspiral.motion.sight import Sight
from mavspiral.motion.turn import Gaze

__all__ = ["slower"]

FINER = 8
"""So many steps in a span that is looked at again."""
LOOKS = 5
"""So often is a span looked at again."""
ROOM = 1 + 5e-6
"""A peak that may be less than this above the greatest is left alone."""


def slower(path: Path, gaze: Gaze, law: TimeLaw, limits: Limits, pitch: Gaze, sight: Sight | None) -> float:
    """The factor of time that `law` must be stretched by to keep every limit; less than 1 if there is room.

    The limits' own, `sight`'s if there is one, and the gimbal's.
    """
    bounds = np.array(astuple(limits))

    def look(
        u: FloatArray, u1: FloatArray, u2: FloatArray, before: FloatArray, after: FloatArray
    ) -> FloatArray:
        """What is asked for where the law is u, u̇, ü (M,), with u⃛ as it is before and after, `(9, M)`."""
        way, yaw, tilt = path.jet(u), gaze.jet(u), pitch.jet(u)
        asked: FloatArray = _asked(way, yaw, u1, u2, before, after, bounds)
        if tilt[1].any():
            np.maximum(asked[0], np.abs(tilt[1] * u1) / GIMBAL_RADPS, out=asked[0])
        if sight is not None:
            passing_mps = u1 * sight.passing(way[1], yaw[:2], tilt[:2])
            np.maximum(asked[0], passing_mps / sight.speed_mps, out=asked[0])
        return asked

    jerks = np.diff(law.phase_acceleration_radps2) / law.step_s
    beside = np.concatenate([jerks[:1], jerks, jerks[-1:]])
    asked = look(law.phase_rad, law.phase_rate_radps, law.phase_acceleration_radps2, beside[:-1], beside[1:])
    worst: float
    worst, chosen = _peaks(asked[:, None], 0.0)
    begin_s, jerks, width_s = law.knots_s[None, :-1], jerks[None], law.step_s
    for _ in range(LOOKS):
        if not chosen.any():
            break
        begin_s, jerks = begin_s[chosen][:, None], jerks[chosen][:, None]
        t_s = begin_s + width_s * np.linspace(0.0, 1.0, FINER + 1)
        jerk = np.repeat(jerks, FINER + 1)
        u, u1, u2, _ = law.derivatives(t_s.ravel())
        worst, chosen = _peaks(look(u, u1, u2, jerk, jerk).reshape(-1, *t_s.shape), worst)
        begin_s, jerks, width_s = t_s[:, :-1], np.repeat(jerks, FINER, axis=1), width_s / FINER
    return worst


@njit(cache=True)
def _asked(
    way: FloatArray,
    yaw: FloatArray,
    u1: FloatArray,
    u2: FloatArray,
    before: FloatArray,
    after: FloatArray,
    limits: FloatArray,
) -> FloatArray:
    """Of each limit's share what each place asks for, `(9, M)`; `limits` has the order of `Limits`.

    The most of what goes with 1/time (speed, climb, descent, yaw rate); acceleration; yaw acceleration; the three components of
    jerk with u⃛ as it is before, and after.
    """
    per_speed, per_climb, per_descent, per_acceleration, per_jerk, per_yaw_rate, per_bend = 1.0 / limits
    out = np.empty((9, u1.size))
    for i in range(u1.size):
        v, a = u1[i], u2[i]
        velocity2 = acceleration2 = 0.0
        for axis in range(3):
            p1, p2, p3 = way[1, i, axis], way[2, i, axis], way[3, i, axis]
            velocity2 += (p1 * v) ** 2
            acceleration2 += (p2 * v * v + p1 * a) ** 2
            drift = p3 * v * v * v + 3.0 * p2 * v * a
            out[3 + axis, i] = (drift + p1 * before[i]) * per_jerk
            out[6 + axis, i] = (drift + p1 * after[i]) * per_jerk
        rise = way[1, i, 2] * v
        turns = max(rise * per_climb, -rise * per_descent, abs(yaw[1, i] * v) * per_yaw_rate)
        out[0, i] = max(np.sqrt(velocity2) * per_speed, turns)
        out[1, i] = np.sqrt(acceleration2) * per_acceleration
        out[2, i] = (yaw[2, i] * v * v + yaw[1, i] * a) * per_bend
    return out


@njit(cache=True)
def _peaks(asked: FloatArray, worst: float) -> tuple[float, NDArray[np.bool_]]:
    """The factor of time that the samples `(9, S, n + 1)` ask for, or `worst`; and in which spans more may be asked for, `(S, n)`.

    Each limit is looked at by itself: beneath a speed that is near its own, jerk may rise unseen.
    """
    strips, n = asked.shape[1], asked.shape[2] - 1
    most = np.zeros(4)
    for s in range(strips):
        for i in range(n + 1):
            most[0] = max(most[0], asked[0, s, i])
            most[1] = max(most[1], asked[1, s, i])
            most[2] = max(most[2], abs(asked[2, s, i]))
            for first in (3, 6):
                x, y, z = asked[first, s, i], asked[first + 1, s, i], asked[first + 2, s, i]
                most[3] = max(most[3], x * x + y * y + z * z)
    worst = max(worst, most[0], np.sqrt(max(most[1], most[2])), most[3] ** (1.0 / 6.0))
    enough = worst * ROOM
    most[0], most[1], most[2], most[3] = enough, enough**2, enough**2, enough**3
    chosen = np.zeros((strips, n), np.bool_)
    top, own = (
        np.empty((4, n)),
        np.zeros((4, n + 2)),
    )  # of each span; its changes between those beside the first and the last
    for s in range(strips):
        for i in range(n):
            for q in range(3):
                left, right = asked[q, s, i], asked[q, s, i + 1]
                top[q, i], own[q, i + 1] = max(abs(left), abs(right)), abs(right - left)
            left2 = right2 = change2 = 0.0
            for axis in range(3):
                left, right = asked[6 + axis, s, i], asked[3 + axis, s, i + 1]
                left2, right2, change2 = left2 + left**2, right2 + right**2, change2 + (right - left) ** 2
            top[3, i], own[3, i + 1] = np.sqrt(max(left2, right2)), np.sqrt(change2)
        for i in range(n):
            for q in range(4):
                change = max(own[q, i], own[q, i + 1], own[q, i + 2])
                if top[q, i] + change > most[q]:
                    chosen[s, i] = True
    return worst, chosen
