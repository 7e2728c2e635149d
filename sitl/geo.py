"""The earth: WGS 84, a tangent NED frame at any place, gravity and a dipole's magnetic field.

Written apart from `mavspiral.frames` on purpose: each checks the other.
"""

from __future__ import annotations

import math

from sitl.kernels import Triple, kernel

__all__ = ["GRAVITY_MPS2", "dipole_field", "geodetic_of_ned", "ned_of_geodetic"]

GRAVITY_MPS2 = 9.80665

_A = 6378137.0
_E2 = 6.69437999014e-3
_B = 6356752.314245


@kernel
def _ecef(lat_deg: float, lon_deg: float, alt_m: float) -> Triple:
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    n = _A / math.sqrt(1.0 - _E2 * math.sin(lat) ** 2)
    return (
        (n + alt_m) * math.cos(lat) * math.cos(lon),
        (n + alt_m) * math.cos(lat) * math.sin(lon),
        (n * (1.0 - _E2) + alt_m) * math.sin(lat),
    )


@kernel
def _geodetic(x: float, y: float, z: float) -> Triple:
    """Bowring (1976) with two rounds on the parametric latitude: below 1e-9 m near the ground."""
    p = math.hypot(x, y)
    beta = math.atan2(z * _A, p * _B)
    lat = 0.0
    for _ in range(2):
        lat = math.atan2(z + _E2 / (1.0 - _E2) * _B * math.sin(beta) ** 3, p - _E2 * _A * math.cos(beta) ** 3)
        beta = math.atan2(_B * math.sin(lat), _A * math.cos(lat))
    n = _A / math.sqrt(1.0 - _E2 * math.sin(lat) ** 2)
    alt = p * math.cos(lat) + z * math.sin(lat) - _A * _A / n
    return math.degrees(lat), math.degrees(math.atan2(y, x)), alt


@kernel
def ned_of_geodetic(origin: Triple, place: Triple) -> Triple:
    """NED metres of `place` in the tangent frame at `origin`; both are lat_deg, lon_deg, alt_m."""
    lat, lon = math.radians(origin[0]), math.radians(origin[1])
    a, b = _ecef(origin[0], origin[1], origin[2]), _ecef(place[0], place[1], place[2])
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    outward = math.cos(lon) * dx + math.sin(lon) * dy
    return (
        math.cos(lat) * dz - math.sin(lat) * outward,
        math.cos(lon) * dy - math.sin(lon) * dx,
        -math.cos(lat) * outward - math.sin(lat) * dz,
    )


@kernel
def geodetic_of_ned(origin: Triple, ned_m: Triple) -> Triple:
    """lat_deg, lon_deg, alt_m of a place in the tangent frame at `origin`."""
    lat, lon = math.radians(origin[0]), math.radians(origin[1])
    a = _ecef(origin[0], origin[1], origin[2])
    outward = -math.sin(lat) * ned_m[0] - math.cos(lat) * ned_m[2]
    return _geodetic(
        a[0] + math.cos(lon) * outward - math.sin(lon) * ned_m[1],
        a[1] + math.sin(lon) * outward + math.cos(lon) * ned_m[1],
        a[2] + math.cos(lat) * ned_m[0] - math.sin(lat) * ned_m[2],
    )


@kernel
def dipole_field(lat_deg: float, lon_deg: float) -> Triple:
    """The magnetic field in NED, gauss: the first degree of IGRF-13 (epoch 2020) at sea level."""
    g10, g11, h11 = -0.294048, -0.014509, 0.046525
    colat, lon = math.radians(90.0 - lat_deg), math.radians(lon_deg)
    tilt = g11 * math.cos(lon) + h11 * math.sin(lon)
    return (
        -g10 * math.sin(colat) + tilt * math.cos(colat),
        g11 * math.sin(lon) - h11 * math.cos(lon),
        -2.0 * (g10 * math.cos(colat) + tilt * math.sin(colat)),
    )
