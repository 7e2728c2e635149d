"""MAV_CMD to orders, as ArduCopter takes them. Heights count from home unless the frame says otherwise."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from pymavlink.dialects.v20 import common

from sitl.link.commands import ORDERS, Command
from sitl.orders import (
    GoToItem,
    Mode,
    Order,
    Pause,
    Reposition,
    SetHome,
    SetOutput,
    StartMission,
    SwitchMode,
    TakeOff,
    TurnTo,
)
from sitl.signals import GeoPoint
from sitl.status import FlightStatus

__all__ = ["COPTER_ORDERS", "INT_ONLY", "INT_ORDERS"]

_RELATIVE = (common.MAV_FRAME_GLOBAL_RELATIVE_ALT, common.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
_HERE = 1.0
_CHANGE_MODE = 1


def _take_off(command: Command, flight: FlightStatus) -> Order | None:
    if flight.home is None or not math.isfinite(command.param7):
        return None
    return TakeOff(flight.home.point.alt_amsl_m + command.param7)


def _switch_to(mode: Mode) -> Callable[[Command, FlightStatus], Order]:
    return lambda _command, _flight: SwitchMode(mode)


def _turn(command: Command, _: FlightStatus) -> Order | None:
    angle, rate, sign, relative = command[1:5]
    if not (0.0 <= angle <= 360.0 and relative in (0.0, 1.0)):
        return None
    way = -1 if sign < 0.0 else 1 if sign > 0.0 else 0
    return TurnTo(math.radians(angle), math.radians(rate) if rate > 0.0 else 0.0, way, relative == 1.0)


def _set_home(command: Command, _: FlightStatus) -> Order | None:
    if command.param1 == _HERE:
        return SetHome(None)
    lat_deg, lon_deg, alt_m = command[5:]
    if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0 and math.isfinite(alt_m) and (lat_deg or lon_deg)):
        return None
    return SetHome(GeoPoint(lat_deg, lon_deg, alt_m))


def _start_mission(_command: Command, _flight: FlightStatus) -> Order:
    return StartMission()


def _take_off_from(command: Command, flight: FlightStatus, frame: int) -> Order | None:
    return _take_off(command, flight) if frame in _RELATIVE else None


def _reposition(command: Command, flight: FlightStatus, frame: int) -> Order | None:
    changes_mode = math.isfinite(command.param2) and int(command.param2) & _CHANGE_MODE
    if flight.home is None or not (changes_mode or flight.mode is Mode.GUIDED):
        return None
    base_m = flight.home.point.alt_amsl_m if frame in _RELATIVE else 0.0
    lat_deg, lon_deg, alt_m = command[5:]
    return Reposition(lat_deg, lon_deg, base_m + alt_m, command.param4, command.param1)


def _set_servo(command: Command, _: FlightStatus) -> Order | None:
    if not (math.isfinite(command.param1) and 0.0 <= command.param2 <= _PULSE_MOST_US):
        return None
    return SetOutput(int(command.param1), int(command.param2))


def _go_to(command: Command, _: FlightStatus) -> Order | None:
    return GoToItem(int(command.param1)) if math.isfinite(command.param1) else None


def _pause(command: Command, _: FlightStatus) -> Order | None:
    return Pause(command.param1 == 1.0) if command.param1 in (0.0, 1.0) else None


_PULSE_MOST_US = 65535.0
_PAYLOAD = (
    common.MAV_CMD_DO_SET_ROI,
    common.MAV_CMD_DO_SET_ROI_LOCATION,
    common.MAV_CMD_DO_SET_ROI_NONE,
    common.MAV_CMD_DO_DIGICAM_CONTROL,
    common.MAV_CMD_DO_MOUNT_CONTROL,
    common.MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    common.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
    common.MAV_CMD_IMAGE_START_CAPTURE,
    common.MAV_CMD_IMAGE_STOP_CAPTURE,
)
COPTER_ORDERS: Mapping[int, Callable[[Command, FlightStatus], Order | None]] = {
    common.MAV_CMD_COMPONENT_ARM_DISARM: ORDERS[common.MAV_CMD_COMPONENT_ARM_DISARM],
    common.MAV_CMD_DO_FLIGHTTERMINATION: ORDERS[common.MAV_CMD_DO_FLIGHTTERMINATION],
    common.MAV_CMD_NAV_TAKEOFF: _take_off,
    common.MAV_CMD_NAV_LAND: _switch_to(Mode.LAND),
    common.MAV_CMD_NAV_RETURN_TO_LAUNCH: _switch_to(Mode.RTL),
    common.MAV_CMD_NAV_LOITER_UNLIM: _switch_to(Mode.LOITER),
    common.MAV_CMD_MISSION_START: _start_mission,
    common.MAV_CMD_DO_CHANGE_SPEED: ORDERS[common.MAV_CMD_DO_CHANGE_SPEED],
    common.MAV_CMD_CONDITION_YAW: _turn,
    common.MAV_CMD_DO_SET_HOME: _set_home,
    common.MAV_CMD_DO_SET_SERVO: _set_servo,
    common.MAV_CMD_DO_PAUSE_CONTINUE: _pause,
    common.MAV_CMD_DO_SET_MISSION_CURRENT: _go_to,
    **{number: ORDERS[number] for number in _PAYLOAD},
}
"""What each command orders; None: it orders nothing that can be done."""
INT_ORDERS: Mapping[int, Callable[[Command, FlightStatus, int], Order | None]] = {
    common.MAV_CMD_NAV_TAKEOFF: _take_off_from,
    common.MAV_CMD_DO_REPOSITION: _reposition,
}
"""Those whose COMMAND_INT has a frame that matters."""
INT_ONLY = (common.MAV_CMD_DO_REPOSITION,)
"""Those that are unknown as a COMMAND_LONG."""
