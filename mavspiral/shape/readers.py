"""Maps of every kind become a `Site`: what stands there, and which of it is the building to inspect.

    .geojson .json   footprints with heights, OSM's Simple 3D Buildings tags
    .npz             height_agl_m (rows, cols; row 0 south, column 0 west), cell_m, origin [lat, lon] south-west

The plan's origin is the middle of the building's bounding box, on the ground.
"""

from __future__ import annotations

from mavspiral.errors import InputError
from mavspiral.shape.footprints import site_from_footprints
from mavspiral.shape.geojson import read_features
from mavspiral.shape.height_grid import site_from_grid
from mavspiral.shape.site_map import MapRequest, SiteMap

__all__ = ["MapRequest", "SiteMap", "read_site"]


def read_site(request: MapRequest) -> SiteMap:
    """The site that the request names.

    Raises:
        InputError: the map cannot be read or believed, or the building is not where the request says.
    """
    if not request.path.is_file():
        raise InputError(f"{request.path}: no such map. Fix: [building] map is relative to the mission file")
    kind = request.path.suffix.lower()
    if kind in (".geojson", ".json"):
        return site_from_footprints(request, read_features(request.path))
    if kind == ".npz":
        return site_from_grid(request)
    raise InputError(f"{request.path}: a {kind or 'nameless'} map cannot be read. Fix: give .geojson or .npz")
