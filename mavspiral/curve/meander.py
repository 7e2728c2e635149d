"""A way to and fro along a façade that climbs from row to row: one quartic B-spline, C³ from end to end.

    p(u) = Σ_k b(u − k)·c_k

`c_k` are places at equal steps along the rows and the climbs between them, `b` is the uniform quartic B-spline. It
rounds the corners, and along a row it leaves an arc of radius R by no more than 5/24·step²/R.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mavspiral.arrays import FloatArray, locked
from mavspiral.curve import Differentiable
from mavspiral.curve.gaze import YawSpline, box_average
from mavspiral.curve.mixing import BASIS, DEGREE

__all__ = ["MeanderPath", "Row", "meander"]

STEP_M = 0.8
TURN_M = 2.0
"""So much higher a way comes back along a row."""
NEAR_M = 2.0
"""A row whose end is this near to where the row before ended begins there."""


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """A level way along the walls: `points_enu_m` (n, 3) with the walls to its left, and whether it closes."""

    points_enu_m: FloatArray
    yaw_enu_rad: FloatArray
    closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class MeanderPath(Differentiable):
    """The spline: `path(u_rad, order)`; one step of the phase is one place `controls_enu_m` (n, 3) further."""

    controls_enu_m: FloatArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the field."""
        object.__setattr__(
            self, "controls_enu_m", locked(self.controls_enu_m, shape=(None, 3), name="controls_enu_m")
        )
        if len(self.controls_enu_m) <= DEGREE:
            raise ValueError(f"{len(self.controls_enu_m)} places, wanted more than {DEGREE}")

    @property
    def u_end_rad(self) -> float:
        """Where it ends."""
        return float(len(self.controls_enu_m) - DEGREE)

    def jet(self, u_rad: ArrayLike) -> FloatArray:
        """The ENU position and its three derivatives, `(4, …, 3)`."""
        u = np.asarray(u_rad, dtype=np.float64)
        flat = u.ravel()
        span = np.clip(np.floor(flat).astype(np.int64), 0, len(self.controls_enu_m) - DEGREE - 1)
        powers = np.clip(flat - span, 0.0, 1.0)[:, None] ** np.arange(DEGREE + 1)
        places = self.controls_enu_m[span[:, None] + np.arange(DEGREE + 1)]
        weights = np.einsum("okp,np->onk", BASIS, powers)
        jet: FloatArray = np.einsum("onk,nkc->onc", weights, places)
        return jet.reshape(4, *u.shape, 3)


def meander(rows: Sequence[Row], *, smoothing_m: float) -> tuple[MeanderPath, YawSpline]:
    """The spline through rows from the lowest to the highest, and the gaze that the rows have, averaged.

    An open row is flown from the end where the row before has arrived to the other; where it reaches farther,
    there first and back a little higher, because no curve turns on the spot. A closed one goes all the way round.
    Between rows it climbs on the spot.
    """
    places: list[FloatArray] = []
    yaws: list[FloatArray] = []
    here: FloatArray | None = None
    for row in rows:
        index, out = _indices(row, here)
        points, yaw = row.points_enu_m[index], row.yaw_enu_rad[index]
        if out:
            points = _returned_above(points, out)
        if here is not None:
            above = np.array([*here[:2], points[0, 2]])
            places += [here[None], above[None]]
            yaws += [yaws[-1][-1:], yaws[-1][-1:]]
        places.append(points)
        yaws.append(yaw)
        here = points[-1]
    way, yaw_rad = np.concatenate(places), np.unwrap(np.concatenate(yaws))
    lengths = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(way, axis=0) ** 2).sum(axis=1)))])
    count = max(6, int(np.ceil(lengths[-1] / STEP_M)) + 1)
    s = np.linspace(0.0, lengths[-1], count)
    controls = np.stack([np.interp(s, lengths, way[:, axis]) for axis in range(3)], axis=1)
    heading = np.interp(s, lengths, yaw_rad)
    for _ in range(2):
        heading = box_average(s, heading, smoothing_m)
    first, last = controls[1] - controls[0], controls[-1] - controls[-2]
    controls = np.vstack([controls[0] - first, controls, controls[-1] + last])
    path = MeanderPath(controls)
    # The spline at u is where its places at index u + 3/2 are, the gaze's knots those at u + 1.
    knots = np.interp(np.arange(path.u_end_rad + 4) + 0.5, np.arange(count) + 1.0, heading)
    return path, YawSpline(knots, 1.0)


def _returned_above(points: FloatArray, out: int) -> FloatArray:
    """The way with all after its first `out` points raised, less and less as it comes back to where it began."""
    raised = points.copy()
    back = np.arange(len(points) - out)
    raised[out:, 2] += TURN_M * np.clip(1.0 - back / max(out, 1), 0.0, 1.0)
    return raised


def _indices(row: Row, here: FloatArray | None) -> tuple[NDArray[np.int64], int]:
    """In which order the points of a row are flown, coming from `here`, and how many of them on the way out."""
    count = len(row.points_enu_m)
    forward = np.arange(count)
    if here is None:
        return (np.append(forward, 0) if row.closed else forward), 0
    away = np.hypot(*(row.points_enu_m[:, :2] - here[:2]).T)
    nearest = int(np.argmin(away))
    if row.closed:
        return np.append(np.roll(forward, -nearest), nearest), 0
    if min(away[0], away[-1]) <= NEAR_M:
        return (forward if away[0] <= away[-1] else forward[::-1]), 0
    if nearest < count - 1 - nearest:
        return np.concatenate([forward[nearest:0:-1], forward]), nearest
    return np.concatenate([forward[nearest:-1], forward[::-1]]), count - 1 - nearest
