"""How the pictures are commanded in a mission, by the camera's trigger."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from mavspiral.export.items import CameraOrders, mission_frame_item
from mavspiral.survey.shots import Shots

__all__ = ["camera_orders", "shot_stops_s"]

Trigger = Literal["camera", "digicam", "distance", "none"]

MAV_CMD_DO_DIGICAM_CONTROL = 203
MAV_CMD_DO_SET_CAM_TRIGG_DIST = 206
MAV_CMD_IMAGE_START_CAPTURE = 2000
MAV_CMD_IMAGE_STOP_CAPTURE = 2001


def camera_orders(trigger: Trigger, shots: Shots, *, interval_min_s: float, speed_mps: float) -> CameraOrders:
    """The orders for pictures no farther apart than planned.

    By time (`camera`) at the shortest interval of the plan, because in AUTO no place is passed faster than planned;
    by `distance` at the plan's shortest step that the shutter can follow at `speed_mps`; by `digicam` one order a
    picture, at a waypoint each (`shot_stops_s`).
    """
    match trigger:
        case "camera":
            interval_s = max(interval_min_s, math.floor(100 * _shortest(np.diff(shots.t_s))) / 100)
            begin = mission_frame_item(MAV_CMD_IMAGE_START_CAPTURE, 0.0, interval_s, 0.0)
            return CameraOrders((begin,), (), (mission_frame_item(MAV_CMD_IMAGE_STOP_CAPTURE),))
        case "distance":
            steps_m = np.hypot(*np.diff(shots.position_enu_m[:, :2], axis=0).T)
            step_m = max(_shortest(steps_m), speed_mps * interval_min_s)
            begin = mission_frame_item(
                MAV_CMD_DO_SET_CAM_TRIGG_DIST, math.floor(100 * step_m) / 100, 0.0, 1.0
            )
            return CameraOrders((begin,), (), (mission_frame_item(MAV_CMD_DO_SET_CAM_TRIGG_DIST),))
        case "digicam":
            shoot = mission_frame_item(MAV_CMD_DO_DIGICAM_CONTROL, 0.0, 0.0, 0.0, 0.0, 1.0)
            return CameraOrders((shoot,), (shoot,), (shoot,), shot_stops_s(trigger, shots))
        case "none":
            return CameraOrders()


def shot_stops_s(trigger: Trigger, shots: Shots) -> tuple[float, ...]:
    """The path times that need a waypoint of their own."""
    return tuple(shots.t_s.tolist()) if trigger == "digicam" else ()


def _shortest(steps: np.ndarray) -> float:
    return float(steps.min()) if len(steps) else math.inf
