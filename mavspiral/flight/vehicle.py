"""What the vehicle last said."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mavspiral.flight.messages import (
    Attitude,
    AutopilotVersion,
    CommandAck,
    ExtendedSysState,
    GlobalPosition,
    Heartbeat,
    Home,
    LandedState,
    LocalPosition,
    Message,
    Origin,
    ParamValue,
    SysStatus,
    Triple,
)

__all__ = ["Vehicle"]

_SLOTS: dict[type, str] = {
    Attitude: "attitude",
    Heartbeat: "heartbeat",
    Origin: "origin",
    Home: "home",
    GlobalPosition: "place",
    AutopilotVersion: "version",
    SysStatus: "status",
    ExtendedSysState: "extended",
}


@dataclass(slots=True)
class Vehicle:
    """The newest of each message; None until it has come.

    `offset_ned_m` is where the frame that the flight began in lies in the vehicle's own, once that has moved: positions here
    are of the first.
    """

    heartbeat: Heartbeat | None = None
    local: LocalPosition | None = None
    attitude: Attitude | None = None
    origin: Origin | None = None
    home: Home | None = None
    place: GlobalPosition | None = None
    version: AutopilotVersion | None = None
    status: SysStatus | None = None
    extended: ExtendedSysState | None = None
    results: dict[int, int] = field(default_factory=dict)
    parameters: dict[str, ParamValue] = field(default_factory=dict)
    offset_ned_m: Triple | None = None

    def note(self, message: Message) -> None:
        """Remember `message` in place of the one before."""
        if isinstance(message, LocalPosition):
            if math.isfinite(sum(message)):
                offset = self.offset_ned_m
                self.local = message if offset is None else _displaced(message, offset, -1.0)
        elif (slot := _SLOTS.get(message.__class__)) is not None:
            setattr(self, slot, message)
        elif isinstance(message, CommandAck):
            self.results[message.command] = message.result
        elif isinstance(message, ParamValue):
            self.parameters[message.name] = message

    def reckon_from(self, offset_ned_m: Triple | None) -> None:
        """From now on the frame that the flight began in lies there in the vehicle's own; its newest position is that then."""
        if self.local is not None and self.offset_ned_m is not None:
            self.local = _displaced(self.local, self.offset_ned_m, 1.0)
        self.offset_ned_m = offset_ned_m
        if self.local is not None and offset_ned_m is not None:
            self.local = _displaced(self.local, offset_ned_m, -1.0)

    @property
    def armed(self) -> bool:
        """As the heartbeat has it."""
        return self.heartbeat is not None and self.heartbeat.armed

    @property
    def mode(self) -> int | None:
        """The heartbeat's custom mode."""
        return self.heartbeat.custom_mode if self.heartbeat else None

    @property
    def flying(self) -> bool:
        """Whether it says that it is off the ground."""
        return self.extended is not None and self.extended.landed_state in (
            LandedState.IN_AIR,
            LandedState.TAKEOFF,
            LandedState.LANDING,
        )

    @property
    def position_ned_m(self) -> Triple:
        """The estimate; NaN while unknown."""
        return self.local[1:4] if self.local else (math.nan, math.nan, math.nan)

    @property
    def velocity_ned_mps(self) -> Triple:
        """The estimate; NaN while unknown."""
        return self.local[4:7] if self.local else (math.nan, math.nan, math.nan)

    @property
    def yaw_ned_rad(self) -> float:
        """The estimate; NaN while unknown."""
        return self.attitude.yaw_ned_rad if self.attitude else math.nan


def _displaced(local: LocalPosition, by_ned_m: Triple, times: float) -> LocalPosition:
    n, e, d = (times * metres for metres in by_ned_m)
    return local._replace(north_m=local.north_m + n, east_m=local.east_m + e, down_m=local.down_m + d)
