"""Mission items on the wire and as ArduCopter keeps them: what it takes, what it keeps of it, what it refuses.

Source: ArduPilot 4.6, AP_Mission.cpp (mavlink_int_to_mission_cmd and back), as it was seen to behave. An item is stored in
15 bytes, so a waypoint keeps its delay alone, in whole seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from pymavlink.dialects.v20 import common

from sitl.link.item_messages import packed
from sitl.link.messages import Message, message_type
from sitl.plans import PlanItem, PlanKind
from sitl.status import Home

__all__ = ["CAPACITY", "item_of", "message_of", "with_home"]

_MISSION_ITEM = message_type("MISSION_ITEM")

CAPACITY: Mapping[int, int] = {PlanKind.MISSION: 1306, PlanKind.FENCE: 70, PlanKind.RALLY: 46}
"""What fits into 32 KiB of storage."""

_ALL = (0, 1, 2, 3)
_KEPT: Mapping[int, tuple[int, ...]] = {
    16: (0,), 17: (2,), 18: (0, 2), 19: (0, 2), 20: (), 21: (0,), 22: (0,), 31: (0, 2), 82: (0,), 92: _ALL, 93: _ALL,
    94: (0,), 112: (0,), 114: (0,), 115: _ALL, 177: (0, 1), 178: (0, 1, 2), 179: (0,), 181: _ALL, 182: _ALL,
    183: (0, 1), 184: _ALL, 189: (), 195: (), 197: (), 201: (0,), 202: _ALL, 203: _ALL, 205: _ALL, 206: (0, 2),
    207: (0,), 208: (0,), 210: _ALL, 211: (0, 1), 212: (0,), 218: (0, 1), 222: _ALL, 530: _ALL, 531: (0, 1), 532: (0, 1),
    534: _ALL, 1000: _ALL, 2000: _ALL, 2001: (0,), 2500: _ALL, 2501: (0,), 42702: _ALL,
}  # fmt: skip
"""The items that it takes, and which of their first four parameters it keeps. The others come back as 0."""
_PLACED = frozenset({16, 17, 18, 19, 21, 22, 31, 82, 94, 179, 189, 195, 201, *range(5000, 5005), 5100})
_FENCES, _RALLIES = range(5000, 5005), (5100,)
_MAY_LACK_YAW = (16, 17, 21, 22)
_FRAMES: Mapping[int, int] = {0: 0, 5: 0, 2: 0, 3: 3, 6: 3, 10: 3, 11: 3}
"""Every frame that is taken, and what it comes back as. A terrain frame counts as relative to home here."""


def item_of(message: Message) -> PlanItem | int:
    """The item that a MISSION_ITEM or MISSION_ITEM_INT carries; or the MAV_MISSION_RESULT that refuses it."""
    command, kind = message.command, message.mission_type
    if not _belongs(command, kind):
        return int(common.MAV_MISSION_UNSUPPORTED)
    placed = command in _PLACED
    if placed and message.frame not in _FRAMES:
        return int(common.MAV_MISSION_UNSUPPORTED_FRAME)
    told = message.param1, message.param2, message.param3, message.param4
    for index, value in enumerate(told):
        if math.isinf(value) or (math.isnan(value) and not (index == 3 and command in _MAY_LACK_YAW)):
            return int(common.MAV_MISSION_INVALID_PARAM1) + index
    degree = 1.0 if isinstance(message, _MISSION_ITEM) else 1e-7
    lat, lon = (message.x * degree, message.y * degree) if placed else (float(message.x), float(message.y))
    if placed:
        if not abs(lat) <= 90.0:
            return int(common.MAV_MISSION_INVALID_PARAM5_X)
        if not abs(lon) <= 180.0:
            return int(common.MAV_MISSION_INVALID_PARAM6_Y)
    if not math.isfinite(message.z):
        return int(common.MAV_MISSION_INVALID_PARAM7)
    kept = _KEPT.get(command, _ALL)
    p1, p2, p3, p4 = (value if index in kept else 0.0 for index, value in enumerate(told))
    if command in (16, 82, 93):
        p1 = float(int(p1))
    frame = _FRAMES.get(message.frame, 0) if placed else common.MAV_FRAME_MISSION
    return PlanItem(command, frame, (p1, p2, p3, p4, lat, lon, message.z))


def _belongs(command: int, kind: int) -> bool:
    match kind:
        case PlanKind.FENCE:
            return command in _FENCES
        case PlanKind.RALLY:
            return command in _RALLIES
    return command in _KEPT


def with_home(items: tuple[PlanItem, ...], home: Home | None) -> tuple[PlanItem, ...]:
    """A mission as it is kept: its item 0 is home."""
    if home is None or not items:
        return items
    point = home.point
    first = PlanItem(16, 0, (0.0, 0.0, 0.0, 0.0, point.lat_deg, point.lon_deg, point.alt_amsl_m))
    return (first, *items[1:])


def message_of(
    item: PlanItem, seq: int, kind: int, partner: tuple[int, int], current: int, *, exact: bool
) -> Message:
    """The item as it is read back: in a MISSION_ITEM_INT when `exact`, else in a MISSION_ITEM."""
    return packed(item, item.frame if item.has_place else 0, seq, kind, partner, current, exact=exact)
