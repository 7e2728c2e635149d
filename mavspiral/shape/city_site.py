"""A site from a city model: the building that is meant, cut to cells from its faces, and its neighbours."""

from __future__ import annotations

import math

import cv2
import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.choice import choose, near, stand_in_height_m
from mavspiral.shape.cityjson import CityBuilding, CityMap, Indices
from mavspiral.shape.crs import map_crs
from mavspiral.shape.datum import datum_of
from mavspiral.shape.geojson import Feature
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.polygons import crossing
from mavspiral.shape.site_map import SURROUNDINGS_M, MapRequest, SiteMap, grid_about, judge_top
from mavspiral.shape.surfaces import raise_triangles, triangles_of

__all__ = ["site_from_city"]

Faces = tuple[tuple[FloatArray, ...], ...]
WALL_M = 0.002
"""A face that is not wider in plan is a wall."""

ROUNDING_M = 0.05


def site_from_city(request: MapRequest, city: CityMap) -> SiteMap:
    """The site of the building that the request names in the city model.

    Raises:
        InputError: it is not there, has no heights, crosses itself, or stands on another ground than the mission's.
    """
    crs = map_crs(
        request, city.crs, "state metadata.referenceSystem, e.g. with cjio IN crs_assign 7415 save OUT"
    )
    if crs.geographic:
        raise InputError(
            f"{request.path}: its heights stand on degrees ({crs.name}). Fix: reproject it, e.g. to its UTM zone"
        )
    lat_deg, lon_deg = crs.lat_lon_deg(city.corners[:, 0], city.corners[:, 1])
    places = np.column_stack([lat_deg, lon_deg])
    z_m = city.corners[:, 2] * crs.height_unit_m
    flat = {b.id: _lying(b, city.corners) for b in city.buildings}
    features = {
        b.id: Feature(b.id, b.name, False, None, tuple(tuple(places[r] for r in face) for face in flat[b.id]))
        for b in city.buildings
        if b.is_building and flat[b.id]
    }
    if not features:
        raise InputError(f"{request.path}: none of its buildings has a roof. Fix: export surfaces or solids")
    seed = choose(request, tuple(features.values()))[0]
    chosen = next(b for b in city.buildings if b.id == seed.id)
    if chosen.level < 1.0:
        raise InputError(
            f"{request.path}: {chosen.name} has only a footprint (LoD 0). Fix: export LoD 1 or more, or use GeoJSON with heights"
        )
    numbers = np.concatenate([ring for face in chosen.faces for ring in face])
    datum_m, said = datum_of(request, float(z_m[numbers].min()), f"the foot of {chosen.name}")
    own_places = places[np.concatenate([ring for face in flat[chosen.id] for ring in face])]
    middle = (own_places.min(axis=0) + own_places.max(axis=0)) / 2.0
    frame = LocalFrame(GeoPoint(float(middle[0]), float(middle[1]), request.ground_amsl_m))
    plan = frame.to_enu(lat_deg, lon_deg, request.ground_amsl_m)[:, :2]
    corners = np.column_stack([plan, z_m - datum_m])

    def solid(building: CityBuilding) -> Faces:
        return tuple(tuple(corners[ring] for ring in face) for face in flat[building.id])

    _judge_crossings(request, chosen, solid(chosen), frame)
    own = np.concatenate([triangles_of(face) for face in solid(chosen)])
    judge_top(request.path, float(own[:, :, 2].max()))
    half = np.abs(own[:, :, :2]).max(axis=(0, 1))
    reach = half + SURROUNDINGS_M
    others = [b for b in city.buildings if b is not chosen and flat[b.id] and near(solid(b), reach)]
    tall_m = stand_in_height_m(
        float(corners[np.concatenate([r for f in b.faces for r in f]), 2].max())
        for b in (chosen, *others)
        if b.level >= 1.0
    )
    triangles, warnings = (
        [np.zeros((0, 3, 3))],
        [*crs.warnings, f"{chosen.name}: LoD {chosen.level:g} was read", *said],
    )
    for building in others:
        pieces, remark = _obstacle(building, solid(building), tall_m)
        triangles.append(pieces)
        warnings += remark
    around = np.concatenate(triangles)
    extent = np.maximum(half, np.minimum(np.abs(around[:, :, :2]).max(axis=(0, 1), initial=0.0), reach))

    shape, south_west = grid_about(request, extent)
    height, own_height = np.zeros(shape), np.full(shape, -np.inf)
    raise_triangles(request, height, around, *south_west)
    raise_triangles(request, own_height, own, *south_west)
    judge_top(request.path, float(height.max()))
    heights = HeightMap(np.maximum(height, own_height), request.cell_m, frame, np.array(south_west))
    # On a party wall the cell is the higher house's, so that a taller neighbour does not raise the building.
    building = np.isfinite(own_height) & (own_height >= height)
    return SiteMap(Site(heights, building), chosen.name, tuple(warnings))


def _lying(building: CityBuilding, corners: FloatArray) -> tuple[tuple[Indices, ...], ...]:
    """The building's faces but for its walls."""
    return tuple(face for face in building.faces if _width_m(corners[face[0]]) > WALL_M)


def _width_m(ring: FloatArray) -> float:
    """How far the ring's corners stray in plan from the line that fits them best, as a standard deviation."""
    x, y = (ring[:, :2] - ring[:, :2].mean(axis=0)).T
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    least = (xx + yy - math.hypot(xx - yy, 2 * xy)) / 2.0
    return math.sqrt(max(least, 0.0) / len(x))


def _crossing(ring: FloatArray) -> FloatArray | None:
    """Where the ring crosses itself in plan; a nearly upright face may, as its corners are rounded."""
    return crossing(ring[:, :2], touching=False) if _width_m(ring) > ROUNDING_M else None


def _judge_crossings(request: MapRequest, chosen: CityBuilding, faces: Faces, frame: LocalFrame) -> None:
    for face in faces:
        for ring in face:
            place = _crossing(ring)
            if place is not None:
                lat, lon, _ = frame.to_geodetic([place[0], place[1], 0.0])
                raise InputError(
                    f"{request.path}: a face of {chosen.name} crosses itself near lat {float(lat):.6f}, lon {float(lon):.6f}. "
                    "Fix: put its corners in order (val3dity finds them)"
                )


def _obstacle(building: CityBuilding, faces: Faces, tall_m: float) -> tuple[FloatArray, list[str]]:
    """A neighbour's triangles; what is not known of it makes it larger, never smaller."""
    remarks = []
    if building.level < 1.0:
        remarks = [f"{building.name} has no height and stands near: it is taken to be {tall_m:.1f} m high"]
        faces = tuple(
            tuple(np.column_stack([r[:, :2], np.full(len(r), tall_m)]) for r in face) for face in faces
        )
    pieces = []
    for face in faces:
        if any(_crossing(ring) is not None for ring in face):
            hull = cv2.convexHull(face[0][:, :2].astype(np.float32))[:, 0, :].astype(np.float64)
            face = (np.column_stack([hull, np.full(len(hull), face[0][:, 2].max())]),)
            remarks.append(f"a face of {building.name} crosses itself: all within it is taken to be solid")
        pieces.append(triangles_of(face))
    return np.concatenate(pieces), remarks
