"""What any safe pose could see: the most that a survey can be asked for.

From each patch rays go out over all directions within the greatest incidence. On one ray the pixel grows with the
range, so its best pose is its nearest safe one. Distance to what is solid is 1-Lipschitz: where it is short of the
clearance by s, nothing within s is safe, and the search goes on by s. What it finds is exact along the ray.

Safe is: as far from everything solid as is required, and not lower or higher than is allowed. A way there needs no
look: on a height map what is safe stays safe straight up, unless a ceiling is below the roofs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.headway import Headway, to_nobody
from mavspiral.shape.heightmap import Site
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import NO_ROOM, OUT_OF_BAND, SEEABLE, TOO_FAR, UNKNOWN, Coverage, Demand
from mavspiral.survey.glimpses import best_aims, free_share, shown
from mavspiral.survey.patches import Patches
from mavspiral.survey.solids import Solids

__all__ = ["Glimpses", "Room", "glimpses_of", "with_best_poses"]

STEP_RAD = math.radians(5.0)
SWEEPS = 16
"""One ray in so many goes out at a time; what is seen by then needs no more."""
POSES = 6
"""One ray in so many is asked for a pose."""
NEARER_M = 0.1
"""A search goes on by no less: a safe place may be missed by so much."""
STEPS_MAX = 60
FARTHER = (0.0, 0.25, 0.6)
"""Where the nearest safe pose does not see round a corner beside its patch, so far on to the end of the ray another may."""
ASKED_MAX = 250
"""What more patches than this would tell is not worth their time; cubes grow by `GROWTH` until there are no more."""
GROWTH = 1.3
TILT = 1.1
"""Rays that leave a level camera's picture by more than a tenth are not followed."""


@dataclass(frozen=True, slots=True)
class Room:
    """Where a camera may be: so far from everything solid, and between these heights."""

    clearance_m: float
    lowest_m: float
    highest_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Glimpses:
    """Poses that see a patch each: which one `(n,)`, from where `(n, 3)`, yaw and pitch `(n,)`, and the pixel on it."""

    patch: NDArray[np.int64]
    place_enu_m: FloatArray
    yaw_enu_rad: FloatArray
    pitch_rad: FloatArray
    gsd_m: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Scene:
    patches: Patches
    site: Site
    solids: Solids
    camera: Camera
    demand: Demand
    room: Room


def with_best_poses(
    coverage: Coverage,
    site: Site,
    solids: Solids,
    camera: Camera,
    room: Room,
    *,
    roofs: bool,
    headway: Headway = to_nobody,
) -> Coverage:
    """The coverage, and how near any safe pose comes to seeing each unseen piece of wall, and of roof if asked.

    Of more than `ASKED_MAX` patches, one in each cube answers for those on the same side in it.
    """
    patches = coverage.patches
    index = np.flatnonzero((coverage.views == 0) & (patches.is_wall | roofs))
    scene = _Scene(patches, site, solids, camera, coverage.demand, room)
    asked, group = _representatives(patches, index)
    fan = _fan(coverage.demand.incidence_max_rad)
    reached = np.full(len(asked), OUT_OF_BAND)
    for first in range(SWEEPS):
        left = np.flatnonzero(reached != SEEABLE)
        row, came, _ = _cast(scene, asked[left], fan[first::SWEEPS])
        np.maximum.at(reached, left[row], came)
        headway((first + 1) / SWEEPS)
    best_pose = np.where(coverage.views > 0, SEEABLE, UNKNOWN)
    best_pose[index] = reached[group]
    return replace(coverage, best_pose=best_pose)


def glimpses_of(
    patches: Patches,
    index: NDArray[np.int64],
    site: Site,
    solids: Solids,
    camera: Camera,
    demand: Demand,
    room: Room,
) -> Glimpses:
    """For each of the patches `index` the nearest safe pose on each of the rays that see it."""
    scene = _Scene(patches, site, solids, camera, demand, room)
    return _cast(scene, index, _fan(demand.incidence_max_rad)[::POSES])[2]


