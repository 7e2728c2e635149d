"""Buildings from CityJSON 1.1 and 2.0, whole files and sequences of features.

https://www.cityjson.org/specs/2.0.1/. Of every building and its parts the highest level of detail of at least 1
is taken. Its faces count whichever way they are wound: over closed shells the highest face is the roof.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError

__all__ = ["CityBuilding", "CityMap", "Indices", "city_map", "is_cityjson"]

Indices = NDArray[np.int64]
BUILDING = ("Building", "BuildingPart", "BuildingInstallation")
OTHERS = ("Bridge", "BridgePart", "OtherConstruction", "SolitaryVegetationObject", "CityFurniture")
SOLIDS = ("Solid", "MultiSolid", "CompositeSolid")
SURFACES = ("MultiSurface", "CompositeSurface")

_EPSG = re.compile(r"EPSG(?:/[^/]*/|:[^:]*:|:)(\d{4,6})$", re.IGNORECASE)


@dataclass(frozen=True, slots=True, eq=False)
class CityBuilding:
    """One object with its parts: faces of corner numbers (outline, then holes). Level 0 has no heights."""

    id: str
    name: str
    is_building: bool
    level: float
    faces: tuple[tuple[Indices, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class CityMap:
    """All objects, their common corners `(n, 3)` in the file's own axes, and which axes these are, if it says so."""

    crs: str | None
    corners: FloatArray
    buildings: tuple[CityBuilding, ...]


def is_cityjson(document: Any) -> bool:
    """Whether the document says that it is CityJSON."""
    return isinstance(document, dict) and document.get("type") in ("CityJSON", "CityJSONFeature")


def city_map(path: Path, documents: list[Any]) -> CityMap:
    """The buildings of one CityJSON document, or of a first one and the features that follow it.

    Raises:
        InputError: not CityJSON 1.1 or 2.0, no buildings, or one that cannot be believed.
    """
    head = documents[0] if documents else None
    if not isinstance(head, dict) or head.get("type") != "CityJSON":
        raise InputError(
            f"{path}: it does not begin with a CityJSON object. Fix: export the map as CityJSON 1.1 or 2.0"
        )
    version = str(head.get("version"))
    if version not in ("1.1", "2.0"):
        raise InputError(
            f"{path}: CityJSON {version[:20]} is not read. Fix: upgrade it to 2.0 (cjio upgrade)"
        )
    scale, shift = _transform(path, head)
    corners, buildings, count = [], [], 0
    for number, document in enumerate(documents, start=1):
        if not is_cityjson(document):
            raise InputError(
                f"{path}: line {number} is no CityJSONFeature. Fix: export the map as CityJSONSeq"
            )
        own = _corners(path, document.get("vertices")) * scale + shift
        if not np.isfinite(own).all():
            raise InputError(f"{path}: a vertex is not finite. Fix: correct 'vertices' and 'transform'")
        buildings += _buildings(path, document.get("CityObjects"), count, len(own))
        corners.append(own)
        count += len(own)
    if not any(b.is_building and b.faces for b in buildings):
        raise InputError(
            f"{path}: it holds no building with a geometry. Fix: export its Building objects too"
        )
    return CityMap(_crs(head), np.concatenate(corners), tuple(b for b in buildings if b.faces))


def _crs(head: dict[str, Any]) -> str | None:
    metadata = head.get("metadata")
    text = metadata.get("referenceSystem") if isinstance(metadata, dict) else None
    found = _EPSG.search(str(text).rstrip("/"))
    return None if text is None or found is None else f"EPSG:{found[1]}"


