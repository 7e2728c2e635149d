"""An upload that broke in an ArduPilot, taken up where it broke.

ArduPilot asks for an item but once a second and ends an upload 8 s after the last one. What had come by then it keeps, and
MISSION_WRITE_PARTIAL_LIST(k, k) lets item k be written once more, or appended where k items are there (ArduPilot's
MissionItemProtocol.cpp, handle_mission_write_partial_list). So the rest is sent by such lists of one, each with its item
behind it, a few at a time, as often as we like: each may come twice, and one that comes too early is rejected.

What has arrived is told by MISSION_REQUEST k, which is sent only where all before k are there, and by MISSION_COUNT. Both
count what is stored, so the tail of an older, longer mission is cut off first: an offer of k items does that. An
acknowledgement says nothing, because it has no number.
"""

from __future__ import annotations

from collections.abc import Sequence

from mavspiral.flight.link import Link
from mavspiral.flight.messages import Message
from mavspiral.flight.mission_messages import MissionCount, MissionItem, MissionKind, MissionRequest

__all__ = ["MissionMending"]

_AT_ONCE_N = 4


class MissionMending:
    """Sends `items` from number `first` on, until `done`: `hear` what came, `ask` for what is missing.

    Args:
        link: to a vehicle that is known.
        kind: the mission or the rally points: a fence is kept whole or not at all.
        items: the whole list.
        first: as many items of it are there, at least one.
    """

    def __init__(self, link: Link, kind: MissionKind, items: Sequence[MissionItem], first: int) -> None:
        self.stored_n = first
        """As many items are known to be there."""
        self.done = False
        self._link, self._kind, self._items, self._first = link, kind, items, first
        self._cut = False

    @property
    def on_the_way(self) -> range:
        """The numbers of the items that are sent together now."""
        return range(self.stored_n, min(self.stored_n + _AT_ONCE_N, len(self._items)))

    def ask(self) -> bytes:
        """What is to be sent, and again while nothing answers."""
        link, kind = self._link, self._kind
        if not self._cut:
            return link.mission_count(self._first, kind)
        parts = (
            link.mission_part(seq, seq, kind) + link.mission_item(self._items[seq]) for seq in self.on_the_way
        )
        return b"".join(parts) + link.mission_list_request(kind)

    def hear(self, message: Message) -> bool:
        """Take in a message; whether other items are on the way after it, to be sent at once."""
        match message:
            case MissionRequest(0, self._kind) if not self._cut:
                self._cut = True
                return True
            case MissionRequest(seq, self._kind) if self._cut and self.stored_n < seq < len(self._items):
                self.stored_n = seq
                return True
            case MissionCount(total, self._kind) if self._cut and total <= len(self._items):
                moved = total != self.stored_n
                self.stored_n, self.done = total, total == len(self._items)
                return moved
        return False
