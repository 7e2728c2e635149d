"""A site from a LAS or LAZ point cloud: the highest point of each cell.

Points classified as building (6) are the building, with what is unclassified (0, 1) and goes on at their height; where
there are none, what stands out of the ground is. Ground (2) gives the ground, else the rim does. Noise (7, 18) is left
out; everything else (wires, trees) is an obstacle. Points are read in chunks, after the header's claims were held
against the size of the file.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.shape.crs import MapCrs, map_crs
from mavspiral.shape.las_claims import judge_chunks, judge_header
from mavspiral.shape.site_map import MapRequest, SiteMap, need
from mavspiral.shape.survey_grid import (
    STANDING_MIN_M,
    close_pinholes,
    plane_through,
    rim_plane,
    site_from_survey,
)
from mavspiral.shape.window import Window, window_of

__all__ = ["site_from_points"]

GROUND, BUILDING, NOISE, UNCLASSIFIED = 2, 6, (7, 18), (0, 1)
STEP_M = 0.5
"""A roof goes on over a step of so much, or of what a steep one rises in a cell."""
TOLD_M2 = 2.0
HIGHEST = 40_000.0
"""No height on earth, in feet either."""
CHUNK_BYTES = 32_000_000


@dataclass(slots=True, eq=False)
class _Surfaces:
    """The highest point of each cell, by kind; -inf where there is none."""

    building: FloatArray
    ground: FloatArray
    other: FloatArray
    unclassified: FloatArray
    points: int = 0


def site_from_points(request: MapRequest) -> SiteMap:
    """The site in the point cloud that the request names.

    Raises:
        InputError: it cannot be read or believed, is too sparse for its cells, or has nothing at the place asked for.
    """
    path = request.path
    laspy = need("laspy", "cloud", path)
    need("lazrs", "cloud", path)
    need("pyproj", "cloud", path)
    logging.getLogger("laspy").addHandler(logging.NullHandler())  # it reports what it raises a second time
    judge_header(path)
    try:
        with laspy.open(path, laz_backend=laspy.LazBackend.Lazrs, read_evlrs=True) as reader:
            judge_chunks(path, reader.header)
            crs = map_crs(
                request,
                reader.header.parse_crs(),
                "write it into the file, e.g. las2las -epsg 32614",
                "cloud",
            )
            window = _window(request, reader.header, crs)
            surfaces = _surfaces(request, reader, window, crs.height_unit_m)
    except InputError:
        raise
    except BaseException as error:  # lazrs panics with an exception outside of Exception
        if isinstance(error, KeyboardInterrupt | SystemExit | GeneratorExit):
            raise
        raise InputError(
            f"{path}: not a readable point cloud ({type(error).__name__}: {str(error)[:120]}). Fix: check it with lasinfo and export it anew"
        ) from None
    return _site(request, surfaces, window, crs)


def _site(request: MapRequest, surfaces: _Surfaces, window: Window, crs: MapCrs) -> SiteMap:
    own = np.isfinite(surfaces.building)
    seen = np.maximum(
        np.maximum(surfaces.building, surfaces.other), np.maximum(surfaces.ground, surfaces.unclassified)
    )
    if not np.isfinite(seen).any():
        raise InputError(
            f"{request.path}: it has no points around there. Fix: give a cloud that covers the building"
        )
    surface_m = np.where(np.isfinite(seen), seen, np.nan)
    remarks = list(crs.warnings)
    row, col = np.nonzero(np.isfinite(surfaces.ground))
    if len(row) >= 12:
        terrain_m = plane_through(col, row, surfaces.ground[row, col], surface_m.shape)
    else:
        terrain_m = rim_plane(request, surface_m)
        remarks.append("no points are classified as ground (2): the ground is that of the cloud's rim")
    classified = None
    if own.any():
        unclassified = (surfaces.unclassified >= seen) & (surface_m - terrain_m > STANDING_MIN_M)
        goes_on = _goes_on(np.where(own, surfaces.building, seen), own, unclassified & ~own, request.cell_m)
        more_m2 = np.count_nonzero(goes_on & ~own) * request.cell_m**2
        if more_m2 > TOLD_M2:
            remarks.append(
                f"{more_m2:.0f} m² beside the points that are classified as building (6) stand as high and are "
                "unclassified: they are taken to be of the building"
            )
        classified = np.isfinite(close_pinholes(np.where(goes_on, seen, np.nan)))
    else:
        remarks.append(
            "no points are classified as building (6): what stands out of the ground is taken to be one"
        )
    _judge_density(request, own if own.any() else np.isfinite(seen), surfaces.points)
    return site_from_survey(
        request, surface_m, terrain_m, window.frame, window.south_west_m, classified, tuple(remarks)
    )


@njit(cache=True)
def _goes_on(
    height_m: FloatArray, own: NDArray[np.bool_], open_to: NDArray[np.bool_], cell_m: float
) -> NDArray[np.bool_]:
    """The cells of `own`, and of `open_to` those that it reaches from cell to cell without a step."""
    rows, cols = own.shape
    step_m = max(STEP_M, 1.5 * cell_m)
    reached = own.copy()
    stack = [(r, c) for r in range(rows) for c in range(cols) if own[r, c]]
    while len(stack):
        row, col = stack.pop()
        for r in range(max(0, row - 1), min(rows, row + 2)):
            for c in range(max(0, col - 1), min(cols, col + 2)):
                rise_m = abs(height_m[r, c] - height_m[row, col])
                if open_to[r, c] and not reached[r, c] and rise_m <= step_m:
                    reached[r, c] = True
                    stack.append((r, c))
    return reached


def _judge_density(request: MapRequest, hit: np.ndarray, points: int) -> None:
    """Refuses cells so small that a roof would be a sieve."""
    block = max(1, math.ceil(2.0 / request.cell_m))
    row, col = np.nonzero(hit)
    blocks = len(np.unique(row // block * (hit.shape[1] + block) + col // block))
    spacing_m = math.sqrt(blocks * (block * request.cell_m) ** 2 / max(points, 1))
    if request.cell_m < 1.1 * spacing_m:
        raise InputError(
            f"{request.path}: its points are {spacing_m:.2f} m apart, cells of {request.cell_m:g} m would leave holes. "
            f"Fix: set [building] cell_m = {math.ceil(1.75 * spacing_m * 20) / 20:g}"
        )


def _window(request: MapRequest, header: Any, crs: MapCrs) -> Window:
    numbers = np.array([header.mins, header.maxs, header.scales, header.offsets], dtype=np.float64)
    low, high = numbers[0, :2], numbers[1, :2]
    if not np.isfinite(numbers).all() or np.any(low > high) or np.any(numbers[2] == 0.0):
        raise InputError(
            f"{request.path}: its header's extent {low.tolist()} to {high.tolist()} is impossible. Fix: lasinfo -repair"
        )
    return window_of(request, low, high, crs.lat_lon_deg, crs.xy)


def _surfaces(request: MapRequest, reader: Any, window: Window, height_unit_m: float) -> _Surfaces:
    made = _Surfaces(*(np.full((4, *window.shape), -np.inf)))
    rows, cols = window.shape
    header = reader.header
    slack = np.maximum(np.abs(header.scales[:2]), 1e-9) * 2
    on_building = on_anything = 0
    for points in reader.chunk_iterator(max(1, CHUNK_BYTES // header.point_format.size)):
        x, y, z = (np.asarray(axis, dtype=np.float64) for axis in (points.x, points.y, points.z))
        _judge_points(request.path, header, x, y, z, slack)
        kind = np.asarray(points.classification)
        inside = (x >= window.low[0]) & (x <= window.high[0]) & (y >= window.low[1]) & (y <= window.high[1])
        inside &= ~np.isin(kind, NOISE)
        east, north = window.plan.plan_m(x[inside], y[inside])
        row = np.floor((north - window.south_west_m[1]) / request.cell_m).astype(np.int64)
        col = np.floor((east - window.south_west_m[0]) / request.cell_m).astype(np.int64)
        z_m, kind = z[inside] * height_unit_m, kind[inside]
        on_grid = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        for grid, chosen in (
            (made.building, kind == BUILDING),
            (made.ground, kind == GROUND),
            (made.unclassified, np.isin(kind, UNCLASSIFIED)),
            (made.other, ~np.isin(kind, (BUILDING, GROUND, *UNCLASSIFIED))),
        ):
            pick = on_grid & chosen
            np.maximum.at(grid, (row[pick], col[pick]), z_m[pick])
        on_building += int(np.count_nonzero(on_grid & (kind == BUILDING)))
        on_anything += int(np.count_nonzero(on_grid))
    made.points = on_building or on_anything
    return made


def _judge_points(
    path: Path, header: Any, x: FloatArray, y: FloatArray, z: FloatArray, slack: FloatArray
) -> None:
    if not len(x):
        return
    low, high = header.mins[:2] - slack, header.maxs[:2] + slack
    if x.min() < low[0] or y.min() < low[1] or x.max() > high[0] or y.max() > high[1]:
        raise InputError(f"{path}: it has points outside of the extent in its header. Fix: lasinfo -repair")
    if not (np.isfinite(z).all() and np.all(np.abs(z) < HIGHEST)):
        raise InputError(
            f"{path}: a point is {z[np.argmax(~(np.abs(z) < HIGHEST))]:g} high, no height on earth. Fix: export the cloud anew"
        )
