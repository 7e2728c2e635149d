"""What MAVLink's mission protocol says, as small values; the enumerations carry MAVLink's own names."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

__all__ = ["MissionAck", "MissionCount", "MissionItem", "MissionKind", "MissionRequest", "MissionResult"]


class MissionKind(IntEnum):
    """MAV_MISSION_TYPE_*."""

    MISSION = 0
    FENCE = 1
    RALLY = 2


class MissionResult(IntEnum):
    """MAV_MISSION_*: how an upload was answered."""

    ACCEPTED = 0
    ERROR = 1
    UNSUPPORTED_FRAME = 2
    UNSUPPORTED = 3
    NO_SPACE = 4
    INVALID = 5
    INVALID_PARAM1 = 6
    INVALID_PARAM2 = 7
    INVALID_PARAM3 = 8
    INVALID_PARAM4 = 9
    INVALID_PARAM5_X = 10
    INVALID_PARAM6_Y = 11
    INVALID_PARAM7 = 12
    INVALID_SEQUENCE = 13
    DENIED = 14
    OPERATION_CANCELLED = 15


class MissionItem(NamedTuple):
    """MISSION_ITEM_INT but for its addresses: `x` and `y` are degrees times 1e7 where there is a place."""

    seq: int
    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float
    autocontinue: bool
    kind: int


class MissionCount(NamedTuple):
    """MISSION_COUNT."""

    total: int
    kind: int


class MissionRequest(NamedTuple):
    """MISSION_REQUEST_INT, or MISSION_REQUEST, which is answered alike."""

    seq: int
    kind: int


class MissionAck(NamedTuple):
    """MISSION_ACK."""

    result: int
    kind: int
