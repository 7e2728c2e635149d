"""A height map that somebody made themselves: an `.npz` of numpy's.

height_agl_m (rows, cols; row 0 south, column 0 west), cell_m, origin = [lat, lon] of the south-west corner. What the
arrays' headers declare is judged before anything is allocated.
"""

from __future__ import annotations

import io
import math
import zipfile
from dataclasses import replace
from typing import IO

import numpy as np
from numpy.lib import format as npy

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.height_grid import BUILDING_MIN_M, component_at, site_about
from mavspiral.shape.site_map import MapRequest, SiteMap, judge_size

__all__ = ["site_from_npz"]

CELL_MIN_M, CELL_MAX_M = 0.02, 10.0
HEADER_BYTES_MAX = 20_000
KEYS = ("height_agl_m", "cell_m", "origin")
NOTE = "note"
"""Words about the map, for people."""


def site_from_npz(request: MapRequest) -> SiteMap:
    """The site in the `.npz` that the request names.

    Raises:
        InputError: it is no height map, holds a NaN (named), or has nothing at the place asked for.
    """
    path = request.path
    try:
        with zipfile.ZipFile(path) as archive:
            missing = [key for key in KEYS if f"{key}.npy" not in archive.namelist()]
            if missing:
                raise InputError(
                    f"{path}: has no {missing[0]!r}. "
                    "Fix: a height map holds height_agl_m (rows, cols), cell_m and origin = [lat, lon]"
                )
            others = sorted(name.removesuffix(".npy") for name in archive.namelist())
            others = [name for name in others if name not in (*KEYS, NOTE)]
            origin, cell = (_array(request, archive, key) for key in ("origin", "cell_m"))
            if cell.size == 1 and CELL_MIN_M <= float(cell.flat[0]) <= CELL_MAX_M:
                cell_m = float(cell.flat[0])
            else:
                raise InputError(
                    f"{path}: cell_m is {cell.ravel()[:4].tolist()}. "
                    f"Fix: give the cells' side in metres, one number from {CELL_MIN_M} to {CELL_MAX_M:g}"
                )
            height = _array(replace(request, cell_m=cell_m), archive, "height_agl_m")
    except InputError:
        raise
    except Exception as error:  # numpy's header parser lets through what Python's tokenizer raises
        raise InputError(
            f"{path}: not a readable .npz height map ({error}). Fix: write it with numpy.savez"
        ) from None
    if height.ndim != 2 or height.size == 0:
        raise InputError(f"{path}: height_agl_m has shape {height.shape}. Fix: give a (rows, cols) array")
    if not np.isfinite(height).all():
        row, col = (int(i) for i in np.argwhere(~np.isfinite(height))[0])
        raise InputError(
            f"{path}: height_agl_m[{row}, {col}] is {height[row, col]}. Fix: fill gaps with the ground's 0 or a measured height"
        )
    if origin.shape != (2,) or not np.isfinite(origin).all() or np.any(np.abs(origin) > (90.0, 180.0)):
        raise InputError(
            f"{path}: origin is {origin.ravel()[:4].tolist()}. Fix: give [lat, lon] in degrees of the south-west corner"
        )
    corner = LocalFrame(GeoPoint(float(origin[0]), float(origin[1]), request.ground_amsl_m))
    nothing = f"nothing in it is higher than {BUILDING_MIN_M} m. Fix: heights are metres above ground"
    building = component_at(request, height > BUILDING_MIN_M, cell_m, corner, np.zeros(2), nothing)
    site = site_about(request, height, building, cell_m, corner, np.zeros(2))
    return SiteMap(site, path.stem, (_ignored(request, others),) if others else ())


def _ignored(request: MapRequest, others: list[str]) -> str:
    shown = ", ".join(repr(name[:40]) for name in others[:5]) + (" …" if len(others) > 5 else "")
    return (
        f"{request.path}: ignored {shown}: a height map is {', '.join(KEYS)} and nothing else; "
        "the ground's height above the sea is [building] ground_amsl_m"
    )


def _array(request: MapRequest, archive: zipfile.ZipFile, key: str) -> FloatArray:
    """One array of the archive, after its header's claim was judged."""
    with archive.open(f"{key}.npy") as stream:
        shape, dtype = _header(io.BytesIO(stream.read(HEADER_BYTES_MAX)))
        if dtype.kind not in "fiub":
            raise ValueError(f"{key} holds {dtype}, not numbers")
        if key != "height_agl_m" and math.prod(shape) > 16:
            raise ValueError(f"{key} has shape {shape}")
        judge_size(request, *(shape if len(shape) == 2 else (1, math.prod(shape))))
        claimed = math.prod(shape) * dtype.itemsize
        if claimed > archive.getinfo(f"{key}.npy").file_size:
            raise ValueError(f"{key} claims {claimed} bytes and does not have them")
    with archive.open(f"{key}.npy") as stream:
        return np.asarray(npy.read_array(stream, allow_pickle=False), dtype=np.float64)


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    version = npy.read_magic(stream)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = read(stream)
    if not all(isinstance(n, int) and n >= 0 for n in shape):
        raise ValueError(f"shape is {shape}")
    return tuple(shape), dtype
