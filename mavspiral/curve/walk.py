"""The walk of an outline from one border to another inside it, when that is too far to go at once.

With the signed distances in plan `s_from` and `s_to` to both borders, negative inside, the outlines between
are

    (1 − w)·s_from + w·s_to = 0,    w from 0 to 1.

The target lies inside, `s_to ≥ s_from`, so `s_to ≥ 0` along each of them: a walk never comes closer than its
target. A long roof draws back from its far end; a court opens from its mouth. As w grows by dw, the outline
moves by dw·(s_to − s_from)/|∇|, which sets the next w.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mavspiral.arrays import FloatArray
from mavspiral.shape.contour import Ring, corners_closed, iso_line

__all__ = ["Walk", "signed_distance"]

PITCH_M = 0.5
LEAST_SHARE = 0.02
"""Of the whole walk, what one step covers at the least: a walk ends after 50 keys."""


class Walk:
    """Outlines on the way from `start` to `target`, around `anchor_enu_m`."""

    def __init__(self, start: Ring, target: Ring, anchor_enu_m: FloatArray, corner_radius_m: float) -> None:
        low, high = start.points_enu_m.min(axis=0), start.points_enu_m.max(axis=0)
        self._pitch_m = max(PITCH_M, float((high - low).max()) / 128.0)
        self._origin_enu_m = low - 2.0 * self._pitch_m
        cols, rows = (np.ceil((high - low) / self._pitch_m) + 5).astype(int)
        x, y = np.meshgrid(np.arange(cols), np.arange(rows))
        nodes = self._origin_enu_m + np.stack([x, y], axis=-1).reshape(-1, 2) * self._pitch_m
        self._from_m = signed_distance(nodes, start.points_enu_m[::2]).reshape(rows, cols)
        self._to_m = signed_distance(nodes, target.points_enu_m[::2]).reshape(rows, cols)
        self._to_m = np.maximum(self._to_m, self._from_m)
        self._anchor_enu_m = anchor_enu_m
        self._corner_radius_m = corner_radius_m
        self._target = target
        self._outline = start
        self._share = 0.0

    @property
    def arrived(self) -> bool:
        """Whether the last step led to the target."""
        return self._outline is self._target

    def step(self, step_m: float) -> Ring:
        """The next outline, about `step_m` further at the most; at the end the target itself."""
        field = (1.0 - self._share) * self._from_m + self._share * self._to_m
        cells = (self._outline.points_enu_m - self._origin_enu_m) / self._pitch_m
        speed_m = _speed(cells, field, self._to_m - self._from_m, self._pitch_m)
        self._share += max(LEAST_SHARE, step_m / max(speed_m, step_m))
        if self._share >= 1.0:
            self._outline = self._target
            return self._target
        field = (1.0 - self._share) * self._from_m + self._share * self._to_m
        outline = iso_line(
            field.astype(np.float32), self._pitch_m, self._origin_enu_m, anchor_enu_m=self._anchor_enu_m
        )
        self._outline = (
            corners_closed(outline, self._corner_radius_m) if outline is not None else self._target
        )
        return self._outline


@njit(cache=True)
def signed_distance(points: FloatArray, polygon: FloatArray) -> FloatArray:
    """Distance to a dense counter-clockwise polygon, negative inside: to the edges at its nearest corner."""
    corners = polygon.shape[0]
    out = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        px, py = points[i, 0], points[i, 1]
        best, at = np.inf, 0
        for j in range(corners):
            d = (polygon[j, 0] - px) ** 2 + (polygon[j, 1] - py) ** 2
            if d < best:
                best, at = d, j
        before, after = at - 1, (at + 1) % corners
        ax, ay = polygon[at, 0], polygon[at, 1]
        for other in (before, after):
            ex, ey = polygon[other, 0] - ax, polygon[other, 1] - ay
            t = min(max(((px - ax) * ex + (py - ay) * ey) / max(ex * ex + ey * ey, 1e-18), 0.0), 1.0)
            best = min(best, (ax + t * ex - px) ** 2 + (ay + t * ey - py) ** 2)
        tx, ty = polygon[after, 0] - polygon[before, 0], polygon[after, 1] - polygon[before, 1]
        outside = tx * (py - ay) - ty * (px - ax) < 0.0
        out[i] = np.sqrt(best) if outside else -np.sqrt(best)
    return out


@njit(cache=True)
def _speed(cells: FloatArray, field: FloatArray, gap: FloatArray, pitch: float) -> float:
    """The most of gap/|∇field| at points in cells; slopes below a fifth count as a fifth."""
    rows, cols = field.shape
    worst = 0.0
    for i in range(cells.shape[0]):
        c = min(max(int(cells[i, 0]), 0), cols - 2)
        r = min(max(int(cells[i, 1]), 0), rows - 2)
        gx = 0.5 * (field[r, c + 1] - field[r, c] + field[r + 1, c + 1] - field[r + 1, c]) / pitch
        gy = 0.5 * (field[r + 1, c] - field[r, c] + field[r + 1, c + 1] - field[r, c + 1]) / pitch
        slope = max(np.sqrt(gx * gx + gy * gy), 0.2)
        worst = max(worst, gap[r, c] / slope)
    return worst
