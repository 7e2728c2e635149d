"""QGroundControl's `.plan`: SimpleItems only, so that every reader can take it.

The keys are those that QGroundControl's loader and MAVSDK's importer demand between them: versions are whole
numbers, `geoFence` and `rallyPoints` are there, the altitude keys come all three or not at all.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.export.fences import SafeArea
from mavspiral.export.items import Item, MissionItems
from mavspiral.export.own_plan import KEY
from mavspiral.frames import LocalFrame

__all__ = ["plan_document"]

MAV_AUTOPILOT = {"px4": 12, "ardupilot": 3}
MAV_TYPE_QUADROTOR = 2
ALTITUDE_MODE_RELATIVE = 1
HAS_ALTITUDE = (16, 22, 195)


def plan_document(
    mission: MissionItems, frame: LocalFrame, area: SafeArea, notes: dict[str, Any]
) -> dict[str, Any]:
    """The `.plan` as a JSON document: the items, the fence, a rally point, and our own `notes`."""
    home = mission.home
    rally = frame.geo_point(area.rally_enu_m)
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
                _polygon(area.inside_enu_m, frame, inclusion=True),
                *(_polygon(corners, frame, inclusion=False) for corners in area.outside_enu_m),
            ],
            "circles": [],
        },
        "rallyPoints": {
            "version": 2,
            "points": [
                [_angle(rally.lat_deg), _angle(rally.lon_deg), round(rally.alt_amsl_m - home.alt_amsl_m, 3)]
            ],
        },
        KEY: notes,
    }


def _polygon(corners_enu_m: FloatArray, frame: LocalFrame, *, inclusion: bool) -> dict[str, Any]:
    lat, lon, _ = frame.to_geodetic(np.column_stack([corners_enu_m, np.zeros(len(corners_enu_m))]))
    corners = [[_angle(a), _angle(o)] for a, o in zip(lat, lon, strict=True)]
    return {"version": 1, "inclusion": inclusion, "polygon": corners}


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
