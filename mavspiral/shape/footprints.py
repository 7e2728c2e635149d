"""A site from footprints: the building that is meant, its parts, and its neighbours as obstacles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.geojson import Feature
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.polygons import contains, cover
from mavspiral.shape.site_map import MapRequest, SiteMap, judge_size

__all__ = ["site_from_footprints"]

SURROUNDINGS_M = 150.0
"""Other buildings are obstacles out to this distance from the building's bounding box."""


def site_from_footprints(request: MapRequest, features: tuple[Feature, ...]) -> SiteMap:
    """The site of the building that the request names among the features.

    Raises:
        InputError: it is not there, several could be meant, or it has no height.
    """
    chosen = _choose(request, features)
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
    others = [(f, plan) for f in features if f not in chosen for plan in [plan_m(f)] if _near(plan, reach)]
    extent = half.copy()
    for _, plan in others:
        points = np.abs(np.vstack([ring for rings in plan for ring in rings])).max(axis=0)
        extent = np.maximum(extent, np.minimum(points, reach))

    shape, south_west = _grid(request, extent)
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
            tall = _stand_in_height_m(features)
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
    site = Site(HeightMap(np.maximum(height, own), request.cell_m, frame, np.array(south_west)), building)
    return SiteMap(site, chosen[0].name, tuple(warnings))


def _choose(request: MapRequest, features: tuple[Feature, ...]) -> tuple[Feature, ...]:
    outlines = [f for f in features if not f.is_part] or list(features)
    if request.id is not None:
        named = [f for f in features if f.id == request.id]
        if not named:
            known = ", ".join(f.id for f in outlines[:6])
            raise InputError(f"{request.path}: no building has id {request.id!r}. Fix: it knows {known}")
        seed = named[0]
    elif request.at is not None:
        holding = [f for f in outlines if _holds(f, *request.at)] or [
            f for f in features if _holds(f, *request.at)
        ]
        if not holding:
            raise InputError(_nobody_there(request, features))
        seed = holding[0]
    elif len(outlines) == 1 or all(f.is_part for f in outlines):
        seed = outlines[0]
    else:
        known = "; ".join(f"{f.name} at [{_middle(f)[0]:.5f}, {_middle(f)[1]:.5f}]" for f in outlines[:4])
        raise InputError(
            f"{request.path}: it holds {len(outlines)} buildings and the mission names none. "
            f"Fix: set [building] at = [lat, lon], e.g. {known}"
        )
    if seed.is_part:
        return (seed, *(f for f in features if f.is_part and f is not seed and request.id is None))
    inside = (f for f in features if f.is_part and _holds(seed, *_interior(f)))
    return (seed, *inside)


def _holds(feature: Feature, lat_deg: float, lon_deg: float) -> bool:
    return any(contains(rings, lat_deg, lon_deg) for rings in feature.polygons_deg)


def _middle(feature: Feature) -> tuple[float, float]:
    corners = np.vstack([rings[0] for rings in feature.polygons_deg])
    lat, lon = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    return float(lat), float(lon)


def _interior(feature: Feature) -> tuple[float, float]:
    """A point inside the feature: its middle, or beside a corner when that lies in a hollow."""
    middle = _middle(feature)
    if _holds(feature, *middle):
        return middle
    ring = feature.polygons_deg[0][0]
    for corner, before, after in zip(ring, np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0), strict=True):
        inner = corner + 1e-3 * ((before - corner) + (after - corner))
        if _holds(feature, float(inner[0]), float(inner[1])):
            return float(inner[0]), float(inner[1])
    return middle


def _nobody_there(request: MapRequest, features: tuple[Feature, ...]) -> str:
    assert request.at is not None
    frame = LocalFrame(GeoPoint(*request.at, 0.0))

    def away_m(feature: Feature) -> float:
        corners = np.vstack([rings[0] for rings in feature.polygons_deg])
        return float(np.hypot(*frame.to_enu(corners[:, 0], corners[:, 1], 0.0)[:, :2].T).min())

    nearest = min(features, key=away_m)
    lat, lon = _interior(nearest)
    return (
        f"{request.path}: no building stands at [{request.at[0]}, {request.at[1]}]; the nearest, {nearest.name}, "
        f"is {away_m(nearest):.0f} m away. Fix: set [building] at = [{lat:.6f}, {lon:.6f}] (latitude first)"
    )


def _known_height_m(request: MapRequest, feature: Feature) -> float:
    if feature.height_agl_m is None:
        raise InputError(
            f"{request.path}: {feature.name} has neither 'height' nor 'building:levels'. "
            'Fix: add "height": "34" (metres above ground) to its properties'
        )
    return feature.height_agl_m


def _stand_in_height_m(features: tuple[Feature, ...]) -> float:
    """An obstacle without a height is taken to be as tall as the tallest thing in the map."""
    return max((f.height_agl_m for f in features if f.height_agl_m is not None), default=30.0)


def _near(plan: tuple[tuple[FloatArray, ...], ...], reach_m: FloatArray) -> bool:
    points = np.vstack([ring for rings in plan for ring in rings])
    return bool(np.all(points.min(axis=0) < reach_m) and np.all(points.max(axis=0) > -reach_m))


def _grid(request: MapRequest, half_extent_m: FloatArray) -> tuple[tuple[int, int], tuple[float, float]]:
    cols, rows = (2 * math.ceil(h / request.cell_m) + 2 for h in half_extent_m)
    judge_size(request, rows, cols)
    return (rows, cols), (-cols / 2 * request.cell_m, -rows / 2 * request.cell_m)
