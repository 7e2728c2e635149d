"""Where the vehicle is meant to be at every moment: legs in a row, each a curve, a gaze and a time law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.frames import wrap_rad
from mavspiral.motion import kernels
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.sight import Sight
from mavspiral.motion.turn import LEVEL, Gaze

__all__ = ["Leg", "Trajectory", "TrajectoryState", "belongs"]

JOIN_TOLERANCE_M = 1e-6
JOIN_TOLERANCE_RAD = 1e-6
BLOCK = 8192
"""So many times are worked out at once: what lies between then stays in the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """One curve, flown from rest to rest. `gimbal_pitch` is the camera's, up is positive, as the gaze is the nose's.

    `sight` is what pictures are taken of; None on the way.
    """

    name: str
    path: Path
    gaze: Gaze
    law: TimeLaw
    gimbal_pitch: Gaze = LEVEL
    sight: Sight | None = None


@dataclass(frozen=True, slots=True, eq=False)
class TrajectoryState:
    """The motion at the times `t_s`; vectors have one more axis of length 3. Yaw is unwrapped."""

    t_s: FloatArray
    position_enu_m: FloatArray
    velocity_enu_mps: FloatArray
    acceleration_enu_mps2: FloatArray
    jerk_enu_mps3: FloatArray
    yaw_enu_rad: FloatArray
    yaw_rate_enu_radps: FloatArray
    yaw_acceleration_enu_radps2: FloatArray
    gimbal_pitch_rad: FloatArray

    def __post_init__(self) -> None:
        """Locks the fields."""
        for column in fields(self):
            getattr(self, column.name).setflags(write=False)


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Legs in a row as one motion over [0, duration_s]. It has no cursor: ask it for any time.

    Raises:
        ValueError: no legs, or two legs do not join (the place and the gap are named).
    """

    legs: tuple[Leg, ...]
    _begin_s: FloatArray = field(init=False, repr=False)
    _turns_rad: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Checks that the legs join."""
        if not self.legs:
            raise ValueError("a trajectory needs at least one leg")
        begin_s = np.cumsum([0.0, *(leg.law.duration_s for leg in self.legs)])
        turns_rad = np.zeros(len(self.legs))
        for i, (before, after) in enumerate(pairwise(self.legs)):
            turns_rad[i + 1] = turns_rad[i] + _join(before, after)
        begin_s.setflags(write=False)
        turns_rad.setflags(write=False)
        object.__setattr__(self, "_begin_s", begin_s)
        object.__setattr__(self, "_turns_rad", turns_rad)

    @property
    def duration_s(self) -> float:
        """Time from the first rest to the last."""
        return float(self._begin_s[-1])

    def span_s(self, name: str) -> tuple[float, float]:
        """When the first leg that belongs to `name` begins and the last one ends.

        Raises:
            KeyError: no leg is called so.
        """
        spans = self.spans_s(name)
        return spans[0][0], spans[-1][1]

    def spans_s(self, name: str) -> tuple[tuple[float, float], ...]:
        """When each leg that belongs to `name` begins and ends.

        Raises:
            KeyError: no leg is called so.
        """
        ends_s = zip(self.legs, self._begin_s, self._begin_s[1:], strict=False)
        spans = tuple((float(begin), float(end)) for leg, begin, end in ends_s if belongs(leg.name, name))
        if not spans:
            raise KeyError(f"no leg is called {name!r}; there are {[leg.name for leg in self.legs]}")
        return spans

    def on(self, name: str, t_s: FloatArray) -> NDArray[np.bool_]:
        """At which of the times it is on a leg that belongs to `name`, the ends among them."""
        mask = np.zeros(np.shape(t_s), dtype=np.bool_)
        for begin_s, end_s in self.spans_s(name):
            mask |= (t_s >= begin_s) & (t_s <= end_s)
        return mask

    def __call__(self, t_s: ArrayLike) -> TrajectoryState:
        """The motion at `t_s`, of any shape; t is clipped to [0, duration]."""
        t = np.clip(np.asarray(t_s, dtype=np.float64), 0.0, self.duration_s)
        flat = t.ravel()
        vectors = np.empty((4, flat.size, 3))
        yaws = np.empty((3, flat.size))
        pitch = np.empty(flat.size)
        for i, here in self._rows(flat):
            vectors[:, here], yaws[:, here], pitch[here] = _motion(
                self.legs[i], flat[here] - self._begin_s[i]
            )
            yaws[0, here] += self._turns_rad[i]
        position, velocity, acceleration, jerk = vectors.reshape(4, *t.shape, 3)
        yaw, yaw_rate, yaw_acceleration = yaws.reshape(3, *t.shape)
        return TrajectoryState(
            t_s=t,
            position_enu_m=position,
            velocity_enu_mps=velocity,
            acceleration_enu_mps2=acceleration,
            jerk_enu_mps3=jerk,
            yaw_enu_rad=yaw,
            yaw_rate_enu_radps=yaw_rate,
            yaw_acceleration_enu_radps2=yaw_acceleration,
            gimbal_pitch_rad=pitch.reshape(t.shape),
        )

    def stretches(self, t_s: FloatArray) -> list[tuple[Leg, FloatArray, float]]:
        """Rising times, a leg's at a time and not too many: the leg, the times, and when the leg begins."""
        return [(self.legs[i], t_s[here], float(self._begin_s[i])) for i, here in self._in_order(t_s)]

    def _rows(self, t_s: FloatArray) -> Sequence[tuple[int, slice | NDArray[np.int64]]]:
        """Each leg that is flown at some of the times, and at which: slices where they are in order, far cheaper."""
        if (t_s[1:] >= t_s[:-1]).all():
            return self._in_order(t_s)
        which = np.searchsorted(self._begin_s[1:-1], t_s, side="right")
        return [(int(i), np.flatnonzero(which == i)) for i in np.unique(which)]

    def _in_order(self, t_s: FloatArray) -> list[tuple[int, slice]]:
        edges = [0, *np.searchsorted(t_s, self._begin_s[1:-1]), len(t_s)]
        return [
            (i, slice(k, min(k + BLOCK, b)))
            for i, (a, b) in enumerate(pairwise(edges))
            for k in range(a, b, BLOCK)
        ]

    def grid_s(self, dt_s: float) -> FloatArray:
        """The times every `dt_s` from 0 on, and at last the very end."""
        steps = int(np.floor(self.duration_s / dt_s * (1 - 1e-12)))
        t_s = np.arange(steps + 2, dtype=np.float64)
        t_s *= dt_s
        t_s[-1] = self.duration_s
        return t_s

    def sampled(self, dt_s: float) -> TrajectoryState:
        """The motion on the grid of times `dt_s` apart."""
        return self(self.grid_s(dt_s))


