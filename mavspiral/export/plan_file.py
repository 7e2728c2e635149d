"""QGroundControl's `.plan`: SimpleItems only, so that every reader can take it.

The keys are those that QGroundControl's loader and MAVSDK's importer demand between them: versions are whole
numbers, `geoFence` and `rallyPoints` are there, the altitude keys come all three or not at all.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.export.items import Item, MissionItems
from mavspiral.frames import LocalFrame

__all__ = ["fence_enu_m", "plan_document"]

MAV_AUTOPILOT = {"px4": 12, "ardupilot": 3}
MAV_TYPE_QUADROTOR = 2
ALTITUDE_MODE_RELATIVE = 1
HAS_ALTITUDE = (16, 22)
FENCE_SIDES = 16


def plan_document(
    mission: MissionItems, frame: LocalFrame, position_enu_m: FloatArray, *, name: str, fence_margin_m: float
) -> dict[str, Any]:
    """The `.plan` as a JSON document: the items, and an inclusion fence round the flown positions `(n, 3)`."""
    home = mission.home
    fence = fence_enu_m(position_enu_m, fence_margin_m)
    lat, lon, _ = frame.to_geodetic(np.column_stack([fence, np.zeros(len(fence))]))
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "mavspiral",
        "mission": {
            "version": 2,
            "firmwareType": MAV_AUTOPILOT[mission.autopilot],
            "vehicleType": MAV_TYPE_QUADROTOR,
            "cruiseSpeed": mission.speed_mps,
            "hoverSpeed": mission.speed_mps,
            "globalPlanAltitudeMode": ALTITUDE_MODE_RELATIVE,
            "plannedHomePosition": [_angle(home.lat_deg), _angle(home.lon_deg), round(home.alt_amsl_m, 3)],
            "items": [_simple_item(number, item) for number, item in enumerate(mission.items, start=1)],
        },
        "geoFence": {
            "version": 2,
            "polygons": [
                {
                    "version": 1,
                    "inclusion": True,
                    "polygon": [[_angle(a), _angle(o)] for a, o in zip(lat, lon, strict=True)],
                }
            ],
            "circles": [],
        },
        "rallyPoints": {"version": 2, "points": []},
        "mavspiral": {
            "schema": 1,
            "name": name,
            "chord_error_m": round(mission.thinned.chord_error_m, 3),
            "heading_error_deg": round(math.degrees(mission.thinned.heading_error_rad), 2),
        },
    }


def fence_enu_m(position_enu_m: FloatArray, margin_m: float) -> FloatArray:
    """A convex polygon `(16, 2)` whose every side keeps at least `margin_m` from all positions."""
    angle = np.arange(FENCE_SIDES) * 2 * np.pi / FENCE_SIDES
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    reach = (position_enu_m[:, :2] @ normal.T).max(axis=0) + margin_m
    following = np.roll(normal, -1, axis=0)
    sides = np.stack([normal, following], axis=1)
    corners: FloatArray = np.linalg.solve(sides, np.column_stack([reach, np.roll(reach, -1)])[:, :, None])[
        :, :, 0
    ]
    return corners


def _simple_item(number: int, item: Item) -> dict[str, Any]:
    params = [None if math.isnan(value) else value for value in item.params]
    document: dict[str, Any] = {
        "type": "SimpleItem",
        "command": item.command,
        "frame": item.frame,
        "params": params,
        "autoContinue": True,
        "doJumpId": number,
    }
    if item.command in HAS_ALTITUDE:
        params[4], params[5] = _angle(item.params[4]), _angle(item.params[5])
        document |= {
            "Altitude": item.params[6],
            "AltitudeMode": ALTITUDE_MODE_RELATIVE,
            "AMSLAltAboveTerrain": None,
        }
    return document


def _angle(degrees: float) -> float:
    """Rounded to what MAVLink carries, 1e-7 degrees (11 mm)."""
    return round(float(degrees), 7)
