"""The flight for any map: a line in space for each leg, a point for each picture (RFC 7946).

The third coordinate is metres above mean sea level, where the standard means the ellipsoid; a property says so.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mavspiral.frames import LocalFrame, wrap_rad, yaw_enu_to_ned
from mavspiral.motion.trajectory import Trajectory
from mavspiral.survey.shots import Shots

__all__ = ["flight_geojson"]

GRID_S = 0.5
HEIGHTS = "above mean sea level"


def flight_geojson(trajectory: Trajectory, shots: Shots, frame: LocalFrame, name: str) -> dict[str, Any]:
    """A FeatureCollection of the legs as LineStrings and the pictures as Points with their heading and pitch."""
    features = []
    begins_s = np.cumsum([0.0, *(leg.law.duration_s for leg in trajectory.legs)])
    for leg, begin_s in zip(trajectory.legs, begins_s, strict=False):
        count = max(2, int(leg.law.duration_s / GRID_S) + 1)
        states = trajectory(np.linspace(begin_s, begin_s + leg.law.duration_s, count))
        line = {"type": "LineString", "coordinates": _places(states.position_enu_m, frame)}
        about = {
            "leg": leg.name,
            "begin_s": round(float(begin_s), 2),
            "duration_s": round(leg.law.duration_s, 2),
        }
        features.append(_feature(line, about))
    yaw_deg = np.degrees(wrap_rad(yaw_enu_to_ned(shots.yaw_enu_rad))) + 0.0
    pitch_deg = np.degrees(shots.pitch_rad) + 0.0
    for seq, place in enumerate(_places(shots.position_enu_m, frame)):
        about = {
            "photo": seq,
            "t_s": round(float(shots.t_s[seq]), 3),
            "yaw_ned_deg": round(float(yaw_deg[seq]), 2),
            "pitch_deg": round(float(pitch_deg[seq]), 2),
        }
        features.append(_feature({"type": "Point", "coordinates": place}, about))
    return {"type": "FeatureCollection", "name": name, "heights": HEIGHTS, "features": features}


def _places(position_enu_m: np.ndarray, frame: LocalFrame) -> list[list[float]]:
    lat, lon, alt = frame.to_geodetic(position_enu_m)
    return [
        [round(float(o), 8), round(float(a), 8), round(float(h), 3)]
        for a, o, h in zip(lat, lon, alt, strict=True)
    ]


def _feature(geometry: dict[str, Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties}
