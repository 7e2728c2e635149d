"""Volumes to keep away from, raised into the site as solid obstacles."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.polygons import cover

__all__ = ["circle_ring_m", "with_obstacle"]


SIDES = 48
"""Of the polygon that stands for a circle."""


def circle_ring_m(x_m: float, y_m: float, radius_m: float) -> FloatArray:
    """A polygon `(SIDES, 2)` around the circle: its sides touch it, so it is nowhere smaller."""
    angle = np.linspace(0.0, 2 * np.pi, SIDES, endpoint=False)
    outer_m = radius_m / np.cos(np.pi / SIDES)
    return np.column_stack([x_m + outer_m * np.cos(angle), y_m + outer_m * np.sin(angle)])


def with_obstacle(site: Site, ring_enu_m: FloatArray, top_m: float) -> Site:
    """The site with everything inside the ring `(n, 2)` solid from the ground up to `top_m`; the grid grows to hold it.

    Where it stands higher than the building, the cell is an obstacle and no longer the building's.
    """
    heights = site.heights
    west, south, east, north = heights.bounds_enu_m
    low, high = ring_enu_m.min(axis=0), ring_enu_m.max(axis=0)
    missing_m = max(west - low[0], south - low[1], high[0] - east, high[1] - north, 0.0)
    if missing_m > 0.0:
        site = site.padded(missing_m + heights.cell_m)
        heights = site.heights
        west, south, _, _ = heights.bounds_enu_m
    inside = cover((ring_enu_m,), west, south, heights.cell_m, heights.shape)
    higher = inside & (heights.height_agl_m < top_m)
    raised = np.where(higher, top_m, heights.height_agl_m)
    return Site(
        HeightMap(raised, heights.cell_m, heights.frame, heights.origin_enu_m), site.building & ~higher
    )
