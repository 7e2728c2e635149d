"""Rings: the outlines of slices, with concave corners closed.

The border of a slice has a kink wherever two walls meet in a concave corner, and no drone turns on the spot.
So a ball of the corner's radius rolls along the outside of the outline (the morphological closing, worked on
the polygon): what it touches stays, and where it cannot get in, it leaves its own arc.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray, locked
from mavspiral.shape.slicing import Slice, SolidDistance

__all__ = ["Ring", "corners_closed", "iso_line", "ring"]

SPACING_M = 0.4
"""Between the points of an outline while its corners are closed; chords leave a 4 m arc by 5 mm."""
TOUCH_M = 0.03
"""How deep the ball may sink before it counts as stuck: more than the outline's noise of some millimetres."""


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A closed outline: `points_enu_m` (Q, 2), counter-clockwise, at equal arc lengths."""

    points_enu_m: FloatArray

    def __post_init__(self) -> None:
        """Copies, checks and locks the field."""
        object.__setattr__(
            self, "points_enu_m", locked(self.points_enu_m, shape=(None, 2), name="points_enu_m")
        )

    @property
    def length_m(self) -> float:
        """The way around."""
        steps = np.roll(self.points_enu_m, -1, axis=0) - self.points_enu_m
        return float(np.hypot(steps[:, 0], steps[:, 1]).sum())

    def resampled(self, count: int) -> Ring:
        """The same outline at `count` points."""
        return Ring(_resampled(self.points_enu_m, count))


def ring(
    solid: SolidDistance, cut: Slice, *, anchor_enu_m: FloatArray, corner_radius_m: float
) -> Ring | None:
    """The outer border of the slice's component around the anchor; None where the slice does not hold it."""
    border = iso_line(solid.excess_m(cut), solid.cell_m, solid.origin_enu_m, anchor_enu_m=anchor_enu_m)
    if border is None:
        return None
    return corners_closed(border, corner_radius_m)


def iso_line(
    field: NDArray[np.float32], cell_m: float, origin_enu_m: FloatArray, *, anchor_enu_m: FloatArray
) -> Ring | None:
    """The outer border of the component of `field <= 0` around the anchor; None where that is not inside.

    `field[r, c]` is the value at `origin_enu_m` + `(c, r)·cell_m`, bilinear in between, and grows outward.
    The border of the cells (Suzuki and Abe 1985) is moved along the gradient onto the line itself.
    """
    contours, _ = cv2.findContours((field <= 0.0).view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    anchor = (anchor_enu_m - origin_enu_m) / cell_m
    for contour in contours:
        if cv2.pointPolygonTest(contour, (float(anchor[0]), float(anchor[1])), False) >= 0.0:
            break
    else:
        return None
    cells = _onto_zero(contour[:, 0, :].astype(np.float64), field)
    if _area(cells) < 0.0:
        cells = cells[::-1]
    cells = _onto_zero(_resampled(cells, _count(cells, SPACING_M / cell_m)), field)
    return Ring(origin_enu_m + cells * cell_m)


def _area(points: FloatArray) -> float:
    x, y = points.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _lengths(points: FloatArray) -> FloatArray:
    """Arc length from the first point to every point and around to the first again."""
    steps = np.roll(points, -1, axis=0) - points
    return np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])


def _count(points: FloatArray, spacing_m: float) -> int:
    return max(16, int(np.ceil(_lengths(points)[-1] / spacing_m)))


def _resampled(points: FloatArray, count: int) -> FloatArray:
    lengths = _lengths(points)
    wanted = np.arange(count) * (lengths[-1] / count)
    closed = np.vstack([points, points[:1]])
    return np.stack([np.interp(wanted, lengths, closed[:, axis]) for axis in (0, 1)], axis=-1)


