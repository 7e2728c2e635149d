"""The air that moves: a mean wind that grows with height, and Dryden's turbulence (MIL-F-8785C, 3.7.3.4).

Below 1000 ft, with height h in feet and the mean wind W at 20 ft, the wind at h is W ln(h/z₀) / ln(20/z₀)
with z₀ = 0.15 ft (Category C: take-off and landing, open ground; above 3 ft). L_w = h, L_u = L_v = h / (0.177
+ 0.000823 h)^1.2, σ_w = 0.1 W, σ_u = σ_v = σ_w / (0.177 + 0.000823 h)^0.4. u lies along the mean wind, v
across it. With time T = L over the airspeed the spectra, one-sided in Hz, are 4 σ² T / (1 + ω²T²) for u and
2 σ² T (1 + 3 ω²T²) / (1 + ω²T²)² for v and w. The forming filters run at the frame rate with exact poles.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.kernels import FloatArray, kernel

__all__ = ["AIR", "GUST_NORMALS", "blow", "shear"]

AIR = np.dtype([("mean_wind_ned_mps", "f8", 3), ("gust_mps", "f8", 5), ("turbulent", "i8")])
"""Mean wind at 20 ft, the forming filters' states (u; v twice; w twice), and whether gusts blow."""

GUST_NORMALS = 3
_FOOT_M = 0.3048
_ROUGHNESS_FT = 0.15


@kernel
def shear(height_m: float) -> float:
    """The mean wind at that height by the mean wind at 20 ft."""
    feet = min(max(height_m / _FOOT_M, 3.0), 1000.0)
    return math.log(feet / _ROUGHNESS_FT) / math.log(20.0 / _ROUGHNESS_FT)


@kernel
def _lag(state: FloatArray, decay: float, drive: float) -> float:
    """The next output of (1 + √3 T s) / (1 + T s)² in partial fractions; its variance is 2."""
    fresh = math.sqrt(1.0 - decay * decay) * drive
    state[1] = decay * state[1] + (1.0 - decay) * (state[0] + 0.5 * fresh)
    state[0] = decay * state[0] + fresh
    root3 = math.sqrt(3.0)
    return float(root3 * state[0] + (1.0 - root3) * state[1])


@kernel
def blow(
    air: np.record,
    height_m: float,
    velocity_ned_mps: FloatArray,
    normals: FloatArray,
    dt_s: float,
    wind_ned_mps: FloatArray,
) -> None:
    """Put the wind of the next `dt_s` into `wind_ned_mps`."""
    mean = air.mean_wind_ned_mps
    speed = math.hypot(mean[0], mean[1])
    if speed == 0.0 and mean[2] == 0.0:
        for i in range(3):
            wind_ned_mps[i] = 0.0
        return
    share = shear(height_m)
    for i in range(3):
        wind_ned_mps[i] = share * mean[i]
    if not air.turbulent or speed == 0.0:
        return
    feet = min(max(height_m / _FOOT_M, 10.0), 1000.0)
    shape = 0.177 + 0.000823 * feet
    length_w = feet * _FOOT_M
    length_u = length_w / shape**1.2
    sigma_w = 0.1 * speed
    sigma_u = sigma_w / shape**0.4
    airspeed = math.sqrt(
        (velocity_ned_mps[0] - wind_ned_mps[0]) ** 2
        + (velocity_ned_mps[1] - wind_ned_mps[1]) ** 2
        + (velocity_ned_mps[2] - wind_ned_mps[2]) ** 2
    )
    reach = max(airspeed, 1.0) * dt_s
    decay_u, decay_w = math.exp(-reach / length_u), math.exp(-reach / length_w)
    gust = air.gust_mps
    gust[0] = decay_u * gust[0] + math.sqrt(1.0 - decay_u * decay_u) * normals[0]
    u = sigma_u * gust[0]
    v = sigma_u / math.sqrt(2.0) * _lag(gust[1:3], decay_u, normals[1])
    w = sigma_w / math.sqrt(2.0) * _lag(gust[3:5], decay_w, normals[2])
    c, s = mean[0] / speed, mean[1] / speed
    wind_ned_mps[0] += c * u - s * v
    wind_ned_mps[1] += s * u + c * v
    wind_ned_mps[2] += w
