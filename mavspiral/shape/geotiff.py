"""A site from a GeoTIFF digital surface model, with or without a terrain model beside it.

Every pixel is a flat square that raises all cells it touches. What the file declares (size, blocks, CRS, nodata)
is judged before a pixel is read, and pixels are read in strips, so memory is bounded by the grid of cells.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.shape.crs import MapCrs, map_crs
from mavspiral.shape.site_map import MapRequest, SiteMap, need
from mavspiral.shape.survey_grid import plane_through, rim_plane, site_from_survey
from mavspiral.shape.window import Window, window_of

__all__ = ["site_from_geotiff"]

PIXELS_MAX = 400_000_000
BLOCK_BYTES_MAX = 256_000_000
STRIP_PIXELS = 4_000_000
DEEPEST_M, HIGHEST_M = -500.0, 9500.0


def site_from_geotiff(request: MapRequest) -> SiteMap:
    """The site in the surface model that the request names; the ground from its `dtm`, else from the rim.

    Raises:
        InputError: it cannot be read or believed, or has nothing at the place asked for.
    """
    surface_m, window, crs = _read(request, None)
    if not np.isfinite(surface_m).any():
        raise InputError(
            f"{request.path}: it has no data around there, only nodata. Fix: give a map that covers the building"
        )
    remarks = crs.warnings
    if request.dtm is None:
        terrain_m = rim_plane(request, surface_m)
    else:
        origin = window.frame.origin
        at = request.at or (origin.lat_deg, origin.lon_deg)
        given, _, _ = _read(replace(request, path=request.dtm, at=at), window)
        known = np.isfinite(given)
        if not known.any():
            raise InputError(
                f"{request.dtm}: the terrain does not cover {request.path.name}. Fix: give a [building] dtm of the same place"
            )
        row, col = np.nonzero(known)
        terrain_m = (
            given
            if known.all()
            else np.where(known, given, plane_through(col, row, given[known], given.shape))
        )
    return site_from_survey(request, surface_m, terrain_m, window.frame, window.south_west_m, None, remarks)


def _read(request: MapRequest, grid: Window | None) -> tuple[FloatArray, Window, MapCrs]:
    """Absolute heights in metres on the grid (that of another map where it is given), NaN where there are none."""
    path = request.path
    rasterio = need("rasterio", "geo", path)
    try:
        with (
            rasterio.Env(GDAL_CACHEMAX=64, GDAL_PAM_ENABLED="NO", CPL_DEBUG=False),
            rasterio.open(path, driver="GTiff") as dataset,
        ):
            crs = _judged(request, dataset)
            return _heights(request, dataset, crs, grid)
    except InputError:
        raise
    except Exception as error:  # what GDAL and rasterio raise on a torn file has no common base
        raise InputError(
            f"{path}: not a readable GeoTIFF ({str(error.__cause__ or error)[:160]}). Fix: check it with gdalinfo and export it anew"
        ) from None


def _judged(request: MapRequest, dataset: Any) -> MapCrs:
    """The map's CRS, after what the header declares was judged."""
    path = request.path
    if dataset.count < 1 or np.dtype(dataset.dtypes[0]).kind not in "fiu":
        raise InputError(
            f"{path}: it has no band of real numbers. Fix: give a surface model, heights in band 1"
        )
    if dataset.count > 2 and dataset.dtypes[0] == "uint8":
        raise InputError(
            f"{path}: it is a picture of {dataset.count} bands, not a surface model. Fix: give the DSM, heights in band 1"
        )
    rows, cols = dataset.block_shapes[0]
    size = rows * cols * np.dtype(dataset.dtypes[0]).itemsize * dataset.count
    if size > BLOCK_BYTES_MAX:
        raise InputError(
            f"{path}: its blocks of {cols} × {rows} pixels are too large to read. Fix: gdal_translate -co TILED=YES"
        )
    terms = tuple(dataset.transform)[:6]
    a, b, _, d, e, _ = terms
    if not all(math.isfinite(v) for v in terms) or a * e - b * d == 0 or dataset.transform.is_identity:
        raise InputError(
            f"{path}: it does not say where its pixels lie. Fix: georeference it (gdal_edit.py -a_ullr)"
        )
    own = None if dataset.crs is None else dataset.crs.to_wkt()
    return map_crs(request, own, "gdal_edit.py -a_srs EPSG:… in the file")


