"""A trajectory as mission items that an autopilot flies by itself in AUTO.

For PX4 the heading comes from a region of interest, not from the waypoints: at a waypoint it waits until it has turned
as param4 says. ArduPilot drops param4; its CONDITION_YAW, the last of the items behind a waypoint because it holds up what follows,
turns the nose at an even rate to the next one's heading, and the gimbal is told its pitch where that changes. Each waypoint has one:
where WP_YAW_BEHAVIOR is not 0, each takes the heading away. Where they are too many for the board, it too has regions of interest.

Commands without a place are in frame MISSION, because PX4 refuses them in any other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mavspiral.export.thinning import Thinned
from mavspiral.frames import GeoPoint, LocalFrame, yaw_enu_to_ned

__all__ = ["Autopilot", "Item", "MissionItems", "mission_frame_item", "mission_items"]

Autopilot = Literal["px4", "ardupilot"]

MAV_FRAME_GLOBAL_RELATIVE_ALT = 3
MAV_FRAME_MISSION = 2
MAV_CMD_NAV_WAYPOINT = 16
MAV_CMD_NAV_RETURN_TO_LAUNCH = 20
MAV_CMD_NAV_TAKEOFF = 22
MAV_CMD_CONDITION_YAW = 115
MAV_CMD_DO_CHANGE_SPEED = 178
MAV_CMD_DO_SET_ROI_LOCATION = 195
MAV_CMD_DO_SET_ROI_NONE = 197
MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW = 1000
SPEED_STEP_MPS = 0.1
PITCH_STEP_RAD = math.radians(0.5)
OWN_RATE, RATE_MIN_DPS = 0.0, 1.0
SHORTER_WAY = 0.0

Seven = tuple[float, float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Item:
    """One mission item. `params` are MAVLink's seven; NaN marks what the autopilot shall choose.

    `t_s` is the path time that it belongs to, NaN where it belongs to none.
    """

    command: int
    frame: int
    params: Seven
    t_s: float = math.nan


@dataclass(frozen=True, slots=True, eq=False)
class MissionItems:
    """The items of one mission, the home they are relative to, and what the waypoints leave of the curve."""

    autopilot: Autopilot
    home: GeoPoint
    items: tuple[Item, ...]
    thinned: Thinned
    speed_mps: float


def mission_items(
    thinned: Thinned,
    frame: LocalFrame,
    home_enu_m: np.ndarray,
    *,
    autopilot: Autopilot,
    camera: Mapping[int, tuple[Item, ...]],
    gimbal: bool,
) -> MissionItems:
    """Take-off, the waypoints with speeds, aims or turns between them and what the `camera` is told at each, return."""
    home = frame.geo_point(home_enu_m)
    radius_m = thinned.radius_m

    def place(position_enu_m: np.ndarray) -> tuple[float, float, float]:
        lat, lon, alt = frame.to_geodetic(position_enu_m)
        return float(lat), float(lon), round(float(alt) - home.alt_amsl_m, 3)

    def placed(command: int, p2: float, yaw_deg: float, position_enu_m: np.ndarray, t_s: float) -> Item:
        params = (0.0, p2, 0.0, yaw_deg, *place(position_enu_m))
        return Item(command, MAV_FRAME_GLOBAL_RELATIVE_ALT, params, t_s)

    nan = math.nan if autopilot == "px4" else 0.0
    above_home = np.append(home_enu_m[:2], thinned.position_enu_m[0, 2])
    items = [placed(MAV_CMD_NAV_TAKEOFF, 0.0, nan, above_home, float(thinned.t_s[0]))]
    aims, speed_mps, last = dict(thinned.aims), 0.0, len(thinned.t_s) - 1
    pitch_rad = math.nan
    for i, position in enumerate(thinned.position_enu_m):
        onward = thinned.stages[i + 1] if i < last else None
        if i:
            p2 = round(float(radius_m[i]), 2) if autopilot == "px4" else 0.0
            items.append(placed(MAV_CMD_NAV_WAYPOINT, p2, nan, position, float(thinned.t_s[i])))
        if i in aims:
            items.append(placed(MAV_CMD_DO_SET_ROI_LOCATION, 0.0, 0.0, aims[i].point_enu_m, math.nan))
        if onward is not None and abs(onward.speed_mps - speed_mps) >= SPEED_STEP_MPS:
            speed_mps = onward.speed_mps
            items.append(mission_frame_item(MAV_CMD_DO_CHANGE_SPEED, 1.0, speed_mps, -1.0))
        items += camera.get(i, ())
        if not aims and onward is not None:
            if gimbal and not abs(thinned.pitch_rad[i] - pitch_rad) < PITCH_STEP_RAD:
                pitch_rad = float(thinned.pitch_rad[i])
                pitch_deg = round(math.degrees(pitch_rad), 1)
                items.append(mission_frame_item(MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW, pitch_deg))
            items.append(_turn(thinned, i))
    if aims:
        items.append(mission_frame_item(MAV_CMD_DO_SET_ROI_NONE))
    items.append(mission_frame_item(MAV_CMD_NAV_RETURN_TO_LAUNCH))
    inspection_mps = max((stage.speed_mps for stage in thinned.stages if stage.inspects), default=speed_mps)
    return MissionItems(autopilot, home, tuple(items), thinned, inspection_mps)


def _turn(thinned: Thinned, begin: int) -> Item:
    """CONDITION_YAW on the way from a waypoint to the next: degrees from north, degrees a second, absolute.

    The shorter way round: told a direction, ArduPilot goes all the way round when it has come a little too far. On
    the way to the inspection it turns as fast as it likes, since nobody knows how it stood before.
    """
    end = begin + 1
    side_m = float(np.sqrt(((thinned.position_enu_m[end] - thinned.position_enu_m[begin]) ** 2).sum()))
    lasts_s = max(side_m / thinned.stages[end].speed_mps, float(thinned.t_s[end] - thinned.t_s[begin]))
    turn_rad = abs(float(thinned.yaw_enu_rad[end] - thinned.yaw_enu_rad[begin]))
    heading_deg = round(math.degrees(float(yaw_enu_to_ned(thinned.yaw_enu_rad[end]))) % 360.0, 1) % 360.0
    knows = any(stage.inspects for stage in thinned.stages[1 : end + 1])
    rate_dps = max(RATE_MIN_DPS, round(math.degrees(turn_rad) / lasts_s, 1)) if knows else OWN_RATE
    return mission_frame_item(MAV_CMD_CONDITION_YAW, heading_deg, rate_dps, SHORTER_WAY)


def mission_frame_item(command: int, *params: float) -> Item:
    """An item without a place; parameters that are not given are zero."""
    p1, p2, p3, p4, p5, p6, p7 = (*params, *(0.0,) * (7 - len(params)))
    return Item(command, MAV_FRAME_MISSION, (p1, p2, p3, p4, p5, p6, p7))
