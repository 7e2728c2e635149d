"""SET_POSITION_TARGET_GLOBAL_INT to setpoints, by PX4's rules.

Source: PX4, mavlink_receiver.cpp, handle_message_set_position_target_global_int.
"""

from __future__ import annotations

import numpy as np
from pymavlink.dialects.v20 import common

from sitl.geo import ned_of_geodetic
from sitl.link.messages import Message, message_type
from sitl.link.report import Report
from sitl.link.setpoints import setpoint_of
from sitl.signals import Setpoint

__all__ = ["global_setpoint_of"]

_LOCAL_TARGET = message_type("SET_POSITION_TARGET_LOCAL_NED")
_POSITION_BITS = 0o007


def global_setpoint_of(message: Message, report: Report) -> Setpoint | None:
    """What the message commands in the estimate's frame; None when PX4 refuses it.

    A position counts whole or not at all. It is refused where the place or home is not known, and in other frames
    than GLOBAL_INT and GLOBAL_RELATIVE_ALT_INT; no terrain is known here. Without one the frame does not matter.
    """
    place_ned_m: tuple[float, float, float] | None = (0.0, 0.0, 0.0)
    mask = message.type_mask | (_POSITION_BITS if message.type_mask & _POSITION_BITS else 0)
    if not mask & _POSITION_BITS:
        place_ned_m = _place_ned_m(message, report)
    if place_ned_m is None:
        return None
    rest = message[4:12]  # velocity, acceleration, yaw, yaw rate
    local = _LOCAL_TARGET(0, *place_ned_m, *rest, mask, 0, 0, common.MAV_FRAME_LOCAL_NED)
    return setpoint_of(local, lambda: np.array([1.0, 0.0, 0.0, 0.0]))


def _place_ned_m(message: Message, report: Report) -> tuple[float, float, float] | None:
    origin, home = report.origin, report.flight.home
    if origin is None or not report.estimate.position_ok:
        return None
    anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
    point = message.lat_int * 1e-7, message.lon_int * 1e-7, origin.alt_amsl_m
    north_m, east_m, _ = ned_of_geodetic(anchor, point)
    if message.coordinate_frame == common.MAV_FRAME_GLOBAL_INT:
        return north_m, east_m, origin.alt_amsl_m - message.alt
    if message.coordinate_frame == common.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT and home is not None:
        # As PX4 has it: what home lies above the origin is added to "down", where it should be taken from it.
        return north_m, east_m, home.point.alt_amsl_m - message.alt - origin.alt_amsl_m
    return None