def corners_closed(outline: Ring, radius_m: float) -> Ring:
    """The outline after a ball of `radius_m` rolled around it: nowhere inside of what it was."""
    points = outline.points_enu_m
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    along /= np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)[:, None]
    balls = points + radius_m * np.stack([along[:, 1], -along[:, 0]], axis=-1)
    stuck = _any_closer(balls, points, radius_m - TOUCH_M)
    # At the kink itself the normal is the mean of two, and there a ball may seem to fit: one or two points
    # alone are no place to stand.
    stuck = ~_runs_of_three(~stuck)
    if not stuck.any() or stuck.all():
        return outline
    start = -int(np.argmin(stuck))
    points, balls, stuck = (
        np.roll(points, start, axis=0),
        np.roll(balls, start, axis=0),
        np.roll(stuck, start),
    )
    edges = np.flatnonzero(np.diff(stuck.astype(np.int8), append=np.int8(0)))
    pieces, at = [], 0
    for before, last in zip(edges[::2], edges[1::2], strict=True):
        after = (last + 1) % len(points)
        pieces.append(points[at : before + 1])
        pieces.append(_arc(points[before], points[after], 0.5 * (balls[before] + balls[after])))
        at = last + 1
    pieces.append(points[at:])
    whole = np.concatenate(pieces)
    return Ring(_resampled(whole, _count(whole, SPACING_M)))


def _runs_of_three(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The mask, a ring, without its runs of one or two."""
    inner = mask & np.roll(mask, 1) & np.roll(mask, -1)
    return inner | np.roll(inner, 1) | np.roll(inner, -1)


def _arc(start: FloatArray, end: FloatArray, centre: FloatArray) -> FloatArray:
    """Points of the clockwise arc about `centre` strictly between `start` and `end`."""
    a, b = complex(*(start - centre)), complex(*(end - centre))
    turn = (np.angle(a) - np.angle(b)) % (2.0 * np.pi)
    count = int(turn * abs(a) / SPACING_M)
    if turn > np.pi or count == 0:
        return np.empty((0, 2))
    t = np.arange(1, count + 1) / (count + 1)
    arc = (abs(a) + t * (abs(b) - abs(a))) * np.exp(1j * (np.angle(a) - t * turn))
    return np.stack([centre[0] + arc.real, centre[1] + arc.imag], axis=-1)


@njit(cache=True)
def _any_closer(centres: FloatArray, points: FloatArray, distance: float) -> NDArray[np.bool_]:
    """Which of the centres have one of the points, a closed polygon, closer than the distance."""
    out = np.zeros(centres.shape[0], dtype=np.bool_)
    longest = 1e-12
    for j in range(points.shape[0]):
        longest = max(longest, np.hypot(points[j, 0] - points[j - 1, 0], points[j, 1] - points[j - 1, 1]))
    for i in range(centres.shape[0]):
        j = 0
        while j < points.shape[0]:
            d = np.sqrt((centres[i, 0] - points[j, 0]) ** 2 + (centres[i, 1] - points[j, 1]) ** 2)
            if d < distance:
                out[i] = True
                break
            # So many points on, none can be closer.
            j += max(1, int((d - distance) / longest))
    return out


@njit(cache=True)
def _onto_zero(points: FloatArray, field: NDArray[np.float32]) -> FloatArray:
    """Points `(M, 2)` in cells, moved onto the zero of a bilinear field by Newton's steps, a cell at most."""
    out = np.empty_like(points)
    rows, cols = field.shape
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        for _ in range(4):
            c = min(max(int(x), 0), cols - 2)
            r = min(max(int(y), 0), rows - 2)
            s, t = x - c, y - r
            sw, se, nw, ne = field[r, c], field[r, c + 1], field[r + 1, c], field[r + 1, c + 1]
            value = (1.0 - t) * (sw + s * (se - sw)) + t * (nw + s * (ne - nw))
            gx = (1.0 - t) * (se - sw) + t * (ne - nw)
            gy = (1.0 - s) * (nw - sw) + s * (ne - se)
            slope = np.sqrt(gx * gx + gy * gy)
            if slope == 0.0 or abs(value) < 1e-4 * slope:
                break
            step = min(max(-value / slope, -1.0), 1.0)
            x += step * gx / slope
            y += step * gy / slope
        out[i, 0] = x
        out[i, 1] = y
    return out
