"""Coordinate reference systems of maps: from a survey's own axes to degrees, and to metres in the plan.

pyproj knows the systems. Over a building's neighbourhood any of them is a quadratic function of the plan's metres
to far below a cell, so a million points or pixels cost a few products each (`PlanMap`; its error is measured when
it is fitted, not assumed).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.frames import LocalFrame
from mavspiral.shape.site_map import MapRequest, need

__all__ = ["MapCrs", "PlanMap", "map_crs", "read_crs"]

FIT_ERROR_M = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class MapCrs:
    """A map's coordinate reference system; x is east or longitude, y north or latitude.

    `height_unit_m` is how many metres one unit of height is.
    """

    path: Path
    name: str
    geographic: bool
    height_unit_m: float
    to_degrees: Any
    warnings: tuple[str, ...]

    def lat_lon_deg(self, x: ArrayLike, y: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Latitude and longitude of places in the map's own axes.

        Raises:
            InputError: the coordinates cannot be of this system.
        """
        with np.errstate(all="ignore"):
            lon, lat = self.to_degrees.transform(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        lat, lon = np.asarray(lat, dtype=np.float64), np.asarray(lon, dtype=np.float64)
        if not (np.isfinite(lat).all() and np.isfinite(lon).all() and np.all(np.abs(lat) <= 90.0)):
            raise InputError(
                f"{self.path}: its coordinates are not on the earth in {self.name}. "
                "Fix: state the map's true coordinate reference system"
            )
        return lat, lon

    def xy(self, lat_deg: ArrayLike, lon_deg: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """The map's own axes, infinite where the system does not reach."""
        with np.errstate(all="ignore"):
            x, y = self.to_degrees.transform(
                np.asarray(lon_deg, dtype=float), np.asarray(lat_deg, dtype=float), direction="INVERSE"
            )
        return np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)


def read_crs(path: Path, text: Any, extra: str = "geo") -> MapCrs:
    """The system that a file names: an EPSG code, a WKT, or pyproj's own value.

    Raises:
        InputError: pyproj is missing, does not know it, or it is not on the earth.
    """
    pyproj = need("pyproj", extra, path)
    try:
        crs = pyproj.CRS.from_user_input(text)
        to_degrees = pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
        axes = crs.axis_info
        name = " ".join(str(crs.name).split())[:80]
        geographic = bool(crs.is_geographic)
        on_earth = geographic or bool(crs.is_projected)
    except Exception as error:
        raise InputError(
            f"{path}: its coordinate reference system is not known ({_first_line(error)}). "
            "Fix: state it as an EPSG code, e.g. EPSG:32614"
        ) from None
    if not on_earth:
        raise InputError(
            f"{path}: its coordinate reference system {name} is neither projected nor geographic. "
            "Fix: reproject the map, e.g. to its UTM zone"
        )
    vertical = [axis for axis in axes if axis.direction == "up"]
    plan_unit_m = 1.0 if geographic else float(axes[0].unit_conversion_factor)
    height_unit_m = float(vertical[0].unit_conversion_factor) if vertical else plan_unit_m
    warnings: tuple[str, ...] = ()
    if not vertical and abs(plan_unit_m - 1.0) > 1e-9:
        warnings = (f"{name} counts in {axes[0].unit_name}: heights are taken to be in the same unit",)
    return MapCrs(path, name, geographic, height_unit_m, to_degrees, warnings)


def map_crs(request: MapRequest, own: Any, how_to_state: str, extra: str = "geo") -> MapCrs:
    """The system that the file itself names, `own`; where that is None, the mission's [building] crs.

    Raises:
        InputError: there is neither, or `read_crs` does not know it.
    """
    if own is None and request.crs is None:
        raise InputError(
            f"{request.path}: it has no coordinate reference system. "
            f'Fix: [building] crs = "EPSG:32614" with the one that it is in, or {how_to_state}'
        )
    crs = read_crs(request.path, request.crs if own is None else own, extra)
    if own is None or request.crs is None:
        return crs
    unused = f"[building] crs = {request.crs} is not used: the map itself says {crs.name}"
    return replace(crs, warnings=(*crs.warnings, unused))


@dataclass(frozen=True, slots=True, eq=False)
class PlanMap:
    """Metres east and north in the plan as a quadratic of the map's axes: `terms((x − middle) / half) @ coefficients`."""

    middle: FloatArray
    half: FloatArray
    coefficients_m: FloatArray

    @classmethod
    def fit(cls, path: Path, low: ArrayLike, high: ArrayLike, to_degrees: Any, frame: LocalFrame) -> PlanMap:
        """Fitted over the box from `low` to `high`; `to_degrees(x, y)` gives latitudes and longitudes.

        Raises:
            InputError: the box is so large, or the system so bent, that a quadratic does not do.
        """
        a, b = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        middle, half = (a + b) / 2.0, np.maximum((b - a) / 2.0, 1e-9)
        s, t = (axis.ravel() for axis in np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9)))
        lat, lon = to_degrees(middle[0] + s * half[0], middle[1] + t * half[1])
        plan = frame.to_enu(lat, lon, frame.origin.alt_amsl_m)[:, :2]
        coefficients = np.linalg.lstsq(_terms(s, t), plan, rcond=None)[0]
        error_m = float(np.abs(_terms(s, t) @ coefficients - plan).max())
        if not error_m <= FIT_ERROR_M:
            raise InputError(
                f"{path}: its map spans {np.ptp(plan[:, 0]) / 1000:.0f} × {np.ptp(plan[:, 1]) / 1000:.0f} km, too far for "
                "one flat plan. Fix: cut the building's neighbourhood out of the map"
            )
        return cls(middle, half, np.asarray(coefficients, dtype=np.float64))

    def plan_m(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Metres east and north of the frame's origin."""
        terms = _terms((x - self.middle[0]) / self.half[0], (y - self.middle[1]) / self.half[1])
        plan = terms @ self.coefficients_m
        return plan[:, 0], plan[:, 1]


def _terms(s: FloatArray, t: FloatArray) -> FloatArray:
    return np.column_stack([np.ones_like(s), s, t, s * t, s * s, t * t])


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [""])[0][:120]
