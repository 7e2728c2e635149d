"""Every conversion between frames that mavspiral makes; nothing else converts.

    geodetic  lat_deg, lon_deg, alt_amsl_m     WGS-84 angles, height above mean sea level
    enu       east, north, up, m               the plan's: a tangent plane at its origin
    ned       north, east, down, m             the vehicle's: a tangent plane at its EKF origin
    yaw_enu_rad    counter-clockwise from east
    yaw_ned_rad    clockwise from north

Heights above mean sea level are used where the ellipsoid's formulas want ellipsoidal ones. The geoid is
flat over a building, and a tangent plane leaves the curved earth by 20 mm at 500 m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pymap3d
from numpy.typing import ArrayLike

from mavspiral.arrays import FloatArray

__all__ = [
    "COMPASS",
    "GeoPoint",
    "LocalFrame",
    "RigidMap",
    "enu_to_ned",
    "ned_to_enu",
    "wrap_rad",
    "yaw_enu_to_ned",
    "yaw_ned_to_enu",
]

COMPASS = ("east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east")
"""In words the eight directions π/4 apart, counter-clockwise from east as `yaw_enu_rad` is."""


@dataclass(frozen=True, slots=True)
class GeoPoint:
    """A place on the earth."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


@dataclass(frozen=True, slots=True, eq=False)
class RigidMap:
    """The map `R_ned_enu @ position_enu_m + offset_ned_m` from a plan's ENU to a vehicle's NED."""

    R_ned_enu: FloatArray
    offset_ned_m: FloatArray

    def position_ned_m(self, position_enu_m: ArrayLike) -> FloatArray:
        """Positions `(…, 3)` of the plan in the vehicle's frame."""
        return np.asarray(position_enu_m, dtype=np.float64) @ self.R_ned_enu.T + self.offset_ned_m

    def position_enu_m(self, position_ned_m: ArrayLike) -> FloatArray:
        """Positions `(…, 3)` of the vehicle in the plan's frame."""
        return (np.asarray(position_ned_m, dtype=np.float64) - self.offset_ned_m) @ self.R_ned_enu


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """East-north-up axes with their origin at `origin`."""

    origin: GeoPoint

    def to_enu(self, lat_deg: ArrayLike, lon_deg: ArrayLike, alt_amsl_m: ArrayLike) -> FloatArray:
        """Geodetic places as `(…, 3)` metres east, north and up of the origin."""
        lat, lon, alt = np.broadcast_arrays(lat_deg, lon_deg, alt_amsl_m)
        o = self.origin
        enu = pymap3d.geodetic2enu(lat, lon, alt, o.lat_deg, o.lon_deg, o.alt_amsl_m)
        return np.stack([np.asarray(axis, dtype=np.float64) for axis in enu], axis=-1)

    def to_geodetic(self, position_enu_m: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Latitude in degrees, longitude in degrees and height AMSL in metres of positions `(…, 3)`."""
        e, n, u = np.moveaxis(np.asarray(position_enu_m, dtype=np.float64), -1, 0)
        o = self.origin
        lat, lon, alt = pymap3d.enu2geodetic(e, n, u, o.lat_deg, o.lon_deg, o.alt_amsl_m)
        return np.asarray(lat), np.asarray(lon), np.asarray(alt)

    def point_enu_m(self, point: GeoPoint) -> FloatArray:
        """`point` as `(3,)` metres east, north and up of the origin."""
        return self.to_enu(point.lat_deg, point.lon_deg, point.alt_amsl_m)

    def geo_point(self, position_enu_m: ArrayLike) -> GeoPoint:
        """The place of one position `(3,)`."""
        lat, lon, alt = self.to_geodetic(position_enu_m)
        return GeoPoint(float(lat), float(lon), float(alt))

    def to_vehicle(self, vehicle_origin: GeoPoint) -> RigidMap:
        """The map from this frame to the NED frame of a vehicle whose EKF origin is `vehicle_origin`.

        Both are tangent planes of one ellipsoid, so the map is rigid, and three unit vectors carried
        through geodetic coordinates give it exactly.
        """
        vehicle = LocalFrame(vehicle_origin)
        corners_enu_m = np.vstack([np.zeros(3), np.eye(3)])
        corners_ned_m = enu_to_ned(vehicle.to_enu(*self.to_geodetic(corners_enu_m)))
        u, _, vt = np.linalg.svd((corners_ned_m[1:] - corners_ned_m[0]).T)
        return RigidMap(u @ vt, corners_ned_m[0])


def enu_to_ned(vector_enu: ArrayLike) -> FloatArray:
    """Vectors `(…, 3)` with their axes re-ordered from east-north-up to north-east-down."""
    v = np.asarray(vector_enu, dtype=np.float64)
    return np.stack([v[..., 1], v[..., 0], -v[..., 2]], axis=-1)


def ned_to_enu(vector_ned: ArrayLike) -> FloatArray:
    """Vectors `(…, 3)` with their axes re-ordered from north-east-down to east-north-up."""
    return enu_to_ned(vector_ned)


def yaw_enu_to_ned(yaw_enu_rad: ArrayLike) -> FloatArray:
    """Clockwise from north, unwrapped as it came (a continuous yaw stays continuous)."""
    return np.pi / 2 - np.asarray(yaw_enu_rad, dtype=np.float64)


def yaw_ned_to_enu(yaw_ned_rad: ArrayLike) -> FloatArray:
    """Counter-clockwise from east, unwrapped as it came."""
    return np.pi / 2 - np.asarray(yaw_ned_rad, dtype=np.float64)


def wrap_rad(angle_rad: ArrayLike) -> FloatArray:
    """Angles wrapped into [-π, π)."""
    return (np.asarray(angle_rad, dtype=np.float64) + np.pi) % (2 * np.pi) - np.pi
