"""Buildings from GeoJSON with OpenStreetMap's Simple 3D Buildings tags.

https://wiki.openstreetmap.org/wiki/Simple_3D_Buildings: `building`, `building:part`, `height`, `min_height`,
`building:levels`, and on these `roof:height` or `roof:levels`. Where a building has parts, they give its shape and its
outline's own height does not count.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.shape.polygons import crossing, signed_area_m2

__all__ = ["DEGREE_M", "LEVEL_M", "Feature", "features_of"]

CORNERS_MAX = 20_000
DEGREE_M = 111_320.0
"""A degree of latitude, as exactly as it takes to tell whether corners cross or touch."""

LEVEL_M = 3.0
"""A storey's height where only `building:levels` is tagged (the wiki's own figure)."""

_HEIGHT = re.compile(r"^\s*(\d+(?:[.,]\d+)?)\s*(m|ft|'|)\s*$")
_FEET_AND_INCHES = re.compile(r"^\s*(\d+)'\s*(\d+(?:\.\d+)?)\"\s*$")


@dataclass(frozen=True, slots=True, eq=False)
class Feature:
    """One building or part: its polygons (outline, then holes) as `(n, 2)` latitude, longitude."""

    id: str
    name: str
    is_part: bool
    height_agl_m: float | None
    polygons_deg: tuple[tuple[FloatArray, ...], ...]
    height_is_guessed: bool = False


def features_of(path: Path, document: Any) -> tuple[Feature, ...]:
    """Every building and building part in the document, in its order.

    Raises:
        InputError: not GeoJSON, no buildings, or a feature that cannot be believed.
    """
    if not isinstance(document, dict) or not isinstance(document.get("features"), list):
        raise InputError(
            f"{path}: no FeatureCollection with 'features'. Fix: export the map as a GeoJSON FeatureCollection"
        )
    features = [
        _feature(path, number, raw)
        for number, raw in enumerate(document["features"], start=1)
        if _is_building(raw)
    ]
    if not features:
        raise InputError(
            f"{path}: none of its {len(document['features'])} features is tagged 'building' or 'building:part'. "
            'Fix: add "building": "yes" and "height" to the footprint\'s properties'
        )
    return tuple(features)


def _tags(raw: Any) -> dict[str, Any]:
    properties = raw.get("properties") if isinstance(raw, dict) else None
    if not isinstance(properties, dict):
        return {}
    tags = properties.get("tags")
    return {**properties, **tags} if isinstance(tags, dict) else properties


def _is_building(raw: Any) -> bool:
    tags = _tags(raw)
    tagged = tags.get("building") or tags.get("building:part")
    geometry = raw.get("geometry") if isinstance(raw, dict) else None
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    return bool(tagged) and tagged != "no" and kind in ("Polygon", "MultiPolygon")


def _feature(path: Path, number: int, raw: dict[str, Any]) -> Feature:
    tags = _tags(raw)
    identity = str(raw.get("id") or tags.get("@id") or tags.get("id") or f"feature {number}")
    name = " ".join(str(tags.get("name") or identity).split())
    where = f"{path}: {name}"
    geometry = raw["geometry"]
    coordinates = geometry.get("coordinates")
    polygons = [coordinates] if geometry["type"] == "Polygon" else coordinates
    if not isinstance(polygons, list) or not polygons:
        raise InputError(
            f"{where}: its geometry has no coordinates. Fix: give a closed ring of [lon, lat] pairs"
        )
    return Feature(
        id=identity,
        name=name,
        is_part=bool(tags.get("building:part")) and tags.get("building:part") != "no",
        height_agl_m=_height_m(where, tags),
        height_is_guessed=tags.get("height") is None and tags.get("building:levels") is not None,
        polygons_deg=tuple(_polygon(where, polygon) for polygon in polygons),
    )


def _polygon(where: str, rings: Any) -> tuple[FloatArray, ...]:
    if not isinstance(rings, list) or not rings:
        raise InputError(f"{where}: a polygon has no rings. Fix: give a closed ring of [lon, lat] pairs")
    return tuple(_ring(where, ring) for ring in rings)


def _ring(where: str, ring: Any) -> FloatArray:
    try:
        points = np.array([[float(point[1]), float(point[0])] for point in ring], dtype=np.float64)
    except (TypeError, ValueError, IndexError, OverflowError):
        raise InputError(
            f"{where}: a ring holds something that is no [lon, lat] pair. Fix: GeoJSON wants numbers"
        ) from None
    if len(points) > 1 and np.array_equal(points[0], points[-1]):
        points = points[:-1]
    keep = np.any(points != np.roll(points, 1, axis=0), axis=1) if len(points) else np.zeros(0, dtype=bool)
    points = points[keep]
    if len(points) < 3:
        raise InputError(
            f"{where}: a ring has {len(points)} different corners, at least 3 are needed. Fix: close the footprint"
        )
    if not np.isfinite(points).all() or np.any(np.abs(points) > (90.0, 180.0)):
        worst = points[
            np.argmax(~np.isfinite(points).all(axis=1) | np.any(np.abs(points) > (90.0, 180.0), axis=1))
        ]
        raise InputError(
            f"{where}: corner [lon {worst[1]}, lat {worst[0]}] is not on the earth in degrees. "
            "Fix: GeoJSON is [lon, lat] in WGS-84; reproject the map to EPSG:4326"
        )
    if len(points) > CORNERS_MAX:
        raise InputError(
            f"{where}: a ring has {len(points):,} corners, at most {CORNERS_MAX:,} are read. Fix: simplify the outline"
        )
    if np.ptp(points[:, 1]) > 180.0:
        raise InputError(
            f"{where}: a ring spans {np.ptp(points[:, 1]):.0f}° of longitude; a map across the 180th meridian cannot be read. "
            "Fix: shift the map and at by a degree to rehearse"
        )
    scale = np.array([1.0, math.cos(math.radians(points[0, 0]))])
    flat = (points - points[0]) * scale * DEGREE_M
    cross = crossing(flat)
    if cross is not None:
        lat, lon = points[0] + cross / (scale * DEGREE_M)
        raise InputError(
            f"{where}: its outline crosses itself near lat {lat:.6f}, lon {lon:.6f}. "
            "Fix: put the corners in order around the building"
        )
    if abs(signed_area_m2(flat)) < 1e-3:
        raise InputError(
            f"{where}: its outline encloses no area. Fix: put the corners in order around the building"
        )
    return points


def _height_m(where: str, tags: dict[str, Any]) -> float | None:
    if tags.get("height") is not None:
        return _length_m(where, "height", tags["height"])
    if tags.get("building:levels") is not None:
        walls_m = _levels_m(where, "building:levels", tags["building:levels"])
        if tags.get("roof:height") not in (None, "0", 0):
            return walls_m + _length_m(where, "roof:height", tags["roof:height"])
        if tags.get("roof:levels") not in (None, "0", 0):
            return walls_m + _levels_m(where, "roof:levels", tags["roof:levels"])
        return walls_m
    return None


def _levels_m(where: str, key: str, value: Any) -> float:
    try:
        levels = float(str(value).replace(",", "."))
    except ValueError:
        levels = math.nan
    if not 0 < levels < 300:
        raise InputError(
            f"{where}: {key} = {value!r} is no number of storeys between 1 and 300. "
            'Fix: tag "height" in metres instead'
        )
    return levels * LEVEL_M


def _length_m(where: str, key: str, value: Any) -> float:
    text = str(value)
    plain, inches = _HEIGHT.match(text), _FEET_AND_INCHES.match(text)
    if inches:
        length = (float(inches[1]) + float(inches[2]) / 12.0) * 0.3048
    elif plain:
        length = float(plain[1].replace(",", ".")) * (0.3048 if plain[2] in ("ft", "'") else 1.0)
    else:
        length = math.nan
    if not 0 < length < 1500:
        raise InputError(
            f'{where}: {key} = {value!r} is no height between 0 and 1500 m. Fix: write metres ("34" or "34 m") or feet ("112 ft")'
        )
    return length