def _heights(
    request: MapRequest, dataset: Any, crs: MapCrs, grid: Window | None
) -> tuple[FloatArray, Window, MapCrs]:
    transform, back = dataset.transform, ~dataset.transform

    def to_degrees(col: FloatArray, row: FloatArray) -> tuple[FloatArray, FloatArray]:
        return crs.lat_lon_deg(
            transform.a * col + transform.b * row + transform.c,
            transform.d * col + transform.e * row + transform.f,
        )

    def from_degrees(lat: FloatArray, lon: FloatArray) -> tuple[FloatArray, FloatArray]:
        x, y = crs.xy(lat, lon)
        return back.a * x + back.b * y + back.c, back.d * x + back.e * y + back.f

    window = window_of(
        request, np.zeros(2), np.array([dataset.width, dataset.height], dtype=float), to_degrees, from_degrees
    )
    laid = window if grid is None else grid
    col, row = (int(v) for v in np.floor(window.low))
    cols = min(dataset.width, math.ceil(window.high[0])) - col
    rows = min(dataset.height, math.ceil(window.high[1])) - row
    if rows * cols > PIXELS_MAX:
        raise InputError(
            f"{request.path}: {cols} × {rows} pixels are more than the {PIXELS_MAX:,} that are read. "
            f"Fix: resample it to {request.cell_m:g} m (gdalwarp -tr, -r max) or cut the neighbourhood out"
        )
    shift = window.frame.point_enu_m(laid.frame.origin)[:2]  # of the other map's frame, where one is given
    corner = laid.south_west_m + shift
    height_m = np.full(laid.shape, np.nan)
    strip = max(1, STRIP_PIXELS // max(cols, 1))
    for first in range(row, row + rows, strip):
        count = min(strip, row + rows - first)
        values = _pixels(request.path, dataset, col, first, cols, count) * crs.height_unit_m
        plan = window.plan
        _raise_pixels(
            height_m, values, col, first, plan.middle, plan.half, plan.coefficients_m, corner, request.cell_m
        )
    return height_m, window, crs


def _pixels(path: Path, dataset: Any, col: int, row: int, cols: int, rows: int) -> FloatArray:
    """A strip of the first band, NaN where there is no data."""
    raw = dataset.read(1, window=((row, row + rows), (col, col + cols)), masked=True)
    values: FloatArray = (
        np.asarray(raw.astype(np.float64).filled(np.nan)) * dataset.scales[0] + dataset.offsets[0]
    )
    wrong = np.isinf(values) | (values < DEEPEST_M) | (values > HIGHEST_M / 0.3048)
    if wrong.any():
        r, c = (int(i) for i in np.argwhere(wrong)[0])
        raise InputError(
            f"{path}: pixel (column {col + c}, row {row + r}) is {values[r, c]:g}, no height on earth; nodata is "
            f"{dataset.nodata}. Fix: gdal_edit.py -a_nodata {values[r, c]:g}"
        )
    return values


@njit(cache=True)
def _quadratic(k: FloatArray, s: float, t: float) -> float:
    """A coordinate of `PlanMap`'s, at a place in the piece of the raster scaled to ±1."""
    value: float = k[0] + k[1] * s + k[2] * t + k[3] * s * t + k[4] * s * s + k[5] * t * t
    return value


@njit(cache=True)
def _raise_pixels(
    height: FloatArray,
    values: FloatArray,
    first_col: int,
    first_row: int,
    middle: FloatArray,
    half: FloatArray,
    k: FloatArray,
    corner: FloatArray,
    cell: float,
) -> None:
    """Raises the cells under each pixel; `k` are `PlanMap`'s coefficients.

    Pixels shrink by 1 %, so that those that lie on the cells do not touch the next one.
    """
    rows, cols = height.shape
    reach = np.empty(2)
    for axis in range(2):
        reach[axis] = 0.495 * (abs(k[1, axis]) / half[0] + abs(k[2, axis]) / half[1])
    for r in range(values.shape[0]):
        t = (first_row + r + 0.5 - middle[1]) / half[1]
        for c in range(values.shape[1]):
            z = values[r, c]
            if math.isnan(z):
                continue
            s = (first_col + c + 0.5 - middle[0]) / half[0]
            x = _quadratic(k[:, 0], s, t) - corner[0]
            y = _quadratic(k[:, 1], s, t) - corner[1]
            for i in range(
                max(0, math.floor((y - reach[1]) / cell)),
                min(rows - 1, math.floor((y + reach[1]) / cell)) + 1,
            ):
                for j in range(
                    max(0, math.floor((x - reach[0]) / cell)),
                    min(cols - 1, math.floor((x + reach[0]) / cell)) + 1,
                ):
                    if not height[i, j] >= z:
                        height[i, j] = z
