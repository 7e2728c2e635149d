"""The walk of an outline from one border to another inside it, when that is too far to go at once.

With the signed distances in plan `s_from` and `s_to` to both, negative inside, the outlines between are

    (1 − w)·s_from + w·s_to = 0,    w from 0 to 1.

The target lies inside, `s_to ≥ s_from`, so `s_to ≥ 0` along each of them, and so it stays when the blend is
blurred and the target added to it: a walk never comes closer than its target. A long roof draws back from its
far end; a court opens from its mouth. How far an outline moves as w grows is measured: every w is tried, and
tried shorter where that was too far.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit

from mavspiral.arrays import FloatArray, locked
from mavspiral.shape.contour import Ring, corners_closed, iso_line

__all__ = ["Walk", "signed_distance"]

PITCH_M = 1.0
ROUNDING_M = 1.5
"""Blur of the blended distance: what draws back in two flanks would end in a spike too thin for any grid."""
LEAST_SHARE = 0.002
"""Of the whole walk, what one step covers at the least, so that every walk ends."""


class Walk:
    """Outlines on the way from `start` to `target`, around `anchor_enu_m`."""

    def __init__(self, start: Ring, target: Ring, anchor_enu_m: FloatArray, corner_radius_m: float) -> None:
        low, high = start.points_enu_m.min(axis=0), start.points_enu_m.max(axis=0)
        self._pitch_m = max(PITCH_M, float((high - low).max()) / 72.0)
        self._origin_enu_m = low - 2.0 * self._pitch_m
        cols, rows = (np.ceil((high - low) / self._pitch_m) + 5).astype(int)
        x, y = np.meshgrid(np.arange(cols), np.arange(rows))
        grid = self._origin_enu_m + np.stack([x, y], axis=-1).reshape(-1, 2) * self._pitch_m
        # Locked, as rings are: numba compiles for each kind of array.
        nodes, begin, end = (
            locked(points, shape=(None, 2), name="points")
            for points in (grid, start.points_enu_m[::2], target.points_enu_m[::2])
        )
        self._from_m = signed_distance(nodes, begin).reshape(rows, cols)
        self._to_m = signed_distance(nodes, end).reshape(rows, cols)
        self._to_m = np.maximum(self._to_m, self._from_m)
        self._anchor_enu_m = anchor_enu_m
        self._corner_radius_m = corner_radius_m
        self._target = target
        self._outline = start
        self._share = 0.0
        self._stride = 1.0

    @property
    def arrived(self) -> bool:
        """Whether the last step led to the target."""
        return self._outline is self._target

    def step(self, step_m: float) -> Ring:
        """The next outline, about `step_m` further at the most; at the end the target itself."""
        while True:
            outline = self._at(self._share + self._stride)
            moved_m = float(signed_distance(self._outline.points_enu_m, outline.points_enu_m).max())
            if moved_m <= 1.25 * step_m or self._stride <= LEAST_SHARE:
                break
            self._stride = max(LEAST_SHARE, self._stride * min(0.5, step_m / moved_m))
        self._share += self._stride
        self._stride *= min(2.0, step_m / max(moved_m, 1e-9))
        self._outline = outline
        return outline

    def _at(self, share: float) -> Ring:
        """The outline at `w = share`, its corners closed; the target at the end or where nothing is left."""
        if share >= 1.0:
            return self._target
        field = (1.0 - share) * self._from_m + share * self._to_m
        field = np.minimum(cv2.GaussianBlur(field, (0, 0), ROUNDING_M / self._pitch_m), self._to_m)
        outline = iso_line(
            field.astype(np.float32), self._pitch_m, self._origin_enu_m, anchor_enu_m=self._anchor_enu_m
        )
        return self._target if outline is None else corners_closed(outline, self._corner_radius_m)


@njit(cache=True)
def signed_distance(points: FloatArray, polygon: FloatArray) -> FloatArray:
    """Distance to a dense counter-clockwise polygon, negative inside: to the edges at its nearest corner.

    The sign is that of the nearest edge's normal, at a corner that of the sum of both unit normals (Bærentzen
    and Aanæs 2005), which holds for spikes too.
    """
    corners = polygon.shape[0]
    longest = 1e-12
    for j in range(corners):
        longest = max(longest, np.hypot(polygon[j, 0] - polygon[j - 1, 0], polygon[j, 1] - polygon[j - 1, 1]))
    out = np.empty(points.shape[0])
    at = 0
    for i in range(points.shape[0]):
        px, py = points[i, 0], points[i, 1]
        # The corner nearest to the point before is a good first guess, so the search can leap.
        near, j = np.sqrt((polygon[at, 0] - px) ** 2 + (polygon[at, 1] - py) ** 2), 0
        while j < corners:
            d = np.sqrt((polygon[j, 0] - px) ** 2 + (polygon[j, 1] - py) ** 2)
            if d < near:
                near, at = d, j
            # So many corners on, none can be nearer.
            j += max(1, int((d - near) / longest))
        best = near * near
        px -= polygon[at, 0]
        py -= polygon[at, 1]
        side, edge_side = 0.0, 0.0
        on_edge = False
        for k in range(2):
            begin, end = (at - 1, at) if k == 0 else (at, (at + 1) % corners)
            ex, ey = polygon[end, 0] - polygon[begin, 0], polygon[end, 1] - polygon[begin, 1]
            length = max(np.sqrt(ex * ex + ey * ey), 1e-12)
            ex /= length
            ey /= length
            beside = ey * px - ex * py
            along = ex * px + ey * py if k == 1 else -(ex * px + ey * py)
            side += beside
            if 0.0 < along <= length and beside * beside <= best:
                best, edge_side, on_edge = beside * beside, beside, True
        if on_edge:
            side = edge_side
        out[i] = np.sqrt(best) if side > 0.0 else -np.sqrt(best)
    return out
