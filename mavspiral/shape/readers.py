"""Maps of every kind become a `Site`: what stands there, and which of it is the building to inspect.

    format              what it holds                                         heights                       extra
    .geojson .json      footprints, OSM's Simple 3D Buildings tags            above ground
    .npz                height_agl_m, cell_m, origin (`npz_map`)              above ground
    .city.json .json    CityJSON 1.1, 2.0: buildings with their parts         z − ground_amsl_m             geo
    .city.jsonl .jsonl  the same as a sequence of features                    z − ground_amsl_m             geo
    .tif .tiff          surface model; ground from its rim or from `dtm`      z − ground_amsl_m             geo
    .stl .obj .ply      mesh; needs `units`, `up`, `at`, takes `heading_deg`  above the mesh's own zero     mesh
    .las .laz           points; building 6, ground 2                          z − ground_amsl_m (`datum`)   cloud

The plan's origin is the middle of the building's bounding box, on the ground. Cells are solid: a wall may stand up
to one cell too far out, never too far in. Every refusal is one `InputError` of one line, and no file makes a reader
allocate what it only claims to hold.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable

import numpy as np

from mavspiral.errors import InputError
from mavspiral.shape.city_site import site_from_city
from mavspiral.shape.cityjson import city_map, is_cityjson
from mavspiral.shape.footprints import site_from_footprints
from mavspiral.shape.geojson import features_of
from mavspiral.shape.geotiff import site_from_geotiff
from mavspiral.shape.json_map import read_json, read_json_lines
from mavspiral.shape.mesh import site_from_mesh
from mavspiral.shape.npz_map import site_from_npz
from mavspiral.shape.pointcloud import site_from_points
from mavspiral.shape.site_map import MapRequest, SiteMap

__all__ = ["MapRequest", "SiteMap", "read_site"]

Reader = Callable[[MapRequest], SiteMap]


def read_site(request: MapRequest) -> SiteMap:
    """The site that the request names.

    Raises:
        InputError: the map cannot be read or believed, or the building is not where the request says.
    """
    kind = request.path.suffix.lower()
    if kind not in FORMATS:
        known = " ".join(FORMATS)
        raise InputError(
            f"{request.path}: a {kind or 'nameless'} map cannot be read. Fix: give one of {known}"
        )
    reader, keys = FORMATS[kind]
    for key in ("id", "dtm", "units", "up", "heading_deg", "crs"):
        if getattr(request, key) is not None and key not in keys:
            takers = " ".join(k for k, (_, taken) in FORMATS.items() if key in taken)
            raise InputError(
                f"{request.path}: [building] {key} means nothing to a {kind} map. Fix: leave it out; it is for {takers}"
            )
    for path in (request.path, request.dtm):
        if path is not None and not path.is_file():
            key = "map" if path is request.path else "dtm"
            raise InputError(f"{path}: no such map. Fix: [building] {key} is relative to the mission file")
    try:
        # A wild number is refused when it is judged, not when it overflows; and what a file lacks is said once.
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            answer = reader(request)
    except InputError as error:
        raise InputError(_one_line(str(error))) from None
    return SiteMap(answer.site, answer.name, tuple(_one_line(warning) for warning in answer.warnings))


def _from_json(request: MapRequest) -> SiteMap:
    document = read_json(request.path)
    if is_cityjson(document):
        return site_from_city(request, city_map(request.path, [document]))
    if request.crs is not None:
        raise InputError(
            f"{request.path}: [building] crs means nothing to GeoJSON, which is in degrees. Fix: leave it out"
        )
    return site_from_footprints(request, features_of(request.path, document))


def _from_json_lines(request: MapRequest) -> SiteMap:
    return site_from_city(request, city_map(request.path, read_json_lines(request.path)))


def _one_line(text: str) -> str:
    """The text without what a map's names may break it with; its middle left out when it is too long."""
    line = re.sub(r"[\s\x00-\x1f\x7f-\x9f\u2028\u2029]+", " ", text).strip()
    return line if len(line) <= 700 else f"{line[:400]} … {line[-280:]}"


MESH_KEYS = ("units", "up", "heading_deg")
FORMATS: dict[str, tuple[Reader, tuple[str, ...]]] = {
    ".geojson": (_from_json, ("id",)),
    ".json": (_from_json, ("id", "crs")),
    ".jsonl": (_from_json_lines, ("id", "crs")),
    ".npz": (site_from_npz, ()),
    ".tif": (site_from_geotiff, ("dtm", "crs")),
    ".tiff": (site_from_geotiff, ("dtm", "crs")),
    ".stl": (site_from_mesh, MESH_KEYS),
    ".obj": (site_from_mesh, MESH_KEYS),
    ".ply": (site_from_mesh, MESH_KEYS),
    ".las": (site_from_points, ("crs",)),
    ".laz": (site_from_points, ("crs",)),
}
"""Each suffix: its reader, and the keys of [building] that only some readers take."""