def belongs(leg: str, name: str) -> bool:
    """Whether a leg is called `name` or is one of several of that name: "inspection-tower-1" is an inspection."""
    return leg == name or leg.startswith(f"{name}-")


def _motion(leg: Leg, t_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position and three derivatives, `(4, n, 3)`; yaw and two derivatives, `(3, n)`; pitch: the chain rule."""
    u, u1, u2, u3 = leg.law.derivatives(t_s)
    way, yaw = leg.path.jet(u), leg.gaze.jet(u)
    kernels.over_time(way, yaw, u1, u2, u3)
    return way, yaw, leg.gimbal_pitch(u)


def _join(before: Leg, after: Leg) -> float:
    """The whole turns that `after` must be given to go on where `before` ends."""
    u_end = before.path.u_end_rad
    gap_m = float(np.linalg.norm(after.path(0.0) - before.path(u_end)))
    if gap_m > JOIN_TOLERANCE_M:
        raise ValueError(f"leg {after.name!r} begins {gap_m:.3g} m from where {before.name!r} ends")
    jump_rad = float(before.gaze(u_end)) - float(after.gaze(0.0))
    if abs(gap_rad := float(wrap_rad(jump_rad))) > JOIN_TOLERANCE_RAD:
        raise ValueError(
            f"leg {after.name!r} begins {gap_rad:.3g} rad of yaw from where {before.name!r} ends"
        )
    return jump_rad - gap_rad