def _representatives(
    patches: Patches, index: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Of the patches `index` those that are asked, and for each of all which of these answers for it."""
    size_m = patches.cell_m
    asked, group = index, np.arange(len(index))
    while len(asked) > ASKED_MAX:
        size_m *= GROWTH
        cube = np.floor(patches.centre_enu_m[index] / size_m).astype(np.int64)
        cube = np.column_stack([cube - cube.min(axis=0), patches.side[index]])
        key = np.ravel_multi_index(tuple(cube.T), tuple(cube.max(axis=0) + 1))
        _, first, group = np.unique(key, return_index=True, return_inverse=True)
        asked = index[first]
    return asked, group


def _cast(
    scene: _Scene, index: NDArray[np.int64], rays: FloatArray
) -> tuple[NDArray[np.int64], NDArray[np.int64], Glimpses]:
    """Every ray of every patch: the row of `index` and how far it came, and the poses of those that see."""
    patches, room = scene.patches, scene.room
    row = np.repeat(np.arange(len(index)), len(rays))
    patch = index[row]
    way = _turned(patches.normal_enu[index], rays).reshape(-1, 3)
    came = np.full(len(row), OUT_OF_BAND)
    near_m, far_m = _allowed_m(patches.centre_enu_m[patch, 2], way[:, 2], scene)
    far_m = np.where(_pointable(scene.camera, way), far_m, -1.0)
    live = np.flatnonzero(near_m <= far_m)
    start = patches.centre_enu_m[patch[live]]
    far_m = _unblocked_m(scene, patch[live], way[live], far_m[live])
    came[live] = NO_ROOM
    at_m = _nearest_safe_m(scene.solids, start, way[live], near_m[live], far_m, room.clearance_m)
    safe = np.isfinite(at_m)
    live, start, at_m, far_m = live[safe], start[safe], at_m[safe], far_m[safe]
    came[live] = TOO_FAR
    found: list[Glimpses] = []
    for share in FARTHER:
        place = start + (at_m + share * (far_m - at_m))[:, None] * way[live]
        aims = best_aims(
            patches.centre_enu_m[patch[live]],
            patches.normal_enu[patch[live]],
            place,
            scene.camera,
            scene.demand,
        )
        sees = shown(scene.site, patches.before_enu_m[patch[live]], place, aims.gsd_m)
        if share:
            sees[sees] = scene.solids.distance_m(place[sees]) >= room.clearance_m
        came[live[sees]] = SEEABLE
        found.append(
            Glimpses(
                patch[live[sees]],
                place[sees],
                aims.yaw_enu_rad[sees],
                aims.pitch_rad[sees],
                aims.gsd_m[sees],
            )
        )
        hidden = np.isfinite(aims.gsd_m) & ~sees
        live, start, at_m, far_m = live[hidden], start[hidden], at_m[hidden], far_m[hidden]
    return row, came, _joined(found)


def _joined(found: list[Glimpses]) -> Glimpses:
    return Glimpses(*(np.concatenate([getattr(each, f.name) for each in found]) for f in fields(Glimpses)))


def _fan(incidence_max_rad: float) -> FloatArray:
    """Directions `(m, 3)` about the first axis, on rings up to the greatest incidence, square ones first."""
    rings = max(2, math.ceil(incidence_max_rad / STEP_RAD))
    rays = [np.array([[1.0, 0.0, 0.0]])]
    for ring in range(1, rings + 1):
        angle = incidence_max_rad * 0.9999 * ring / rings
        around = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring)
        rays.append(
            np.column_stack(
                [
                    np.full(6 * ring, math.cos(angle)),
                    math.sin(angle) * np.cos(around),
                    math.sin(angle) * np.sin(around),
                ]
            )
        )
    return np.concatenate(rays)


def _turned(normal_enu: FloatArray, rays: FloatArray) -> FloatArray:
    """The rays `(n, m, 3)` about each normal `(n, 3)`."""
    upright = np.hypot(normal_enu[:, 0], normal_enu[:, 1])[:, None]
    level = np.stack([-normal_enu[:, 1], normal_enu[:, 0], np.zeros(len(normal_enu))], axis=1)
    along = np.where(upright > 1e-6, level / np.maximum(upright, 1e-6), [[1.0, 0.0, 0.0]])
    axes = np.stack([normal_enu, along, np.cross(normal_enu, along)], axis=1)
    return np.asarray(np.einsum("mk,nkc->nmc", rays, axes))


def _pointable(camera: Camera, way: FloatArray) -> NDArray[np.bool_]:
    """Whether a camera on that ray can have its beginning in the picture: one without a gimbal looks level, none looks up."""
    tangent = way[:, 2] / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)
    half = TILT * camera.sensor_m[1] / (2 * camera.focal_length_m)
    return np.asarray((tangent >= -half) & (camera.gimbal | (tangent <= half)))


def _allowed_m(start_m: FloatArray, rise: FloatArray, scene: _Scene) -> tuple[FloatArray, FloatArray]:
    """From where to where on each ray the height is allowed, and the pixel may be fine enough, or nothing safe."""
    low_m, high_m = scene.room.lowest_m - start_m, scene.room.highest_m - start_m
    pixel = min(
        side / (scene.camera.focal_length_m * px)
        for side, px in zip(scene.camera.sensor_m, scene.camera.image_px, strict=True)
    )
    half = [side / (2 * scene.camera.focal_length_m) for side in scene.camera.sensor_m]
    reach_m = scene.demand.gsd_max_m / pixel * (math.sqrt(1 + max(half) ** 2) + min(half) ** 2)
    reach_m = max(reach_m, scene.room.clearance_m + scene.solids.cell_m)
    rise = np.where(np.abs(rise) < 1e-9, 1e-9, rise)
    ends = np.stack([low_m / rise, high_m / rise])
    return np.maximum(ends.min(axis=0), 0.0), np.minimum(ends.max(axis=0), reach_m)


def _unblocked_m(scene: _Scene, patch: NDArray[np.int64], way: FloatArray, far_m: FloatArray) -> FloatArray:
    """How far along each ray a place may keep the clearance of what ends it, `far_m` at the most.

    Sight begins before the patch, up to a cell beside the ray.
    """
    before = scene.patches.before_enu_m[patch]
    end = scene.patches.centre_enu_m[patch] + far_m[:, None] * way
    share = free_share(scene.site, before, end - before)
    room_m = scene.room.clearance_m - scene.solids.cell_m
    return np.where(share < 1.0, share * far_m - room_m, far_m)


def _nearest_safe_m(
    solids: Solids,
    start_enu_m: FloatArray,
    way: FloatArray,
    near_m: FloatArray,
    far_m: FloatArray,
    clearance_m: float,
) -> FloatArray:
    """How far along each ray the first place is that keeps the clearance, infinity where none does."""
    at_m = np.maximum(near_m, clearance_m - solids.cell_m)
    found = np.full(len(at_m), np.inf)
    live = np.flatnonzero(at_m <= far_m)
    for _ in range(STEPS_MAX):
        if not len(live):
            break
        lacking_m = clearance_m - solids.distance_m(start_enu_m[live] + at_m[live, None] * way[live])
        safe = lacking_m <= 0.0
        found[live[safe]] = at_m[live[safe]]
        live, lacking_m = live[~safe], lacking_m[~safe]
        at_m[live] += np.maximum(lacking_m, NEARER_M)
        live = live[at_m[live] <= far_m[live]]
    return found
