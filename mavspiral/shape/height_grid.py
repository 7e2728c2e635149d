"""Heights on a grid become a site: the building is what hangs together at the named place."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site, box_of
from mavspiral.shape.site_map import SURROUNDINGS_M, MapRequest, judge_top

__all__ = ["BUILDING_MIN_M", "component_at", "neighbourhood", "site_about"]

BUILDING_MIN_M = 0.5
"""Lower things in a height map are ground, kerbs and noise."""


def component_at(
    request: MapRequest,
    standing: NDArray[np.bool_],
    cell_m: float,
    frame: LocalFrame,
    south_west_m: FloatArray,
    nothing: str,
) -> NDArray[np.bool_]:
    """The cells that hang together at the place that the request names; the largest such piece when it names none.

    Args:
        request: its `at`.
        standing: which cells stand out of the ground.
        cell_m: the cells' side.
        frame: in which the grid lies.
        south_west_m: its corner, east and north.
        nothing: what to say when nothing stands out.

    Raises:
        InputError: nothing stands there; the nearest that does is named.
    """
    box = rows, cols = box_of(standing)
    if not rows.stop:
        raise InputError(f"{request.path}: {nothing}")
    _, labels, stats, _ = cv2.connectedComponentsWithStats(standing[box].astype(np.uint8), connectivity=8)

    def piece(label: int) -> NDArray[np.bool_]:
        whole = np.zeros(standing.shape, dtype=np.bool_)
        whole[box] = labels == label
        return whole

    if request.at is None:
        return piece(1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))
    place = frame.to_enu(*request.at, frame.origin.alt_amsl_m)[:2]
    east, north = (float(v) for v in (place - south_west_m) / cell_m)
    row, col = math.floor(north) - rows.start, math.floor(east) - cols.start
    if not (0 <= row < labels.shape[0] and 0 <= col < labels.shape[1]) or labels[row, col] == 0:
        r, c = np.nonzero(labels) + np.array([[rows.start], [cols.start]])
        away = np.hypot(r + 0.5 - north, c + 0.5 - east)
        nearest = int(np.argmin(away))
        x, y = south_west_m + (np.array([c[nearest], r[nearest]]) + 0.5) * cell_m
        lat, lon, _ = frame.to_geodetic([x, y, 0.0])
        raise InputError(
            f"{request.path}: no building stands at [{request.at[0]}, {request.at[1]}]; the nearest is {away[nearest] * cell_m:.0f} m away. "
            f"Fix: set [building] at = [{float(lat):.6f}, {float(lon):.6f}] (latitude first)"
        )
    return piece(int(labels[row, col]))


def site_about(
    request: MapRequest,
    height_agl_m: FloatArray,
    building: NDArray[np.bool_],
    cell_m: float,
    frame: LocalFrame,
    south_west_m: FloatArray,
) -> Site:
    """The site of a grid of heights, in the frame whose origin is the middle of the building.

    Raises:
        InputError: it is higher than any building.
    """
    judge_top(request.path, float(height_agl_m.max()))
    rows, cols = box_of(building)
    middle = south_west_m + np.array([cols.start + cols.stop, rows.start + rows.stop]) * (cell_m / 2.0)
    lat, lon, _ = frame.to_geodetic([middle[0], middle[1], 0.0])
    own = LocalFrame(GeoPoint(float(lat), float(lon), request.ground_amsl_m))
    return Site(HeightMap(_standing_m(height_agl_m), cell_m, own, south_west_m - middle), building)


def _standing_m(height_agl_m: FloatArray) -> FloatArray:
    """The heights of what stands out of the ground, 0 elsewhere; locked, so that a large map is not copied again."""
    standing = height_agl_m > BUILDING_MIN_M
    box = box_of(standing)
    standing_m = np.zeros(height_agl_m.shape)
    np.copyto(standing_m[box], height_agl_m[box], where=standing[box])
    standing_m.setflags(write=False)
    return standing_m


def neighbourhood(building: NDArray[np.bool_], cell_m: float) -> tuple[slice, slice]:
    """Rows and columns of the map's part that is near enough to the building to matter."""
    reach = math.ceil(SURROUNDINGS_M / cell_m)
    rows, cols = box_of(building)
    return (
        slice(max(0, rows.start - reach), rows.stop + reach),
        slice(max(0, cols.start - reach), cols.stop + reach),
    )
