"""A trajectory as mission items that an autopilot flies by itself in AUTO.

PX4 takes the heading from param4 of a waypoint and refuses DO_ items that are not in frame MISSION;
ArduPilot drops param4, so that each waypoint is followed by a CONDITION_YAW.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mavspiral.errors import LimitError
from mavspiral.export.thinning import Thinned, thin
from mavspiral.frames import GeoPoint, LocalFrame, yaw_enu_to_ned
from mavspiral.motion.trajectory import Trajectory

__all__ = ["Item", "MissionItems", "mission_items"]

Autopilot = Literal["px4", "ardupilot"]

MAV_FRAME_GLOBAL_RELATIVE_ALT = 3
MAV_FRAME_MISSION = 2
MAV_CMD_NAV_WAYPOINT = 16
MAV_CMD_NAV_RETURN_TO_LAUNCH = 20
MAV_CMD_NAV_TAKEOFF = 22
MAV_CMD_CONDITION_YAW = 115
MAV_CMD_DO_CHANGE_SPEED = 178
ACCEPTANCE_M = 1.0


@dataclass(frozen=True, slots=True)
class Item:
    """One mission item. `params` are MAVLink's seven; NaN marks what the autopilot shall choose."""

    command: int
    frame: int
    params: tuple[float, float, float, float, float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class MissionItems:
    """The items of one mission, the home they are relative to, and what the waypoints leave of the curve."""

    autopilot: Autopilot
    home: GeoPoint
    items: tuple[Item, ...]
    thinned: Thinned
    speed_mps: float


def mission_items(
    trajectory: Trajectory, frame: LocalFrame, home_enu_m: np.ndarray, *, autopilot: Autopilot, items_max: int
) -> MissionItems:
    """Take-off, speed, the trajectory's waypoints with heading, return: at most `items_max` items.

    Raises:
        LimitError: not even the corners of the legs fit into `items_max`.
    """
    a_waypoint = 2 if autopilot == "ardupilot" else 1
    overhead = 3
    thinned = thin(trajectory, (items_max - overhead) // a_waypoint)
    count = overhead + len(thinned.t_s) * a_waypoint
    if count > items_max:
        raise LimitError(
            f"the mission needs {count} items at its coarsest and max_items is {items_max}. "
            f"Fix: [vehicle] max_items ≥ {count}, or stream it with `mavspiral fly`"
        )
    home = frame.geo_point(home_enu_m)
    lat, lon, alt = frame.to_geodetic(thinned.position_enu_m)
    begin_s, end_s = trajectory.span_s("inspection")
    t_s = np.linspace(begin_s, end_s, 1000)
    velocity = trajectory(t_s[trajectory.on("inspection", t_s)]).velocity_enu_mps
    speed_mps = round(float(np.median(np.sqrt((velocity**2).sum(axis=1)))), 2)

    nan = math.nan if autopilot == "px4" else 0.0
    items = [
        Item(
            MAV_CMD_NAV_TAKEOFF,
            MAV_FRAME_GLOBAL_RELATIVE_ALT,
            (0, 0, 0, nan, home.lat_deg, home.lon_deg, _metres(alt[0] - home.alt_amsl_m)),
        ),
        Item(MAV_CMD_DO_CHANGE_SPEED, MAV_FRAME_MISSION, (1, speed_mps, -1, 0, 0, 0, 0)),
    ]
    for i, yaw_enu_rad in enumerate(thinned.yaw_enu_rad):
        yaw_ned_deg = round(math.degrees(float(yaw_enu_to_ned(yaw_enu_rad))), 2)
        place = (float(lat[i]), float(lon[i]), _metres(alt[i] - home.alt_amsl_m))
        if autopilot == "px4":
            heading = (yaw_ned_deg + 180.0) % 360.0 - 180.0
            params = (0.0, ACCEPTANCE_M, 0.0, round(heading, 2), *place)
            items.append(Item(MAV_CMD_NAV_WAYPOINT, MAV_FRAME_GLOBAL_RELATIVE_ALT, params))
        else:
            items.append(Item(MAV_CMD_NAV_WAYPOINT, MAV_FRAME_GLOBAL_RELATIVE_ALT, (0, 0, 0, 0, *place)))
            direction = _turn(thinned.yaw_enu_rad, i)
            items.append(
                Item(
                    MAV_CMD_CONDITION_YAW, MAV_FRAME_MISSION, (yaw_ned_deg % 360.0, 0, direction, 0, 0, 0, 0)
                )
            )
    items.append(Item(MAV_CMD_NAV_RETURN_TO_LAUNCH, MAV_FRAME_MISSION, (0, 0, 0, 0, 0, 0, 0)))
    return MissionItems(autopilot, home, tuple(items), thinned, speed_mps)


def _turn(yaw_enu_rad: np.ndarray, index: int) -> int:
    """CONDITION_YAW's param3: 1 clockwise, -1 counter-clockwise, as the trajectory turns."""
    if index == 0:
        return 1
    return -1 if yaw_enu_rad[index] > yaw_enu_rad[index - 1] else 1


def _metres(value: float) -> float:
    return round(float(value), 3)
