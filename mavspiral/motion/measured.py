"""How much slower a law must be to keep its limits: measured on the curve itself, between its samples too.

A time law is found on rows of u, and what lies between two rows is not what a cubic through them says: where one piece
of a spline ends and the next begins, jerk and yaw acceleration have a kink, and kinks are where they are greatest. So
the law found is measured on the true curve at each of its knots. A peak between two samples is higher than they
are by no more than what the values change by from one to the next, there or beside it; where that may be more than the
greatest seen, it is looked at more finely.
"""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
from numba import njit

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
        """The factors where the law is u, u̇, ü (M,), with u⃛ as it is before and after, `(2, M)`."""
        way, yaw, tilt = path.jet(u), gaze.jet(u), pitch.jet(u)
        ratio: FloatArray = _asked(way, yaw, u1, u2, before, after, bounds)
        if tilt[1].any():
            np.maximum(ratio, np.abs(tilt[1] * u1) / GIMBAL_RADPS, out=ratio)
        if sight is not None:
            passing_mps = u1 * sight.passing(way[1], yaw[:2], tilt[:2])
            np.maximum(ratio, passing_mps / sight.speed_mps, out=ratio)
        return ratio

    jerks = np.diff(law.phase_acceleration_radps2) / law.step_s
    beside = np.concatenate([jerks[:1], jerks, jerks[-1:]])
    ratio = look(law.phase_rad, law.phase_rate_radps, law.phase_acceleration_radps2, beside[:-1], beside[1:])
    values = np.stack([ratio[1, :-1], ratio[0, 1:]])  # a row for each sample of a span
    own = np.abs(values[1] - values[0])
    change = own.copy()
    np.maximum(change[1:], own[:-1], out=change[1:])
    np.maximum(change[:-1], own[1:], out=change[:-1])
    begin_s, width_s = law.knots_s[:-1], law.step_s
    worst = float(values.max())
    for _ in range(LOOKS):
        chosen = values.max(axis=0) + change > worst * ROOM
        if not chosen.any():
            break
        begin_s, jerks = begin_s[chosen], jerks[chosen]
        t_s = begin_s[:, None] + width_s * np.linspace(0.0, 1.0, FINER + 1)
        jerk = np.repeat(jerks, FINER + 1)
        u, u1, u2, _ = law.derivatives(t_s.ravel())
        found = look(u, u1, u2, jerk, jerk)[0].reshape(t_s.shape)
        worst = max(worst, float(found.max()))
        # Each half of the steps is a span of its own, of three samples.
        width_s *= 2.0 / FINER
        begin_s, jerks = t_s[:, :-1:2].ravel(), np.repeat(jerks, FINER // 2)
        values = np.stack([found[:, :-1:2].ravel(), found[:, 1::2].ravel(), found[:, 2::2].ravel()])
        change = np.abs(np.diff(values, axis=0)).max(axis=0)
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
    """How many times slower each place must be passed, with either u⃛, `(2, M)`; `limits` has the order of `Limits`."""
    # A division takes as long as a dozen products, a root longer: what is compared are squares, and most places need one root.
    per_speed, per_climb, per_descent, per_acceleration, per_jerk, per_yaw_rate, per_bend = 1.0 / limits
    out = np.empty((2, u1.size))
    for i in range(u1.size):
        v, a = u1[i], u2[i]
        velocity2 = acceleration2 = jerk2_before = jerk2_after = 0.0
        for axis in range(3):
            p1, p2, p3 = way[1, i, axis], way[2, i, axis], way[3, i, axis]
            velocity2 += (p1 * v) ** 2
            acceleration2 += (p2 * v * v + p1 * a) ** 2
            drift = p3 * v * v * v + 3.0 * p2 * v * a
            jerk2_before += (drift + p1 * before[i]) ** 2
            jerk2_after += (drift + p1 * after[i]) ** 2
        rise = way[1, i, 2] * v
        first = max(rise * per_climb, -rise * per_descent, abs(yaw[1, i] * v) * per_yaw_rate)
        first2 = max(velocity2 * (per_speed * per_speed), first * first)
        bend = abs(yaw[2, i] * v * v + yaw[1, i] * a) * per_bend
        ratio4 = max(first2 * first2, acceleration2 * (per_acceleration * per_acceleration), bend * bend)
        ratio = np.sqrt(np.sqrt(ratio4)) if ratio4 > first2 * first2 else np.sqrt(first2)
        ratio6 = ratio4 * ratio * ratio
        third2_before = jerk2_before * (per_jerk * per_jerk)
        third2_after = jerk2_after * (per_jerk * per_jerk)
        out[0, i] = third2_before ** (1.0 / 6.0) if third2_before > ratio6 else ratio
        out[1, i] = third2_after ** (1.0 / 6.0) if third2_after > ratio6 else ratio
    return out
