"""What a MAVLink command says, its answer, and MAV_CMD to orders: those that every link of a PX4 vehicle takes alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from pymavlink.dialects.v20 import common

from sitl.link.codec import Received
from sitl.link.messages import Message, message_type
from sitl.orders import (
    Arm,
    ChangeSpeed,
    Disarm,
    Mode,
    Orbit,
    Order,
    Reposition,
    SetHome,
    StartMission,
    SwitchMode,
    TakeOff,
    UsePayload,
    Verdict,
)
from sitl.plans import PlanItem
from sitl.signals import GeoPoint
from sitl.status import FlightStatus

__all__ = ["ORDERS", "RESULTS", "Command", "answered", "command_of", "whole_number"]

_COMMAND_ACK = message_type("COMMAND_ACK")

RESULTS: Mapping[Verdict, int] = {
    Verdict.ACCEPTED: common.MAV_RESULT_ACCEPTED,
    Verdict.NOT_NOW: common.MAV_RESULT_TEMPORARILY_REJECTED,
    Verdict.DENIED: common.MAV_RESULT_DENIED,
}
"""How PX4 and its camera answer."""
_FORCE = 21196.0
_YES = 0.5
_NO_LATLON = 2**31 - 1
_CHANGE_MODE = 1


class Command(NamedTuple):
    """A COMMAND_LONG or a COMMAND_INT: its number and seven parameters. NaN is a parameter left out."""

    number: int
    param1: float
    param2: float
    param3: float
    param4: float
    param5: float
    param6: float
    param7: float


def command_of(message: Message) -> Command:
    """What a COMMAND_LONG or COMMAND_INT says. In PX4 a COMMAND_INT's height is AMSL in whatever frame."""
    if hasattr(message, "param7"):
        return Command._make((message.command, *message[:7]))
    lat_deg, lon_deg = (math.nan if value == _NO_LATLON else value * 1e-7 for value in (message.x, message.y))
    return Command._make((message.command, *message[:4], lat_deg, lon_deg, message.z))


def answered(command_number: int, result: int, received: Received) -> Message:
    """The COMMAND_ACK for whoever sent `received`."""
    return _COMMAND_ACK(command_number, result, 0, 0, received.system, received.component)


def whole_number(value: float) -> int:
    """A parameter that is a number of something; −1 when it is left out."""
    return int(value) if math.isfinite(value) else -1


def _arming(command: Command, _: FlightStatus) -> Order | None:
    force = command.param2 == _FORCE
    orders: dict[float, Order] = {1.0: Arm(force), 0.0: Disarm(force)}
    return orders.get(command.param1)


def _terminate(command: Command, _: FlightStatus) -> Order | None:
    """DO_FLIGHTTERMINATION: the motors stop; here, and in ArduPilot, it is disarmed then."""
    return Disarm(force=True) if command.param1 > _YES else None


def _set_home(command: Command, _: FlightStatus) -> Order | None:
    if command.param1 > _YES:
        return SetHome(None)
    lat_deg, lon_deg, alt_m = command[5:]
    if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0 and math.isfinite(alt_m)):
        return None
    return SetHome(GeoPoint(lat_deg, lon_deg, alt_m))


def _take_off(command: Command, _: FlightStatus) -> Order:
    return TakeOff(command.param7)


def _reposition(command: Command, flight: FlightStatus) -> Order | None:
    changes_mode = math.isfinite(command.param2) and int(command.param2) & _CHANGE_MODE
    if not changes_mode and flight.mode is not Mode.HOLD:
        return None
    return Reposition(command.param5, command.param6, command.param7, command.param4, command.param1)


def _orbit(command: Command, _: FlightStatus) -> Order:
    return Orbit(
        command.param1, command.param2, command.param3, command.param5, command.param6, command.param7
    )


def _change_speed(command: Command, _: FlightStatus) -> Order | None:
    return ChangeSpeed(int(command.param1), command.param2) if math.isfinite(command.param1) else None


def _switch_to(mode: Mode) -> Callable[[Command, FlightStatus], Order]:
    return lambda _command, _flight: SwitchMode(mode)


def _start_mission(command: Command, flight: FlightStatus) -> Order | None:
    """PX4 looks at the mission and at the first item (-1 or a number), and then flies from its current item."""
    first_ok = -1.0 <= command.param1 < len(flight.plans.mission)
    return StartMission() if first_ok or not flight.mission_ok else None


def _use_payload(command: Command, _: FlightStatus) -> Order:
    """As in a mission; a place's height is AMSL."""
    placed = command.number in _WITH_PLACE
    frame = common.MAV_FRAME_GLOBAL if placed else common.MAV_FRAME_MISSION
    return UsePayload(PlanItem(command.number, frame, command[1:]))


_WITH_PLACE = (common.MAV_CMD_DO_SET_ROI, common.MAV_CMD_DO_SET_ROI_LOCATION)
_PAYLOAD = (
    *_WITH_PLACE,
    common.MAV_CMD_DO_SET_ROI_NONE,
    common.MAV_CMD_DO_DIGICAM_CONTROL,
    common.MAV_CMD_DO_MOUNT_CONTROL,
    common.MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    common.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL,
    common.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
    common.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
    common.MAV_CMD_IMAGE_START_CAPTURE,
    common.MAV_CMD_IMAGE_STOP_CAPTURE,
)
ORDERS: Mapping[int, Callable[[Command, FlightStatus], Order | None]] = {
    common.MAV_CMD_COMPONENT_ARM_DISARM: _arming,
    common.MAV_CMD_NAV_TAKEOFF: _take_off,
    common.MAV_CMD_NAV_LAND: _switch_to(Mode.LAND),
    common.MAV_CMD_NAV_RETURN_TO_LAUNCH: _switch_to(Mode.RETURN),
    common.MAV_CMD_NAV_LOITER_UNLIM: _switch_to(Mode.HOLD),
    common.MAV_CMD_DO_REPOSITION: _reposition,
    common.MAV_CMD_DO_ORBIT: _orbit,
    common.MAV_CMD_DO_CHANGE_SPEED: _change_speed,
    common.MAV_CMD_MISSION_START: _start_mission,
    common.MAV_CMD_DO_SET_HOME: _set_home,
    common.MAV_CMD_DO_FLIGHTTERMINATION: _terminate,
    **dict.fromkeys(_PAYLOAD, _use_payload),
}
"""What each command orders; None: it orders nothing that can be done, and is denied."""
