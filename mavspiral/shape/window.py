"""The piece of a survey that is read: a north-up grid of cells in metres, about the place that is asked for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.crs import PlanMap
from mavspiral.shape.site_map import MapRequest, judge_size

__all__ = ["Window", "window_of"]

REACH_M = 300.0
"""Of a survey larger than a neighbourhood this far around `at` is read."""

Axes = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """The grid, and the box `low` to `high` of the map's own axes (pixels, or metres of its CRS) that it needs."""

    frame: LocalFrame
    south_west_m: FloatArray
    shape: tuple[int, int]
    low: FloatArray
    high: FloatArray
    plan: PlanMap


def window_of(
    request: MapRequest, low: FloatArray, high: FloatArray, to_degrees: Axes, from_degrees: Axes
) -> Window:
    """What to read of a map whose own axes run from `low` to `high`, both `(2,)`.

    Raises:
        InputError: `at` is not on the map, or the map is too large for its cells.
    """
    middle = (low + high) / 2.0
    lat, lon = (float(v[0]) for v in to_degrees(middle[:1], middle[1:]))
    if request.at is not None:
        around = LocalFrame(GeoPoint(*request.at, request.ground_amsl_m))
        steps = np.linspace(-REACH_M, REACH_M, 9)
        east, north = (axis.ravel() for axis in np.meshgrid(steps, steps))
        place_lat, place_lon, _ = around.to_geodetic(np.column_stack([east, north, np.zeros(len(east))]))
        x, y = from_degrees(place_lat, place_lon)
        at = np.concatenate(from_degrees(*np.array(request.at)[:, np.newaxis]))
        if not (np.isfinite(x).all() and np.isfinite(y).all() and np.all(at >= low) and np.all(at <= high)):
            away_m = math.hypot(*around.to_enu(lat, lon, 0.0)[:2])
            raise InputError(
                f"{request.path}: [building] at = [{request.at[0]}, {request.at[1]}] is not on the map, whose middle is "
                f"[{lat:.6f}, {lon:.6f}], {away_m:.0f} m away. Fix: set at (latitude first), or correct the map's CRS"
            )
        low = np.maximum(low, [x.min(), y.min()])
        high = np.minimum(high, [x.max(), y.max()])
        frame = around
    else:
        frame = LocalFrame(GeoPoint(lat, lon, request.ground_amsl_m))
        # A small step tells the size of a map that may be too large for one plan.
        step = np.maximum((high - low) * 1e-3, 1e-9)
        a, b = middle - step / 2, middle + step / 2
        ends = to_degrees(
            np.array([a[0], b[0], middle[0], middle[0]]), np.array([middle[1], middle[1], a[1], b[1]])
        )
        p = frame.to_enu(*ends, request.ground_amsl_m)[:, :2]
        spans = [float(np.hypot(*(q - r))) * 1e3 / request.cell_m for q, r in ((p[0], p[1]), (p[2], p[3]))]
        judge_size(request, *spans)
    plan = PlanMap.fit(request.path, low, high, to_degrees, frame)
    s, t = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)))
    east, north = plan.plan_m(low[0] + s * (high[0] - low[0]), low[1] + t * (high[1] - low[1]))
    # Multiples of the cell, so that the grid does not depend on where the map happens to end.
    west, south = (math.floor(v.min() / request.cell_m) for v in (east, north))
    cols = math.floor(east.max() / request.cell_m) - west + 1
    rows = math.floor(north.max() / request.cell_m) - south + 1
    judge_size(request, rows, cols)
    return Window(frame, np.array([west, south]) * request.cell_m, (rows, cols), low, high, plan)
