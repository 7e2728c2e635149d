"""One patch from one pose, many pairs at once: how a camera is best pointed from a place, and what it shows then.

`sight` holds every shot against every patch. Here each row is a pair of its own, so that a search for poses costs
no more than the poses that it looks at. What stands in between is asked of `sight` last, of the rows that are left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.frames import wrap_rad
from mavspiral.shape.heightmap import Site
from mavspiral.survey import sight
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import Demand

__all__ = ["Aims", "best_aims", "free_share", "gsd_m"]

IN_PICTURE = 0.98
"""Of half the picture's width and height: a patch is aimed at so that it lies within this."""
SHARES = (0.0, 0.5, 1.0)
"""From straight at the patch to square to it, as far as it stays in the picture."""


@dataclass(frozen=True, slots=True, eq=False)
class Aims:
    """Yaw and pitch of a camera, up is positive, and the pixel on the patch `(n,)`: infinity where it is not shown well."""

    yaw_enu_rad: FloatArray
    pitch_rad: FloatArray
    gsd_m: FloatArray


def best_aims(
    centre_enu_m: FloatArray, normal_enu: FloatArray, place_enu_m: FloatArray, camera: Camera, demand: Demand
) -> Aims:
    """The aim from each place `(n, 3)` that shows its patch, of centre and normal `(n, 3)`, in the finest pixels.

    A camera on a gimbal looks level or down as far as straight down, another one level. Off the middle of the picture
    a pixel on a wall that the camera is square to is finer than in the middle of a picture straight at it.
    """
    toward = centre_enu_m - place_enu_m
    plan_m = np.hypot(toward[:, 0], toward[:, 1])
    straight_yaw, straight_pitch = (
        np.arctan2(toward[:, 1], toward[:, 0]),
        np.arctan2(toward[:, 2], plan_m),
    )
    upright = np.hypot(normal_enu[:, 0], normal_enu[:, 1])
    square_yaw = np.where(upright > 0.05, np.arctan2(-normal_enu[:, 1], -normal_enu[:, 0]), straight_yaw)
    square_pitch = np.arctan2(-normal_enu[:, 2], upright)
    half_yaw, half_pitch = (
        math.atan(IN_PICTURE * side / (2 * camera.focal_length_m)) for side in camera.sensor_m
    )
    aside = np.clip(wrap_rad(square_yaw - straight_yaw), -half_yaw, half_yaw)
    above = np.clip(square_pitch - straight_pitch, -half_pitch, half_pitch)
    best = Aims(straight_yaw, np.zeros(len(toward)), np.full(len(toward), np.inf))
    for yaw_share in SHARES:
        for pitch_share in SHARES if camera.gimbal else (0.0,):
            yaw = straight_yaw + yaw_share * aside
            pitch = np.clip(straight_pitch + pitch_share * above, -0.5 * np.pi if camera.gimbal else 0.0, 0.0)
            gsd = gsd_m(centre_enu_m, normal_enu, place_enu_m, yaw, pitch, camera, demand)
            finer = gsd < best.gsd_m
            best = Aims(
                np.where(finer, yaw, best.yaw_enu_rad),
                np.where(finer, pitch, best.pitch_rad),
                np.where(finer, gsd, best.gsd_m),
            )
    return best


def gsd_m(
    centre_enu_m: FloatArray,
    normal_enu: FloatArray,
    place_enu_m: FloatArray,
    yaw_enu_rad: FloatArray,
    pitch_rad: FloatArray,
    camera: Camera,
    demand: Demand,
) -> FloatArray:
    """The pixel on each patch, `(…)`, were nothing in between; infinity where the demand is not met or it is not in the picture.

    By the pinhole's projection alone: of K·(P − C) the derivative along two directions in the patch's plane is the
    pixels per metre, `sight` solves for its inverse. All arguments broadcast; vectors have one more axis of length 3.
    """
    sin_yaw, cos_yaw = np.sin(yaw_enu_rad), np.cos(yaw_enu_rad)
    sin_pitch, cos_pitch = np.sin(pitch_rad), np.cos(pitch_rad)
    dx, dy, dz = np.moveaxis(centre_enu_m - place_enu_m, -1, 0)
    nx, ny, nz = np.moveaxis(normal_enu, -1, 0)
    level_m = dx * cos_yaw + dy * sin_yaw
    depth = level_m * cos_pitch + dz * sin_pitch
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (dx * sin_yaw - dy * cos_yaw) / depth
        y = (dz * cos_pitch - level_m * sin_pitch) / depth
        range_m = np.sqrt(dx * dx + dy * dy + dz * dz)
        toward = -(nx * dx + ny * dy + nz * dz)
        level_n = nx * cos_yaw + ny * sin_yaw
        n_ahead, n_up = level_n * cos_pitch + nz * sin_pitch, nz * cos_pitch - level_n * sin_pitch
        n_right = nx * sin_yaw - ny * cos_yaw
        # Per unit of x and of y in the picture the place on the plane moves by depth·(r − d·(n·r)/(n·d)), d·d = 1 + x² + y².
        n_d = n_ahead + x * n_right + y * n_up
        a, b = n_right / n_d, n_up / n_d
        across = a * a + (1.0 - x * a) ** 2 + (y * a) ** 2
        up = b * b + (x * b) ** 2 + (1.0 - y * b) ** 2
        half = [side / (2 * camera.focal_length_m) for side in camera.sensor_m]
        pixel = [2 * h / px for h, px in zip(half, camera.image_px, strict=True)]
        gsd = depth * np.sqrt(np.maximum(pixel[0] ** 2 * across, pixel[1] ** 2 * up))
        well = (
            (depth > 0.0)
            & (np.abs(x) <= half[0])
            & (np.abs(y) <= half[1])
            & (toward >= math.cos(demand.incidence_max_rad) * range_m)
            & (gsd <= demand.gsd_max_m)
        )
    return np.where(well, gsd, np.inf)


def free_share(site: Site, start_enu_m: FloatArray, way_enu_m: FloatArray) -> FloatArray:
    """How much of each straight way `(n, 3)` from a start `(n, 3)` is passed before something stands there: 1 if nothing does."""
    heights = site.heights
    grid = np.array([*heights.origin_enu_m, heights.cell_m, heights.top_m])
    start, way = (np.ascontiguousarray(each) for each in (start_enu_m, way_enu_m))
    return np.asarray(sight.gap_m(start, way, 1.0, heights.height_agl_m, grid))


def shown(
    site: Site, before_enu_m: FloatArray, place_enu_m: FloatArray, gsd: FloatArray
) -> NDArray[np.bool_]:
    """Which pairs have a finite pixel and nothing in between, `(n,)`."""
    clear = np.isfinite(gsd)
    rows = np.flatnonzero(clear)
    start = before_enu_m[rows]
    clear[rows] = free_share(site, start, place_enu_m[rows] - start) >= 1.0
    return clear
