"""Plan items in their messages, which both dialects pack alike."""

from __future__ import annotations

from sitl.link.messages import Message, message_type
from sitl.plans import PlanItem

__all__ = ["packed"]

_MISSION_ITEM = message_type("MISSION_ITEM")
_MISSION_ITEM_INT = message_type("MISSION_ITEM_INT")


def packed(
    item: PlanItem, frame: int, seq: int, kind: int, partner: tuple[int, int], current: int, *, exact: bool
) -> Message:
    """The item in a MISSION_ITEM_INT when `exact`, else in a MISSION_ITEM; `frame` is what it is told to be in."""
    lat, lon = item.params[4:6]
    if exact:
        degree = 1e7 if item.has_place else 1.0
        lat, lon = round(lat * degree), round(lon * degree)
    message_kind = _MISSION_ITEM_INT if exact else _MISSION_ITEM
    return message_kind(
        *item.params[:4],
        x=lat,
        y=lon,
        z=item.params[6],
        seq=seq,
        command=item.command,
        target_system=partner[0],
        target_component=partner[1],
        frame=frame,
        current=int(seq == current),
        autocontinue=int(item.autocontinue),
        mission_type=kind,
    )
