"""What a flight comes too near to, in words: the building, a keep-out of the mission's, or what else stands, and where."""

from __future__ import annotations

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import keepout_ring_m
from mavspiral.mission import Mission
from mavspiral.shape.heightmap import Site
from mavspiral.shape.polygons import cover

__all__ = ["nearest_obstacle"]

SAMPLES = 65
"""Places on a straight way from which the nearest solid cell is looked for."""


def nearest_obstacle(
    mission: Mission, site: Site, place_enu_m: FloatArray, sweep_enu_m: FloatArray | None = None
) -> str:
    """The solid thing nearest to a place `(3,)`, or to the straight way from it over its sweep `(3,)`.

    Its kind or name, the latitude and longitude of its nearest cell, and how high that is; nothing where nothing stands.
    """
    heights = site.heights
    rows, cols = np.nonzero(heights.height_agl_m > 0.0)
    if not len(rows):
        return ""
    low = heights.origin_enu_m + np.column_stack([cols, rows]) * heights.cell_m
    top_m = heights.height_agl_m[rows, cols]
    best2, best = np.inf, 0
    for share in (0.0,) if sweep_enu_m is None else np.linspace(0.0, 1.0, SAMPLES):
        x, y, z = place_enu_m if sweep_enu_m is None else place_enu_m + share * sweep_enu_m
        dx = np.maximum(np.maximum(low[:, 0] - x, x - low[:, 0] - heights.cell_m), 0.0)
        dy = np.maximum(np.maximum(low[:, 1] - y, y - low[:, 1] - heights.cell_m), 0.0)
        away2 = dx**2 + dy**2 + np.maximum(z - top_m, 0.0) ** 2
        nearest = int(np.argmin(away2))
        if away2[nearest] < best2:
            best2, best = float(away2[nearest]), nearest
    row, col = int(rows[best]), int(cols[best])
    middle = low[best] + 0.5 * heights.cell_m
    place = heights.frame.geo_point(np.array([middle[0], middle[1], 0.0]))
    return f"{_kind(mission, site, row, col)} at lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, {top_m[best]:.1f} m high"


def _kind(mission: Mission, site: Site, row: int, col: int) -> str:
    heights = site.heights
    if site.building[row, col]:
        return "the building"
    west, south = heights.origin_enu_m
    for number, keepout in enumerate(mission.keepout, start=1):
        ring = keepout_ring_m(keepout, heights.frame)
        inside = cover((ring,), west, south, heights.cell_m, heights.shape)
        if inside[row, col] and heights.height_agl_m[row, col] == keepout.height_m[1]:
            return f'keepout "{keepout.name}"' if keepout.name else f"[[keepout]] {number}"
    return "something else on the map"
