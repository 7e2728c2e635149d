"""MAV_CMD_INJECT_FAILURE to faults, as far as this vehicle can have them."""

from __future__ import annotations

import math

from sitl.faults import Fault, GpsLoss, MotorLoss
from sitl.link.commands import Command

__all__ = ["failure_of"]

_GPS, _MOTOR = 4.0, 101.0  # FAILURE_UNIT
_OK, _OFF = 0.0, 1.0  # FAILURE_TYPE
_MOTORS = 4


def failure_of(command: Command, now_us: int) -> tuple[Fault, ...] | type[Fault] | None:
    """What goes wrong from now on, or the kind of fault that is over; None for what cannot fail here.

    A GPS receiver can be off, and so can each motor, counted from 1; instance 0 is all of them. OK ends all faults
    of its kind.
    """
    what = command.param1, command.param2
    instance = int(command.param3) if math.isfinite(command.param3) else 0
    if what == (_GPS, _OK):
        return GpsLoss
    if what == (_GPS, _OFF) and instance in (0, 1):
        return (GpsLoss(now_us, None),)
    if what == (_MOTOR, _OK):
        return MotorLoss
    if what == (_MOTOR, _OFF) and 0 <= instance <= _MOTORS:
        motors = range(1, _MOTORS + 1) if instance == 0 else (instance,)
        return tuple(MotorLoss(now_us, None, motor, 0.0) for motor in motors)
    return None
