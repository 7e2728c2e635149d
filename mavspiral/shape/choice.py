"""Which of a map's buildings is meant, and which of the others are near enough to matter."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.geojson import DEGREE_M, Feature
from mavspiral.shape.polygons import contains
from mavspiral.shape.site_map import MapRequest

__all__ = ["choose", "near", "stand_in_height_m"]

FAR_M = 50_000.0
"""A place farther than this from all buildings of a map is of another map."""
TOUCH_M = 0.5
"""Parts whose boxes are no farther apart hang together."""
UNKNOWN_M = 30.0
"""How tall an obstacle is taken to be in a map without any height."""


def choose(request: MapRequest, features: tuple[Feature, ...]) -> tuple[Feature, ...]:
    """The building that the request names, with its parts.

    Raises:
        InputError: it is not there, or several could be meant.
    """
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
        whole = next((f for f in features if not f.is_part and _holds(f, *_interior(seed))), None)
        if whole is None:
            return _touching(seed, tuple(f for f in features if f.is_part))
        seed = whole
    inside = (f for f in features if f.is_part and _holds(seed, *_interior(f)))
    return (seed, *inside)


def _touching(seed: Feature, parts: tuple[Feature, ...]) -> tuple[Feature, ...]:
    """The parts that hang together with `seed`: the box of each is within `TOUCH_M` of another's."""
    found, left = [seed], [f for f in parts if f is not seed]
    for here in found:
        low, high = _box(here)
        margin = TOUCH_M / DEGREE_M * np.array([1.0, 1.0 / max(math.cos(math.radians(low[0])), 1e-3)])
        for other in list(left):
            other_low, other_high = _box(other)
            if np.all(other_low <= high + margin) and np.all(other_high >= low - margin):
                found.append(other)
                left.remove(other)
    return tuple(found)


def _box(feature: Feature) -> tuple[FloatArray, FloatArray]:
    corners = np.vstack([rings[0] for rings in feature.polygons_deg])
    return corners.min(axis=0), corners.max(axis=0)


def _holds(feature: Feature, lat_deg: float, lon_deg: float) -> bool:
    place = (lat_deg, lon_deg)
    return any(
        contains(rings, lat_deg, lon_deg)
        for rings in feature.polygons_deg
        if np.all(rings[0].min(axis=0) <= place) and np.all(rings[0].max(axis=0) >= place)
    )


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
    if away_m(nearest) > FAR_M:
        return (
            f"{request.path}: its buildings lie at [{lat:.6f}, {lon:.6f}], far away from [building] at = "
            f"[{request.at[0]}, {request.at[1]}]. Fix: correct the map's CRS, or set at (latitude first)"
        )
    return (
        f"{request.path}: no building stands at [{request.at[0]}, {request.at[1]}]; the nearest, {nearest.name}, "
        f"is {away_m(nearest):.0f} m away. Fix: set [building] at = [{lat:.6f}, {lon:.6f}] (latitude first)"
    )


def stand_in_height_m(heights_m: Iterable[float | None]) -> float:
    """An obstacle without a height is taken to be as tall as the tallest thing in the map."""
    return max((h for h in heights_m if h is not None), default=UNKNOWN_M)


def near(plan_m: tuple[tuple[FloatArray, ...], ...], reach_m: FloatArray) -> bool:
    """Whether any of the polygons `(n, 2 or 3)` may come within `reach_m (2,)` of the origin on either axis."""
    points = np.vstack([ring for rings in plan_m for ring in rings])[:, :2]
    return bool(np.all(points.min(axis=0) < reach_m) and np.all(points.max(axis=0) > -reach_m))
