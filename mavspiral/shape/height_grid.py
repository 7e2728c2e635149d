"""A site from a grid of heights in an `.npz`: the building is what hangs together at the named place."""

from __future__ import annotations

import math
import zipfile

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.site_map import MapRequest, SiteMap, judge_size

__all__ = ["site_from_grid"]

BUILDING_MIN_M = 0.5
"""Lower things in a height map are ground, kerbs and noise."""


def site_from_grid(request: MapRequest) -> SiteMap:
    """The site in the `.npz` that the request names.

    Raises:
        InputError: it is no height map, holds a NaN (named), or has nothing at the place asked for.
    """
    path = request.path
    try:
        with np.load(path, allow_pickle=False) as archive:
            missing = [key for key in ("height_agl_m", "cell_m", "origin") if key not in archive]
            if missing:
                raise InputError(
                    f"{path}: has no {missing[0]!r}. "
                    "Fix: a height map holds height_agl_m (rows, cols), cell_m and origin = [lat, lon]"
                )
            height = np.asarray(archive["height_agl_m"], dtype=np.float64)
            cell_m = float(archive["cell_m"])
            origin = np.asarray(archive["origin"], dtype=np.float64)
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, MemoryError) as error:
        raise InputError(
            f"{path}: not a readable .npz height map ({error}). Fix: write it with numpy.savez"
        ) from None
    if height.ndim != 2 or height.size == 0:
        raise InputError(f"{path}: height_agl_m has shape {height.shape}. Fix: give a (rows, cols) array")
    if not np.isfinite(height).all():
        row, col = (int(i) for i in np.argwhere(~np.isfinite(height))[0])
        raise InputError(
            f"{path}: height_agl_m[{row}, {col}] is {height[row, col]}. Fix: fill gaps with the ground's 0 or a measured height"
        )
    if not (math.isfinite(cell_m) and cell_m > 0):
        raise InputError(f"{path}: cell_m is {cell_m}. Fix: give the cells' side in metres")
    if origin.shape != (2,) or not np.isfinite(origin).all() or np.any(np.abs(origin) > (90.0, 180.0)):
        raise InputError(
            f"{path}: origin is {origin.tolist()}. Fix: give [lat, lon] in degrees of the south-west corner"
        )
    judge_size(MapRequest(path, cell_m, 0.0), *height.shape)
    corner = LocalFrame(GeoPoint(float(origin[0]), float(origin[1]), request.ground_amsl_m))
    building = _component(request, height, cell_m, corner)
    rows, cols = np.nonzero(building)
    middle = np.array([(cols.min() + cols.max() + 1) / 2.0, (rows.min() + rows.max() + 1) / 2.0]) * cell_m
    lat, lon, _ = corner.to_geodetic([middle[0], middle[1], 0.0])
    frame = LocalFrame(GeoPoint(float(lat), float(lon), request.ground_amsl_m))
    return SiteMap(Site(HeightMap(np.maximum(height, 0.0), cell_m, frame, -middle), building), path.stem, ())


def _component(
    request: MapRequest, height: FloatArray, cell_m: float, corner: LocalFrame
) -> NDArray[np.bool_]:
    standing = (height > BUILDING_MIN_M).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(standing, connectivity=8)
    if count < 2:
        raise InputError(
            f"{request.path}: nothing in it is higher than {BUILDING_MIN_M} m. Fix: heights are metres above ground"
        )
    if request.at is None:
        return np.asarray(labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))
    east, north, _ = corner.to_enu(*request.at, request.ground_amsl_m)
    row, col = math.floor(north / cell_m), math.floor(east / cell_m)
    rows, cols = height.shape
    if not (0 <= row < rows and 0 <= col < cols) or labels[row, col] == 0:
        r, c = np.nonzero(labels)
        nearest = int(np.argmin((r + 0.5 - north / cell_m) ** 2 + (c + 0.5 - east / cell_m) ** 2))
        lat, lon, _ = corner.to_geodetic([(c[nearest] + 0.5) * cell_m, (r[nearest] + 0.5) * cell_m, 0.0])
        away = math.hypot((r[nearest] + 0.5) * cell_m - north, (c[nearest] + 0.5) * cell_m - east)
        raise InputError(
            f"{request.path}: no building stands at [{request.at[0]}, {request.at[1]}]; the nearest is {away:.0f} m away. "
            f"Fix: set [building] at = [{float(lat):.6f}, {float(lon):.6f}] (latitude first)"
        )
    return np.asarray(labels == labels[row, col])
