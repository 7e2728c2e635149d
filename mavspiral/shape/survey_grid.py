"""Surveyed surfaces (DSM, point clouds) become a site: where is the ground, and what stands out of it?

The ground is a given terrain, else a plane through the low part of the map's rim (or of the points that are
classified as ground). It only decides what stands out; heights are counted from the mission's datum (`datum`).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import LocalFrame
from mavspiral.shape.datum import datum_of
from mavspiral.shape.height_grid import component_at, neighbourhood, site_about
from mavspiral.shape.site_map import MapRequest, SiteMap
from mavspiral.shape.unmeasured import fill_holes, gaps_told

__all__ = ["STANDING_MIN_M", "close_pinholes", "plane_through", "rim_plane", "site_from_survey"]

STANDING_MIN_M = 1.5
"""Lower things in a survey are cars, hedges and noise: obstacles, but no building."""

GROUND_NOISE_M = 0.5
SECTORS, SECTOR_OFF_M = 16, 0.75
LEVEL_GROUND_M = 1.5
"""Ground that leaves the mission's level by less than this is taken to be level."""


def site_from_survey(
    request: MapRequest,
    surface_m: FloatArray,
    terrain_m: FloatArray,
    frame: LocalFrame,
    south_west_m: FloatArray,
    classified: NDArray[np.bool_] | None,
    remarks: tuple[str, ...],
) -> SiteMap:
    """The site of a surveyed surface.

    Args:
        request: which building; its `ground_amsl_m` is the datum.
        surface_m: absolute heights `(rows, cols)` of what is seen from above; NaN where nothing was measured.
        terrain_m: absolute heights of the ground, everywhere.
        frame: in which the grid lies.
        south_west_m: its corner, east and north.
        classified: which cells the survey itself calls building.
        remarks: what the reader had to assume.

    Raises:
        InputError: nothing stands there, or it stands on another ground than the mission's.
    """
    cell_m = request.cell_m
    surface_m = close_pinholes(surface_m)
    measured = np.isfinite(surface_m)
    holed_m = surface_m
    surface_m, filled = fill_holes(holed_m, holed_m - terrain_m > STANDING_MIN_M, cell_m)
    known = measured | filled
    above_m = np.where(known, surface_m - terrain_m, 0.0)
    if classified is None:
        standing = above_m > STANDING_MIN_M
    else:
        standing = classified & measured
        standing |= fill_holes(holed_m, standing, cell_m)[1]
    nothing = (
        f"nothing in it stands more than {STANDING_MIN_M} m out of the ground at {np.median(terrain_m):.1f} m. "
        "Fix: give a larger piece of the map, with ground around the building"
    )
    building = component_at(request, standing, cell_m, frame, south_west_m, nothing)
    warnings = list(remarks)
    if building[[0, -1]].any() or building[:, [0, -1]].any():
        warnings.append("the building reaches the edge of what was read: what lies beyond is not known")
    base_m = float(np.median(terrain_m[building]))
    datum_m, said = datum_of(request, base_m, "the ground around the building")
    height_m = np.where(known, surface_m - datum_m, 0.0)
    level = (np.abs(above_m) <= GROUND_NOISE_M) & (height_m <= LEVEL_GROUND_M) & ~building
    height_m[level] = 0.0

    cut = neighbourhood(building, cell_m)
    height_m, building, above_m = height_m[cut], building[cut], above_m[cut]
    measured, known = measured[cut], known[cut]
    corner_m = south_west_m + np.array([cut[1].start, cut[0].start]) * cell_m
    hill_m = float(height_m[(np.abs(above_m) <= GROUND_NOISE_M) & ~building].max(initial=0.0))
    if hill_m > 0.0:
        warnings.append(
            f"the ground near the building rises to {hill_m:.1f} m above ground_amsl_m: it is an obstacle there"
        )
    warnings.extend(gaps_told(building, measured, known, cell_m, frame, corner_m))
    site = site_about(request, height_m, building, cell_m, frame, corner_m)
    return SiteMap(site, request.path.name.split(".")[0], (*warnings, *said))


def close_pinholes(surface_m: FloatArray) -> FloatArray:
    """The surface with cells without a height, among at least five that have one, at the highest of these."""
    known = np.isfinite(surface_m)
    ring = np.ones((3, 3), dtype=np.uint8)
    neighbours = cv2.filter2D(known.astype(np.uint8), -1, ring, borderType=cv2.BORDER_CONSTANT)
    highest = cv2.dilate(np.where(known, surface_m, -1e9), ring)
    return np.where(~known & (neighbours >= 5), highest, surface_m)


def rim_plane(request: MapRequest, surface_m: FloatArray) -> FloatArray:
    """The ground everywhere `(rows, cols)`, from the lower heights along the map's rim.

    Raises:
        InputError: nothing was measured.
    """
    rows, cols = surface_m.shape
    width = max(1, min(int(np.ceil(2.0 / request.cell_m)), rows // 4, cols // 4))
    rim = np.isfinite(surface_m)
    if not rim.any():
        raise InputError(
            f"{request.path}: nothing was measured there. Fix: give a map that covers the building"
        )
    # The rim of what was measured, which may be turned or torn: what a closed window cannot shrink away.
    filled = cv2.morphologyEx(rim.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), dtype=np.uint8))
    inner = cv2.erode(
        filled,
        np.ones((2 * width + 1, 2 * width + 1), dtype=np.uint8),
        borderType=cv2.BORDER_CONSTANT,
        borderValue=0,
    )
    rim &= inner == 0
    row, col = np.nonzero(rim)
    return plane_through(col, row, surface_m[row, col], surface_m.shape)


def plane_through(col: NDArray, row: NDArray, z_m: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """The plane `(rows, cols)` through the lower of the heights at the cells; level where they tell no slope.

    One low place is taken from each of sixteen sectors around the middle. Sectors that stand out upwards (houses,
    trees) are dropped one by one until the others lie on a plane; all heights near that plane then refine it.
    """
    x, y = col - shape[1] / 2.0, row - shape[0] / 2.0
    terms = np.column_stack([np.ones(len(z_m)), x, y])
    plane = np.array([np.percentile(z_m, 20), 0.0, 0.0])
    sector = np.floor((np.arctan2(y, x) / (2 * np.pi) + 0.5) * SECTORS).astype(np.int64) % SECTORS
    low = []
    for number in range(SECTORS):
        own = np.flatnonzero(sector == number)
        if len(own):
            rank = own[np.argsort(z_m[own], kind="stable")]
            low.append(rank[len(rank) // 5])
    while len(low) >= 6:
        places = np.array(low)
        fit = np.linalg.lstsq(terms[places], z_m[places], rcond=None)[0]
        off = z_m[places] - terms[places] @ fit
        if np.abs(off).max() <= SECTOR_OFF_M:
            near = np.abs(z_m - terms @ fit) <= SECTOR_OFF_M
            plane = np.linalg.lstsq(terms[near], z_m[near], rcond=None)[0]
            break
        low.pop(int(np.argmax(off)))
    rows, cols = shape
    east = (np.arange(cols) - cols / 2.0) * plane[1]
    north = (np.arange(rows) - rows / 2.0) * plane[2]
    return np.asarray(plane[0] + east[np.newaxis, :] + north[:, np.newaxis])
