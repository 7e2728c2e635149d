"""A site from footprints: the building that is meant, its parts, and its neighbours as obstacles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.choice import choose, near, stand_in_height_m
from mavspiral.shape.geojson import LEVEL_M, Feature
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.polygons import cover
from mavspiral.shape.site_map import SURROUNDINGS_M, MapRequest, SiteMap, grid_about

__all__ = ["site_from_footprints"]


def site_from_footprints(request: MapRequest, features: tuple[Feature, ...]) -> SiteMap:
    """The site of the building that the request names among the features.

    Raises:
        InputError: it is not there, several could be meant, or it has no height.
    """
    chosen = choose(request, features)
    corners = np.vstack([ring for f in chosen for rings in f.polygons_deg for ring in rings])
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    frame = LocalFrame(GeoPoint(float(middle[0]), float(middle[1]), request.ground_amsl_m))

    def plan_m(feature: Feature) -> tuple[tuple[FloatArray, ...], ...]:
        return tuple(
            tuple(frame.to_enu(r[:, 0], r[:, 1], request.ground_amsl_m)[:, :2] for r in rings)
            for rings in feature.polygons_deg
        )

    chosen_plan = [plan_m(f) for f in chosen]
    half = np.abs(np.vstack([ring for plan in chosen_plan for rings in plan for ring in rings])).max(axis=0)
    reach = half + SURROUNDINGS_M
    others = [(f, plan) for f in features if f not in chosen for plan in [plan_m(f)] if near(plan, reach)]
    extent = half.copy()
    for _, plan in others:
        points = np.abs(np.vstack([ring for rings in plan for ring in rings])).max(axis=0)
        extent = np.maximum(extent, np.minimum(points, reach))

    shape, south_west = grid_about(request, extent)
    west, south = south_west

    def laid(plan: tuple[tuple[FloatArray, ...], ...]) -> NDArray[np.bool_]:
        mask = np.zeros(shape, dtype=np.bool_)
        for rings in plan:
            mask |= cover(rings, west, south, request.cell_m, shape)
        return mask

    warnings: list[str] = []
    height, building = np.zeros(shape), np.zeros(shape, dtype=np.bool_)
    for feature, plan in others:
        mask = laid(plan)
        tall = feature.height_agl_m
        if tall is None:
            tall = stand_in_height_m(f.height_agl_m for f in features)
            warnings.append(
                f"{feature.name} has no height and stands near: it is taken to be {tall:.1f} m high"
            )
        height[mask] = np.maximum(height[mask], tall)
    parts = [f for f in chosen if f.is_part]
    lowest_part = min((_known_height_m(request, f) for f in parts), default=0.0)
    own = np.zeros(shape)
    for feature, plan in zip(chosen, chosen_plan, strict=True):
        mask = laid(plan)
        is_outline = bool(parts) and not feature.is_part
        own[mask] = np.maximum(own[mask], lowest_part if is_outline else _known_height_m(request, feature))
        building |= mask
    if guessed := [f for f in chosen if f.height_is_guessed and (f.is_part or not parts)]:
        told = ", ".join(f"{f.name} {f.height_agl_m:g} m" for f in guessed[:3]) + (
            " …" if len(guessed) > 3 else ""
        )
        warnings.append(
            f"the height is guessed from storeys of {LEVEL_M:g} m: {told}. Fix: tag height, or a larger [building] map_error_m"
        )
    building &= own >= height  # on a party wall the cell is the higher house's
    site = Site(HeightMap(np.maximum(height, own), request.cell_m, frame, np.array(south_west)), building)
    return SiteMap(site, chosen[0].name, tuple(warnings))


def _known_height_m(request: MapRequest, feature: Feature) -> float:
    if feature.height_agl_m is None:
        raise InputError(
            f"{request.path}: {feature.name} has neither 'height' nor 'building:levels'. "
            'Fix: add "height": "34" (metres above ground) to its properties'
        )
    return feature.height_agl_m
