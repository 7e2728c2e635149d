"""Plan items on the wire and as the vehicle keeps them: what PX4 takes, what it keeps of it, what it refuses.

Source: PX4 v1.17, mavlink_mission.cpp, parse_mavlink_mission_item and format_mavlink_mission_item.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from pymavlink.dialects.v20 import common

from sitl.link.item_messages import packed
from sitl.link.messages import Message, message_type
from sitl.plans import PlanItem, PlanKind

__all__ = ["CAPACITY", "item_of", "message_of"]

_MISSION_ITEM = message_type("MISSION_ITEM")

CAPACITY: Mapping[int, int] = {PlanKind.MISSION: 10_000, PlanKind.FENCE: 64, PlanKind.RALLY: 32}
"""PX4 SITL's store. A flight controller's holds 500 or 1000 mission items."""

_KEPT: Mapping[int, tuple[int, ...]] = {
    common.MAV_CMD_NAV_WAYPOINT: (0, 1, 3),
    common.MAV_CMD_NAV_LOITER_UNLIM: (2, 3),
    common.MAV_CMD_NAV_LOITER_TIME: (0, 1, 2, 3),
    common.MAV_CMD_NAV_LAND: (1, 3),
    common.MAV_CMD_NAV_TAKEOFF: (3,),
    common.MAV_CMD_NAV_LOITER_TO_ALT: (0, 1, 3),
    common.MAV_CMD_NAV_ROI: (0,),
    common.MAV_CMD_DO_SET_ROI: (0,),
    common.MAV_CMD_DO_SET_ROI_LOCATION: (),
    common.MAV_CMD_NAV_VTOL_TAKEOFF: (3,),
    common.MAV_CMD_NAV_VTOL_LAND: (3,),
    common.MAV_CMD_CONDITION_GATE: (),
    common.MAV_CMD_NAV_FENCE_RETURN_POINT: (),
    common.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: (0,),
    common.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: (0,),
    common.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: (0,),
    common.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: (0,),
    common.MAV_CMD_NAV_RALLY_POINT: (),
    common.MAV_CMD_COMPONENT_ARM_DISARM: (0,),
}
"""The items with a place, and which of their first four parameters PX4 keeps. The others come back as 0."""

_YAWED = (
    common.MAV_CMD_NAV_WAYPOINT,
    common.MAV_CMD_NAV_LOITER_UNLIM,
    common.MAV_CMD_NAV_LAND,
    common.MAV_CMD_NAV_TAKEOFF,
    common.MAV_CMD_NAV_VTOL_TAKEOFF,
    common.MAV_CMD_NAV_VTOL_LAND,
)
_PLACELESS_NAMES = """
DO_JUMP NAV_ROI DO_SET_ROI DO_WINCH DO_GRIPPER DO_CHANGE_SPEED DO_SET_HOME DO_LAND_START DO_TRIGGER_CONTROL
DO_DIGICAM_CONTROL DO_MOUNT_CONFIGURE DO_MOUNT_CONTROL DO_GIMBAL_MANAGER_PITCHYAW DO_GIMBAL_MANAGER_CONFIGURE
SET_CAMERA_FOCUS IMAGE_START_CAPTURE IMAGE_STOP_CAPTURE VIDEO_START_CAPTURE VIDEO_STOP_CAPTURE
DO_CONTROL_VIDEO DO_SET_CAM_TRIGG_DIST OBLIQUE_SURVEY DO_SET_CAM_TRIGG_INTERVAL SET_CAMERA_MODE
DO_VTOL_TRANSITION NAV_DELAY NAV_RETURN_TO_LAUNCH DO_SET_ROI_WPNEXT_OFFSET DO_SET_ROI_NONE CONDITION_DELAY
CONDITION_DISTANCE DO_SET_ACTUATOR DO_AUTOTUNE_ENABLE COMPONENT_ARM_DISARM
"""
_PLACELESS = frozenset(getattr(common, f"MAV_CMD_{name}", -1) for name in _PLACELESS_NAMES.split())
"""The items without a place. PX4 keeps all of their parameters."""
_FENCES_AND_RALLY = range(common.MAV_CMD_NAV_FENCE_RETURN_POINT, common.MAV_CMD_NAV_RALLY_POINT + 1)
_CORNERS = (
    common.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    common.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
)
_ROI_LOCATION = common.MAV_ROI_LOCATION
_FLOAT_FRAMES = (common.MAV_FRAME_GLOBAL, common.MAV_FRAME_GLOBAL_RELATIVE_ALT)
_INT_FRAMES = (common.MAV_FRAME_GLOBAL_INT, common.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
_RELATIVE = (common.MAV_FRAME_GLOBAL_RELATIVE_ALT, common.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)


def item_of(message: Message) -> PlanItem | int:
    """The item that a MISSION_ITEM or MISSION_ITEM_INT carries; or the MAV_MISSION_RESULT that refuses it."""
    in_degrees = isinstance(message, _MISSION_ITEM)
    if message.frame in _FLOAT_FRAMES or (message.frame in _INT_FRAMES and not in_degrees):
        item = _placed(message, 1.0 if in_degrees else 1e-7)
    elif message.frame == common.MAV_FRAME_MISSION:
        item = _placeless(message)
    else:
        return int(common.MAV_MISSION_UNSUPPORTED_FRAME)
    if isinstance(item, int):
        return item
    return item if _fits(item, message.mission_type) else int(common.MAV_MISSION_ERROR)


def _placed(message: Message, degree: float) -> PlanItem | int:
    command = message.command
    kept = _KEPT.get(command)
    if kept is None:
        return int(common.MAV_MISSION_UNSUPPORTED)
    if command in (common.MAV_CMD_NAV_ROI, common.MAV_CMD_DO_SET_ROI) and message.param1 not in (
        _ROI_LOCATION,
        common.MAV_ROI_NONE,
    ):
        return int(common.MAV_MISSION_INVALID_PARAM1)
    told = message.param1, message.param2, message.param3, message.param4
    p1, p2, p3, p4 = (value if index in kept else 0.0 for index, value in enumerate(told))
    if command in _YAWED:
        p4 = p4 % 360.0 if math.isfinite(p4) else math.nan
    params = (p1, p2, p3, p4, message.x * degree, message.y * degree, message.z)
    return PlanItem(command, message.frame, params, bool(message.autocontinue))


def _placeless(message: Message) -> PlanItem | int:
    if message.command not in _PLACELESS:
        return int(common.MAV_MISSION_UNSUPPORTED)
    if message.command in (common.MAV_CMD_NAV_ROI, common.MAV_CMD_DO_SET_ROI) and message.param1 not in (
        common.MAV_ROI_NONE,
        common.MAV_ROI_WPNEXT,
        common.MAV_ROI_WPINDEX,
    ):
        return int(common.MAV_MISSION_INVALID_PARAM1)
    told = message.param1, message.param2, message.param3, message.param4
    params = (*told, float(message.x), float(message.y), message.z)
    return PlanItem(message.command, message.frame, params, bool(message.autocontinue))


def _fits(item: PlanItem, kind: int) -> bool:
    """Whether an item of this sort may be in a plan of that kind."""
    if kind == PlanKind.MISSION:
        return item.command not in _FENCES_AND_RALLY
    return kind != PlanKind.FENCE or item.command not in _CORNERS or item.params[0] >= 3.0


def message_of(
    item: PlanItem, seq: int, kind: int, partner: tuple[int, int], current: int, *, exact: bool
) -> Message:
    """The item as it is read back: in a MISSION_ITEM_INT when `exact`, else in a MISSION_ITEM."""
    frame = item.frame
    if item.has_place:
        frames = _INT_FRAMES if exact else _FLOAT_FRAMES
        frame = frames[1] if item.frame in _RELATIVE else frames[0]
    return packed(item, frame, seq, kind, partner, current, exact=exact)
