"""A site from a mesh (STL, OBJ, PLY): its top surface, stood at a place.

A mesh knows neither unit nor place nor which axis is up, so the mission says: `units`, `up`, `at` (where the mesh's
origin stands) and `heading_deg` (where its plan's north points, clockwise from true north). Its height 0 is the ground.
With `up = "y"` its x is east and its −z north.
"""

from __future__ import annotations

import io
import math
import re

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.height_grid import BUILDING_MIN_M, component_at, site_about
from mavspiral.shape.site_map import MapRequest, SiteMap, judge_bytes, judge_size, judge_top, need
from mavspiral.shape.surfaces import raise_triangles

__all__ = ["site_from_mesh"]

MOST_MB = 300
UNITS_M = {"m": 1.0, "mm": 1e-3, "ft": 0.3048}
FLOATING_M = 5.0
FAR_M = 20_000.0
_PLY_ELEMENT = re.compile(rb"^element[ \t]+\S+[ \t]+(\d+)", re.MULTILINE)


def site_from_mesh(request: MapRequest) -> SiteMap:
    """The site of the mesh that the request names.

    Raises:
        InputError: the request does not say how it stands, or it is no mesh of a building.
    """
    path = request.path
    for key, example in (("units", '"m"'), ("up", '"z"'), ("at", "[19.4339, -99.1406]")):
        if getattr(request, key) is None:
            raise InputError(
                f"{path}: a mesh does not say its {key} itself. Fix: set [building] {key} = {example}"
                + (" where the mesh's origin stands" if key == "at" else "")
            )
    assert request.at is not None
    triangles = _stood(request, _triangles(request))
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    away_m = float(np.abs([low[:2], high[:2]]).max())
    if not away_m <= FAR_M:
        raise InputError(
            f"{path}: it reaches {away_m:.3g} m from its own origin, at which [building] at stands. "
            "Fix: move the mesh to its origin (subtract its survey coordinates), or check units"
        )
    judge_top(path, float(high[2]))
    if low[2] > FLOATING_M:
        raise InputError(
            f"{path}: its lowest point is {low[2]:.1f} m above its own zero, which is the ground. "
            f"Fix: move the mesh down by {low[2]:.1f} m, or check units and up"
        )
    cell_m = request.cell_m
    west, south = (math.floor(v / cell_m) - 1 for v in low[:2])
    judge_size(request, high[1] / cell_m - south + 2, high[0] / cell_m - west + 2)
    cols, rows = math.floor(high[0] / cell_m) - west + 2, math.floor(high[1] / cell_m) - south + 2
    corner = np.array([west, south]) * cell_m
    height = np.zeros((rows, cols))
    raise_triangles(request, height, triangles, float(corner[0]), float(corner[1]))
    frame = LocalFrame(GeoPoint(*request.at, request.ground_amsl_m))
    nothing = (
        f"nothing in it is higher than {BUILDING_MIN_M} m above its zero (it spans {high[0] - low[0]:.3g} × "
        f"{high[1] - low[1]:.3g} × {high[2] - low[2]:.3g} m). Fix: check [building] units and up"
    )
    anywhere = MapRequest(path, cell_m, request.ground_amsl_m)
    building = component_at(anywhere, height > BUILDING_MIN_M, cell_m, frame, corner, nothing)
    warnings = []
    if low[2] < -0.5:
        warnings.append(
            f"the mesh reaches {-low[2]:.1f} m below its zero: that part is taken to be under ground"
        )
    others = np.count_nonzero((height > BUILDING_MIN_M) & ~building) / np.count_nonzero(building)
    if others > 0.0:
        warnings.append(
            f"the mesh is in pieces: the largest is the building, the others ({others:.0%} of its plan) are obstacles"
        )
    site = site_about(request, height, building, cell_m, frame, corner)
    return SiteMap(site, path.stem, tuple(warnings))


def _triangles(request: MapRequest) -> FloatArray:
    """The mesh's triangles `(n, 3, 3)` as they stand in the file."""
    path, kind = request.path, request.path.suffix.lower()[1:]
    trimesh = need("trimesh", "mesh", path)
    judge_bytes(path, MOST_MB, "simplify the mesh")
    content = path.read_bytes()
    _judge_claims(request, kind, content)
    try:
        # From memory, without a resolver: materials and textures beside it are none of our business.
        loaded = trimesh.load(
            io.BytesIO(content), file_type=kind, process=False, skip_materials=True, maintain_order=True
        )
        mesh = loaded.to_mesh() if hasattr(loaded, "to_mesh") else loaded
        faces, vertices = np.asarray(mesh.faces), np.asarray(mesh.vertices, dtype=np.float64)
        triangles: FloatArray = vertices[faces]
    except Exception as error:  # trimesh's parsers raise whatever a torn file makes them stumble on
        raise InputError(
            f"{path}: not a readable {kind.upper()} mesh ({type(error).__name__}: {str(error)[:120]}). Fix: export it anew, triangulated"
        ) from None
    if triangles.ndim != 3 or len(triangles) == 0:
        raise InputError(f"{path}: it holds no triangles. Fix: export the building's surfaces as a mesh")
    if not np.isfinite(triangles).all():
        which = int(np.argwhere(~np.isfinite(triangles))[0, 0])
        raise InputError(
            f"{path}: triangle {which + 1} has a corner that is not finite. Fix: repair the mesh"
        )
    return triangles


def _judge_claims(request: MapRequest, kind: str, content: bytes) -> None:
    """Refuses counts in the header that the file cannot hold."""
    claimed, size = 0, len(content)
    if kind == "stl" and size >= 84 and content.lstrip()[:5].lower() != b"solid":
        claimed = int.from_bytes(content[80:84], "little")
        size = (size - 84) // 50
    elif kind == "ply":
        header = content[: content.find(b"end_header") + 1 or 100_000]
        claimed = sum(int(count[:18]) for count in _PLY_ELEMENT.findall(header))
    if claimed > size:
        raise InputError(
            f"{request.path}: its header claims {claimed:,} items, the file holds at most {size:,}. Fix: it is torn; export it anew"
        )


def _stood(request: MapRequest, triangles: FloatArray) -> FloatArray:
    """The triangles in metres east, north and up of where the mesh's origin stands."""
    assert request.units is not None
    x, y, z = np.moveaxis(triangles, -1, 0) * UNITS_M[request.units]
    if request.up == "y":
        y, z = -z, y
    heading = math.radians(request.heading_deg or 0.0)
    east, north = x * math.cos(heading) + y * math.sin(heading), y * math.cos(heading) - x * math.sin(heading)
    return np.stack([east, north, z], axis=-1)
