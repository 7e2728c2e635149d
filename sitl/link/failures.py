"""MAV_CMD_INJECT_FAILURE to faults, as far as this vehicle can have them.

A GPS receiver can be off; any sense can be stuck; a motor, counted from 1, can be off; and the battery, which is empty
then for good. Instance 0 is all of a kind. OK ends all faults of a kind, whichever instance they befell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from sitl.faults import BatteryLevel, Fault, GpsLoss, MotorLoss, SensorStuck
from sitl.link.commands import Command

__all__ = ["begun_by", "ended_by"]

_OK, _OFF, _STUCK = 0.0, 1.0, 2.0
_SENSES: Mapping[float, str] = {0.0: "gyro", 1.0: "accel", 2.0: "mag", 3.0: "baro", 4.0: "gps"}
_GPS, _BATTERY, _MOTOR = 4.0, 100.0, 101.0
_MOTORS = 4


def begun_by(command: Command, now_us: int) -> tuple[Fault, ...]:
    """What goes wrong from now on; nothing where that cannot fail here."""
    unit, kind = command.param1, command.param2
    instance = int(command.param3) if math.isfinite(command.param3) else 0
    if (unit, kind) == (_MOTOR, _OFF) and 0 <= instance <= _MOTORS:
        motors = range(1, _MOTORS + 1) if instance == 0 else (instance,)
        return tuple(MotorLoss(now_us, None, motor, 0.0) for motor in motors)
    if instance not in (0, 1):
        return ()
    if (unit, kind) == (_GPS, _OFF):
        return (GpsLoss(now_us, None),)
    if (unit, kind) == (_BATTERY, _OFF):
        return (BatteryLevel(now_us, None, 0.0),)
    if unit in _SENSES and kind == _STUCK:
        return (SensorStuck(now_us, None, _SENSES[unit]),)
    return ()


def ended_by(command: Command) -> tuple[type[Fault], ...]:
    """The kinds of fault that are over."""
    unit, kind = command.param1, command.param2
    if kind != _OK:
        return ()
    if unit == _MOTOR:
        return (MotorLoss,)
    if unit == _GPS:
        return GpsLoss, SensorStuck
    return (SensorStuck,) if unit in _SENSES else ()
