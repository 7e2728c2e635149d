"""What a camera sees: kernels over bare arrays.

A pinhole with roll 0 looks along a; r is to its right, u up its picture. With x and y the offsets in the picture
over the focal length, a place P seen from C lies along d = a + x·r + y·u, at the depth z = (P − C)·a. On the plane
through P with the normal n, a step of one pixel across is p/f·z·|r − d·(n·r)/(n·d)|, and up likewise with u: the
derivative of z·d on that plane. GSD is the larger of the two. A wall straight ahead gives p/f·z all over the picture.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray

__all__ = ["gap_m", "look", "reasons", "way_free"]

OUT_OF_REACH, BEHIND, ABOVE, BELOW, ASIDE, OBLIQUE, COARSE, OCCLUDED = range(8)
"""Why a shot does not see a patch; `reasons` gives one of them for each patch."""

TOUCH_M = 1e-9


@njit(cache=True)
def way_free(heights: FloatArray, grid: FloatArray, start: FloatArray, way: FloatArray) -> float:
    """How much of start + t·way, 0 ≤ t ≤ 1, is passed before a box; 1.0 when there is none.

    `grid` is west, south, cell and top. Cells are walked through in plan (Amanatides and Woo); within each
    the way is inside the box when the lower of its two ends is.
    """
    west, south, cell, top = grid[0], grid[1], grid[2], grid[3]
    rows, cols = heights.shape
    x, y, z = (start[0] - west) / cell, (start[1] - south) / cell, start[2]
    wx, wy, wz = way[0] / cell, way[1] / cell, way[2]
    col, row = math.floor(x), math.floor(y)
    step_x, step_y = (1 if wx > 0.0 else -1), (1 if wy > 0.0 else -1)
    delta_x = 1.0 / abs(wx) if wx != 0.0 else math.inf
    delta_y = 1.0 / abs(wy) if wy != 0.0 else math.inf
    next_x = ((col + 1 - x) if wx > 0.0 else (x - col)) * delta_x if wx != 0.0 else math.inf
    next_y = ((row + 1 - y) if wy > 0.0 else (y - row)) * delta_y if wy != 0.0 else math.inf
    t = 0.0
    while t < 1.0:
        here = z + t * wz
        if wz >= 0.0 and here >= top:
            return 1.0
        leave = min(next_x, next_y, 1.0)
        if 0 <= row < rows and 0 <= col < cols:
            if min(here, z + leave * wz) < heights[row, col] - TOUCH_M:
                return t
        elif (
            (col < 0 and step_x < 0)
            or (col >= cols and step_x > 0)
            or (row < 0 and step_y < 0)
            or (row >= rows and step_y > 0)
        ):
            return 1.0
        t = leave
        if next_x <= next_y:
            col += step_x
            next_x += delta_x
        else:
            row += step_y
            next_y += delta_y
    return 1.0


@njit(cache=True)
def blocked(
    heights: FloatArray, grid: FloatArray, before: FloatArray, camera: FloatArray, way: FloatArray
) -> bool:
    """Whether a box stands between a patch and the camera; `way` is room for three numbers."""
    for c in range(3):
        way[c] = camera[c] - before[c]
    free: bool = way_free(heights, grid, before, way) < 1.0
    return free


@njit(cache=True)
def judge(
    centre: FloatArray, normal: FloatArray, camera: FloatArray, axes: FloatArray, optics: FloatArray
) -> tuple[int, float, float]:
    """Why the shot cannot see the patch were nothing in between (else OCCLUDED), its GSD and cosine of incidence.

    `axes` are a, r and u; `optics` half the picture's width and height over f, pixel width and height over f,
    the finest GSD allowed, the cosine of the greatest incidence, and the reach.
    """
    dx, dy, dz = centre[0] - camera[0], centre[1] - camera[1], centre[2] - camera[2]
    range_m = math.sqrt(dx * dx + dy * dy + dz * dz)
    toward = -(normal[0] * dx + normal[1] * dy + normal[2] * dz)
    if range_m > optics[6]:
        return OUT_OF_REACH, math.inf, 0.0
    if toward <= 0.0:
        return BEHIND, math.inf, 0.0
    cosine = toward / range_m
    depth = axes[0, 0] * dx + axes[0, 1] * dy + axes[0, 2] * dz
    if depth <= 0.0:
        return ASIDE, math.inf, cosine
    x = (axes[1, 0] * dx + axes[1, 1] * dy) / depth
    y = (axes[2, 0] * dx + axes[2, 1] * dy + axes[2, 2] * dz) / depth
    if abs(x) > optics[0]:
        return ASIDE, math.inf, cosine
    if abs(y) > optics[1]:
        return (BELOW if y < 0.0 else ABOVE), math.inf, cosine
    if cosine < optics[5]:
        return OBLIQUE, math.inf, cosine
    across = up = 0.0
    along = -toward / depth
    n_r = (normal[0] * axes[1, 0] + normal[1] * axes[1, 1]) / along
    n_u = (normal[0] * axes[2, 0] + normal[1] * axes[2, 1] + normal[2] * axes[2, 2]) / along
    for c in range(3):
        d = axes[0, c] + x * axes[1, c] + y * axes[2, c]
        across += (axes[1, c] - d * n_r) ** 2
        up += (axes[2, c] - d * n_u) ** 2
    gsd = depth * max(optics[2] * math.sqrt(across), optics[3] * math.sqrt(up))
    return (OCCLUDED if gsd <= optics[4] else COARSE), gsd, cosine


@njit(cache=True, nogil=True)
def look(
    centres: FloatArray,
    befores: FloatArray,
    normals: FloatArray,
    cameras: FloatArray,
    axes: FloatArray,
    optics: FloatArray,
    heights: FloatArray,
    grid: FloatArray,
) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """How many shots see each patch, the finest GSD of these, and the cosine of its incidence.

    The patches are sorted by height, so that a shot need only be held against those within its reach.
    """
    n = len(centres)
    views = np.zeros(n, dtype=np.int64)
    best_gsd, best_cosine = np.full(n, math.inf), np.zeros(n)
    z = centres[:, 2].copy()
    reach, steepest2, way = optics[6], optics[5] * optics[5], np.empty(3)
    for s in range(len(cameras)):
        camera = cameras[s]
        first = np.searchsorted(z, camera[2] - reach)
        last = np.searchsorted(z, camera[2] + reach, side="right")
        for k in range(first, last):
            dx, dy, dz = centres[k, 0] - camera[0], centres[k, 1] - camera[1], centres[k, 2] - camera[2]
            range2 = dx * dx + dy * dy + dz * dz
            if range2 > reach * reach:
                continue
            toward = -(normals[k, 0] * dx + normals[k, 1] * dy + normals[k, 2] * dz)
            if toward <= 0.0 or toward * toward < 0.999999 * steepest2 * range2:
                continue
            reason, gsd, cosine = judge(centres[k], normals[k], camera, axes[s], optics)
            if reason != OCCLUDED or blocked(heights, grid, befores[k], camera, way):
                continue
            views[k] += 1
            if gsd < best_gsd[k]:
                best_gsd[k], best_cosine[k] = gsd, cosine
    return views, best_gsd, best_cosine


@njit(cache=True)
def reasons(
    centres: FloatArray,
    normals: FloatArray,
    cameras: FloatArray,
    axes: FloatArray,
    optics: FloatArray,
) -> NDArray[np.int64]:
    """Why each of some patches, seen by no shot, is not: what hinders the shot that is nearest to seeing it.

    Nearest is the one with the least range over cosine, to which the GSD is proportional near a picture's middle.
    """
    found = np.full(len(centres), OUT_OF_REACH)
    for k in range(len(centres)):
        best = math.inf
        for s in range(len(cameras)):
            range2 = 0.0
            for c in range(3):
                range2 += (centres[k, c] - cameras[s, c]) ** 2
            if range2 > optics[6] * optics[6]:
                continue
            reason, _, cosine = judge(centres[k], normals[k], cameras[s], axes[s], optics)
            if reason == BEHIND and best == math.inf:
                found[k] = BEHIND
            if cosine <= 0.0:
                continue
            merit = range2 / (cosine * cosine)
            if merit < best:
                best, found[k] = merit, reason
    return found


@njit(cache=True)
def gap_m(
    befores: FloatArray, normals: FloatArray, reach_m: float, heights: FloatArray, grid: FloatArray
) -> FloatArray:
    """How far each patch looks along its normal before something stands in the way, at most `reach_m`."""
    gaps = np.empty(len(befores))
    for k in range(len(befores)):
        gaps[k] = reach_m * way_free(heights, grid, befores[k], normals[k] * reach_m)
    return gaps
