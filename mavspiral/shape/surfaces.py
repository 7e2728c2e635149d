"""Surfaces in space laid onto a grid of cells: each cell takes the height of the highest point in it.

The height is exact, not sampled: every triangle is cut to every cell that it touches (Sutherland and Hodgman,
Reentrant Polygon Clipping, 1974) and the highest corner of what remains counts. A cell that is touched at its
edge is raised as well, as `polygons.cover` does, so a wall stands up to one cell too far out, never too far in.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numba import njit

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.shape.site_map import MapRequest

__all__ = ["raise_triangles", "triangles_of"]

CUTS_MAX = 1_000_000_000


def raise_triangles(
    request: MapRequest, height_m: FloatArray, triangles_m: FloatArray, west_m: float, south_m: float
) -> None:
    """Raises the cells of `height_m (rows, cols)` to the triangles `(n, 3, 3)` above them.

    Raises:
        InputError: so many triangles cover so many cells that it would take minutes.
    """
    spans = np.ptp(triangles_m[:, :, :2], axis=1) / request.cell_m + 1.0
    cuts = float(
        np.sum(np.minimum(spans[:, 0], height_m.shape[1]) * np.minimum(spans[:, 1], height_m.shape[0]))
    )
    if cuts > CUTS_MAX:
        fits = math.ceil(request.cell_m * math.sqrt(cuts / CUTS_MAX) * 100) / 100
        raise InputError(
            f"{request.path}: its {len(triangles_m):,} triangles cover {cuts:.1e} cells of {request.cell_m:g} m. "
            f"Fix: set [building] cell_m = {fits}, or simplify the model"
        )
    _raise(height_m, np.ascontiguousarray(triangles_m), west_m, south_m, request.cell_m)


def triangles_of(rings_m: tuple[FloatArray, ...]) -> FloatArray:
    """The polygon (outline, then holes; `(n, 3)` each) as triangles `(t, 3, 3)`; none when it stands upright.

    It is sliced from south to north at every corner; between two slices the sides, paired by even-odd,
    bound trapezoids.
    """
    if len(rings_m) == 1 and len(rings_m[0]) == 3:
        return rings_m[0][np.newaxis]
    start = np.vstack(rings_m)
    end = np.vstack([np.roll(ring, -1, axis=0) for ring in rings_m])
    low_y, high_y = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
    pieces = []
    for south, north in pairwise(np.unique(start[:, 1])):
        through = (low_y <= south) & (high_y >= north)
        a, side = start[through], (end - start)[through]
        at_south = a + ((south - a[:, 1]) / side[:, 1])[:, np.newaxis] * side
        at_north = a + ((north - a[:, 1]) / side[:, 1])[:, np.newaxis] * side
        order = np.argsort(at_south[:, 0] + at_north[:, 0], kind="stable")
        at_south, at_north = at_south[order], at_north[order]
        left_s, right_s, left_n, right_n = at_south[::2], at_south[1::2], at_north[::2], at_north[1::2]
        pieces.append(np.stack([left_s, right_s, right_n], axis=1))
        pieces.append(np.stack([left_s, right_n, left_n], axis=1))
    return np.concatenate(pieces) if pieces else np.zeros((0, 3, 3))


@njit(cache=True)
def _keep(points: FloatArray, n: int, axis: int, bound: float, sign: float, out: FloatArray) -> int:
    """Cuts the convex polygon `points[:n]` to sign·p[axis] ≥ sign·bound; returns how many corners `out` has."""
    m = 0
    for i in range(n):
        p, q = points[i], points[(i + 1) % n]
        d_p, d_q = sign * (p[axis] - bound), sign * (q[axis] - bound)
        if d_p >= 0.0:
            out[m] = p
            m += 1
        if (d_p >= 0.0) != (d_q >= 0.0):
            t = d_p / (d_p - d_q)
            for k in range(3):
                out[m, k] = p[k] + t * (q[k] - p[k])
            m += 1
    return m


@njit(cache=True)
def _raise(height: FloatArray, triangles: FloatArray, west: float, south: float, cell: float) -> None:
    rows, cols = height.shape
    slack = 1e-6 * cell
    half, strip, rest, piece = np.empty((8, 3)), np.empty((8, 3)), np.empty((8, 3)), np.empty((8, 3))
    for t in range(triangles.shape[0]):
        corners = triangles[t]
        top = corners[:, 2].max()
        first_row = int(max(0.0, math.floor((corners[:, 1].min() - south) / cell)))
        last_row = int(min(rows - 1.0, math.floor((corners[:, 1].max() - south) / cell)))
        for r in range(first_row, last_row + 1):
            n = _keep(corners, 3, 1, south + r * cell - slack, 1.0, half)
            n = _keep(half, n, 1, south + (r + 1) * cell + slack, -1.0, strip)
            if n == 0:
                continue
            first = int(max(0.0, math.floor((strip[:n, 0].min() - west) / cell)))
            last = int(min(cols - 1.0, math.floor((strip[:n, 0].max() - west) / cell)))
            for c in range(first, last + 1):
                if height[r, c] >= top:
                    continue
                m = _keep(strip, n, 0, west + c * cell - slack, 1.0, rest)
                m = _keep(rest, m, 0, west + (c + 1) * cell + slack, -1.0, piece)
                for i in range(m):
                    height[r, c] = max(height[r, c], piece[i, 2])
