"""Which mission items an autopilot takes, as tables: what is not in them it refuses.

Sources: PX4 v1.17, mavlink_mission.cpp (parse_mavlink_mission_item) and dataman; ArduCopter 4.7, AP_Mission.cpp.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

__all__ = ["COMMANDS", "DIALECTS", "Dialect", "command_name"]

_NAMED = """
16 NAV_WAYPOINT  17 NAV_LOITER_UNLIM  18 NAV_LOITER_TURNS  19 NAV_LOITER_TIME  20 NAV_RETURN_TO_LAUNCH  21 NAV_LAND
22 NAV_TAKEOFF  31 NAV_LOITER_TO_ALT  36 NAV_ARC_WAYPOINT  80 NAV_ROI  82 NAV_SPLINE_WAYPOINT  84 NAV_VTOL_TAKEOFF
85 NAV_VTOL_LAND  92 NAV_GUIDED_ENABLE  93 NAV_DELAY  94 NAV_PAYLOAD_PLACE  112 CONDITION_DELAY
114 CONDITION_DISTANCE  115 CONDITION_YAW  177 DO_JUMP  178 DO_CHANGE_SPEED  179 DO_SET_HOME  181 DO_SET_RELAY
182 DO_REPEAT_RELAY  183 DO_SET_SERVO  184 DO_REPEAT_SERVO  187 DO_SET_ACTUATOR  188 DO_RETURN_PATH_START
189 DO_LAND_START  195 DO_SET_ROI_LOCATION  196 DO_SET_ROI_WPNEXT_OFFSET  197 DO_SET_ROI_NONE  200 DO_CONTROL_VIDEO
201 DO_SET_ROI  203 DO_DIGICAM_CONTROL  204 DO_MOUNT_CONFIGURE  205 DO_MOUNT_CONTROL  206 DO_SET_CAM_TRIGG_DIST
207 DO_FENCE_ENABLE  208 DO_PARACHUTE  211 DO_GRIPPER  212 DO_AUTOTUNE_ENABLE  214 DO_SET_CAM_TRIGG_INTERVAL
216 DO_SET_RESUME_REPEAT_DIST  217 DO_SPRAYER  218 DO_AUX_FUNCTION  222 DO_GUIDED_LIMITS  223 DO_ENGINE_CONTROL
260 OBLIQUE_SURVEY  400 COMPONENT_ARM_DISARM  530 SET_CAMERA_MODE  531 SET_CAMERA_ZOOM  532 SET_CAMERA_FOCUS
534 SET_CAMERA_SOURCE  600 JUMP_TAG  601 DO_JUMP_TAG  1000 DO_GIMBAL_MANAGER_PITCHYAW
1001 DO_GIMBAL_MANAGER_CONFIGURE  2000 IMAGE_START_CAPTURE  2001 IMAGE_STOP_CAPTURE  2003 DO_TRIGGER_CONTROL
2500 VIDEO_START_CAPTURE  2501 VIDEO_STOP_CAPTURE  3000 DO_VTOL_TRANSITION  4501 CONDITION_GATE
42600 DO_WINCH  42702 NAV_SCRIPT_TIME  42703 NAV_ATTITUDE_TIME
"""
_words = _NAMED.split()
COMMANDS: Final[Mapping[int, str]] = {
    int(number): name for number, name in zip(_words[::2], _words[1::2], strict=True)
}
"""MAV_CMD by number, as far as a mission of a multicopter may hold it."""

_NUMBERS = {name: number for number, name in COMMANDS.items()}


def command_name(command: int) -> str:
    """The command in words."""
    return COMMANDS.get(command, f"command {command}")


@dataclass(frozen=True, slots=True)
class Dialect:
    """What one autopilot takes.

    Args:
        name: in words.
        frames: the global frames that it knows; 2 is MISSION, for items without a place.
        placed: the commands that it takes in a global frame.
        placeless: the commands that it takes in frame MISSION; `any_frame` if in the others too.
        any_frame: whether commands without a place may come in any frame.
        nan_in_yaw: commands of which the fourth parameter may be null; None where any parameter may.
        stores: how many items its boards hold, from small to large, and what to say of each.
        fence_max: corners and circles of a fence.
        rally_max: rally points.
    """

    name: str
    frames: frozenset[int]
    placed: frozenset[int]
    placeless: frozenset[int]
    any_frame: bool
    nan_in_yaw: frozenset[int] | None
    stores: tuple[tuple[int, str], ...]
    fence_max: int
    rally_max: int


def _numbers(names: str) -> frozenset[int]:
    return frozenset(_NUMBERS[name] for name in names.split())


_ARDUPILOT_PLACED = _numbers(
    """NAV_WAYPOINT NAV_LOITER_UNLIM NAV_LOITER_TURNS NAV_LOITER_TIME NAV_LAND NAV_TAKEOFF NAV_LOITER_TO_ALT
    NAV_ARC_WAYPOINT NAV_SPLINE_WAYPOINT NAV_VTOL_TAKEOFF NAV_VTOL_LAND NAV_PAYLOAD_PLACE NAV_ROI DO_SET_ROI
    DO_SET_ROI_LOCATION DO_SET_HOME DO_LAND_START DO_RETURN_PATH_START"""
)
DIALECTS: Final[Mapping[str, Dialect]] = {
    "px4": Dialect(
        name="PX4",
        frames=frozenset((0, 3, 5, 6)),
        placed=_numbers(
            """NAV_WAYPOINT NAV_LOITER_UNLIM NAV_LOITER_TIME NAV_LAND NAV_TAKEOFF NAV_LOITER_TO_ALT NAV_ROI
            DO_SET_ROI DO_SET_ROI_LOCATION NAV_VTOL_TAKEOFF NAV_VTOL_LAND CONDITION_GATE COMPONENT_ARM_DISARM"""
        ),
        placeless=_numbers(
            """DO_JUMP NAV_ROI DO_SET_ROI DO_WINCH DO_GRIPPER DO_CHANGE_SPEED DO_SET_HOME DO_LAND_START
            DO_TRIGGER_CONTROL DO_DIGICAM_CONTROL DO_MOUNT_CONFIGURE DO_MOUNT_CONTROL DO_GIMBAL_MANAGER_PITCHYAW
            DO_GIMBAL_MANAGER_CONFIGURE SET_CAMERA_FOCUS IMAGE_START_CAPTURE IMAGE_STOP_CAPTURE
            VIDEO_START_CAPTURE VIDEO_STOP_CAPTURE DO_CONTROL_VIDEO DO_SET_CAM_TRIGG_DIST OBLIQUE_SURVEY
            DO_SET_CAM_TRIGG_INTERVAL SET_CAMERA_MODE DO_VTOL_TRANSITION NAV_DELAY NAV_RETURN_TO_LAUNCH
            DO_SET_ROI_WPNEXT_OFFSET DO_SET_ROI_NONE CONDITION_DELAY CONDITION_DISTANCE DO_SET_ACTUATOR
            DO_AUTOTUNE_ENABLE COMPONENT_ARM_DISARM"""
        ),
        any_frame=False,
        nan_in_yaw=None,
        stores=((500, "most boards"), (1000, "fmu-v6x, v6c and CubeOrange"), (10_000, "its simulation")),
        fence_max=64,
        rally_max=32,
    ),
    "ardupilot": Dialect(
        name="ArduCopter",
        frames=frozenset((0, 3, 5, 6, 10, 11)),
        placed=_ARDUPILOT_PLACED,
        placeless=_numbers(
            """NAV_RETURN_TO_LAUNCH NAV_GUIDED_ENABLE NAV_DELAY CONDITION_DELAY CONDITION_DISTANCE CONDITION_YAW
            DO_JUMP DO_CHANGE_SPEED DO_SET_RELAY DO_REPEAT_RELAY DO_SET_SERVO DO_REPEAT_SERVO DO_SET_ROI_NONE
            DO_DIGICAM_CONTROL DO_MOUNT_CONTROL DO_SET_CAM_TRIGG_DIST DO_FENCE_ENABLE DO_PARACHUTE DO_GRIPPER
            DO_AUTOTUNE_ENABLE DO_SET_RESUME_REPEAT_DIST DO_SPRAYER DO_AUX_FUNCTION DO_GUIDED_LIMITS
            DO_ENGINE_CONTROL SET_CAMERA_ZOOM SET_CAMERA_FOCUS SET_CAMERA_SOURCE JUMP_TAG DO_JUMP_TAG
            DO_GIMBAL_MANAGER_PITCHYAW IMAGE_START_CAPTURE IMAGE_STOP_CAPTURE VIDEO_START_CAPTURE
            VIDEO_STOP_CAPTURE DO_WINCH NAV_SCRIPT_TIME NAV_ATTITUDE_TIME"""
        )
        | _ARDUPILOT_PLACED,
        any_frame=True,
        nan_in_yaw=_numbers(
            "NAV_WAYPOINT NAV_LOITER_UNLIM NAV_LAND NAV_TAKEOFF NAV_VTOL_TAKEOFF NAV_VTOL_LAND"
        ),
        stores=(
            (302, "boards with 15 KiB of storage"),
            (649, "those with 16 KiB"),
            (1305, "those with 32 KiB"),
            (4366, "those that keep missions on a card"),
        ),
        fence_max=70,
        rally_max=46,
    ),
}
"""By the names that a mission file uses."""
