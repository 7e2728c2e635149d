"""Triangles on cells: never lower than any of their points, never higher than the highest within the cell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.errors import InputError
from mavspiral.shape.polygons import contains, crossing
from mavspiral.shape.site_map import MapRequest
from mavspiral.shape.surfaces import raise_triangles, triangles_of

REQUEST = MapRequest(Path("x.stl"), 0.5, 0.0)
HUNDREDTHS = st.integers(-20, 500).map(lambda n: n / 50)
CORNER = st.tuples(HUNDREDTHS, HUNDREDTHS, HUNDREDTHS)


def raised(triangles):
    height = np.full((20, 20), -np.inf)
    raise_triangles(REQUEST, height, np.asarray(triangles, dtype=float), 0.0, 0.0)
    return height


def highest(triangle, low, high):
    """The slow twin: the highest point of the triangle over a box, among all places where it can be."""
    found = [p[2] for p in triangle if np.all(p[:2] >= low) and np.all(p[:2] <= high)]
    for p, q in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        enter, leave = 0.0, 1.0
        for k in range(2):
            d = q[k] - p[k]
            if d == 0.0:
                leave = leave if low[k] <= p[k] <= high[k] else -1.0
                continue
            near, far = sorted(((low[k] - p[k]) / d, (high[k] - p[k]) / d))
            enter, leave = max(enter, near), min(leave, far)
        if enter <= leave:
            found += [p[2] + t * (q[2] - p[2]) for t in (enter, leave)]
    sides = (triangle[1:] - triangle[0])[:, :2].T
    if abs(np.linalg.det(sides)) > 1e-9:
        for corner in ((x, y) for x in (low[0], high[0]) for y in (low[1], high[1])):
            s, t = np.linalg.solve(sides, corner - triangle[0, :2])
            if s >= 0 and t >= 0 and s + t <= 1:
                found.append(
                    triangle[0, 2]
                    + s * (triangle[1, 2] - triangle[0, 2])
                    + t * (triangle[2, 2] - triangle[0, 2])
                )
    return max(found, default=-np.inf)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(CORNER, CORNER, CORNER), min_size=1, max_size=2))
def test_cells_are_as_high_as_the_highest_point_in_them(triangles):
    triangles = np.array(triangles)
    height = raised(triangles)
    for row, col in np.ndindex(20, 20):
        low = np.array([col, row]) * 0.5
        least, most = (
            max(highest(t, low - grown, low + 0.5 + grown) for t in triangles) for grown in (-1e-5, 1e-5)
        )
        assert least - 1e-6 <= height[row, col] <= most + 1e-6


def test_a_wall_and_a_gable_are_exact():
    wall = [[(1, 1.2, 0), (9, 1.2, 0), (9, 1.2, 8)], [(1, 1.2, 0), (9, 1.2, 8), (1, 1.2, 0)]]
    height = raised(wall)
    assert np.isfinite(height).sum() == 17  # from 1 m to 9 m, the cell that begins at 9 m touched
    assert height[2, 2:18] == pytest.approx((np.arange(2, 18) + 1) * 0.5 - 1, abs=1e-4)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.floats(0, 10), st.floats(0, 10)), min_size=3, max_size=9, unique=True))
def test_polygons_fall_into_triangles_that_cover_them_and_nothing_else(corners):
    ring = np.array(corners)
    if crossing(ring) is not None:
        return
    slope = np.array([0.3, -0.2])
    triangles = triangles_of((np.column_stack([ring, ring @ slope + 5]),))
    area = 0.5 * np.abs(_cross(triangles)).sum()
    x, y = ring.T
    assert area == pytest.approx(abs(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)), abs=1e-6)
    assert np.allclose(triangles[..., 2], triangles[..., :2] @ slope + 5)


def test_holes_stay_open():
    outer = np.array([(0, 0, 3), (9, 0, 3), (9, 9, 3), (0, 9, 3)], dtype=float)
    hole = np.array([(3, 3, 3), (6, 3, 3), (6, 6, 3), (3, 6, 3)], dtype=float)
    height = raised(triangles_of((outer, hole)))
    assert height[9, 9] == -np.inf
    assert height[3, 3] == 3.0
    assert contains((outer[:, :2], hole[:, :2]), 1.0, 1.0)


def test_too_many_large_triangles_are_refused_with_a_cell_that_fits():
    many = np.broadcast_to(np.array([[[0, 0, 1], [10, 0, 1], [0, 10, 1]]], dtype=float)[0], (3_000_000, 3, 3))
    with pytest.raises(InputError, match=r"Fix: set \[building\] cell_m = "):
        raise_triangles(REQUEST, np.zeros((20, 20)), many, 0.0, 0.0)


def _cross(triangles):
    (ax, ay), (bx, by) = (np.moveaxis(triangles[:, i, :2] - triangles[:, 0, :2], -1, 0) for i in (1, 2))
    return ax * by - ay * bx