def _transform(path: Path, head: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
    raw = head.get("transform")
    try:
        scale, shift = (np.array([float(v) for v in raw[key]]) for key in ("scale", "translate"))  # type: ignore[index]  # None is judged below
    except (TypeError, KeyError, ValueError, OverflowError):
        scale = shift = np.zeros(0)
    if scale.shape != (3,) or shift.shape != (3,) or not np.isfinite([scale, shift]).all():
        raise InputError(
            f"{path}: it has no transform of scale and translate. Fix: export it as CityJSON 2.0"
        )
    return scale, shift


def _corners(path: Path, raw: Any) -> FloatArray:
    try:
        corners = np.array(raw, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        corners = np.zeros((1, 0))
    if corners.shape == (0,):
        return np.zeros((0, 3))
    if corners.ndim != 2 or corners.shape[1] != 3:
        raise InputError(f"{path}: its vertices are not triples of numbers. Fix: export it as CityJSON 2.0")
    return corners


def _buildings(path: Path, raw: Any, first: int, corners: int) -> list[CityBuilding]:
    if raw is None:
        return []
    if not isinstance(raw, dict) or not all(isinstance(thing, dict) for thing in raw.values()):
        raise InputError(f"{path}: its CityObjects are no objects by name. Fix: export it as CityJSON 2.0")
    made = []
    for name, thing in raw.items():
        kind = thing.get("type")
        orphan = not any(str(parent) in raw for parent in _listed(thing.get("parents")))
        if kind not in BUILDING + OTHERS or not orphan:
            continue
        family = [name, *_descendants(raw, name)]
        best = {key: _best(path, key, raw[key]) for key in family}
        level = max(found[0] for found in best.values())
        if best[name][0] < level:  # a block around the parts, which say it better
            best.pop(name)
        kept = [(key, found) for key, found in best.items() if found[0] >= min(level, 1.0)]
        faces = tuple(
            face for key, (_, geometry) in kept for face in _faces(path, key, geometry, first, corners)
        )
        attributes = thing.get("attributes")
        title = attributes.get("name") if isinstance(attributes, dict) else None
        made.append(CityBuilding(str(name), str(title or name), kind in BUILDING, max(level, 0.0), faces))
    return made


def _listed(raw: Any) -> list[Any]:
    return raw if isinstance(raw, list) else []


def _descendants(raw: dict[str, Any], name: str) -> list[str]:
    found: dict[str, None] = {}
    waiting = [name]
    while waiting:
        for child in _listed(raw[waiting.pop()].get("children")):
            key = str(child)
            if key != name and key not in found and raw.get(key, {}).get("type") in BUILDING + OTHERS:
                found[key] = None
                waiting.append(key)
    return list(found)


def _best(path: Path, name: str, thing: dict[str, Any]) -> tuple[float, Any]:
    """The level of the object's most detailed geometry, and it; -1 and None without any."""
    best: tuple[float, Any] = (-1.0, None)
    for geometry in _listed(thing.get("geometry")):
        if not isinstance(geometry, dict) or geometry.get("type") not in SOLIDS + SURFACES:
            continue
        try:
            level = float(geometry.get("lod", 0))
        except (TypeError, ValueError, OverflowError):
            level = -1.0
        if not 0 <= level < 4:
            raise InputError(
                f"{path}: {name} has the level of detail {str(geometry.get('lod'))[:20]!r}. Fix: give 0 to 3.3"
            )
        if level > best[0]:
            best = (level, geometry)
    return best


def _faces(path: Path, name: str, geometry: Any, first: int, corners: int) -> list[tuple[Indices, ...]]:
    if geometry is None:
        return []
    kind, lists = geometry["type"], _listed(geometry.get("boundaries"))
    if kind in SOLIDS:
        # A solid's first shell is its outside; the others are hollows in it.
        solids = [lists] if kind == "Solid" else lists
        faces = [face for solid in solids for shell in _listed(solid)[:1] for face in _listed(shell)]
    else:
        faces = lists
    made = []
    for face in faces:
        try:
            rings = tuple(np.array(ring, dtype=np.int64) for ring in face)
        except (TypeError, ValueError, OverflowError):
            rings = ()
        if not rings or any(r.ndim != 1 or len(r) < 3 or r.min() < 0 or r.max() >= corners for r in rings):
            raise InputError(
                f"{path}: a face of {name} has no three corners, or one that is not among the {corners} vertices. "
                "Fix: validate the file (cjval) and export it anew"
            )
        made.append(tuple(ring + first for ring in rings))
    return made
