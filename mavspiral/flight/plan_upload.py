"""All three lists of a plan on their way to a vehicle, one after the other, each read back and compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mavspiral.flight.link import Link
from mavspiral.flight.messages import Message
from mavspiral.flight.mission_differences import differences
from mavspiral.flight.mission_messages import MissionItem, MissionKind
from mavspiral.flight.mission_protocol import MissionTransfer

__all__ = ["MissionLists", "PlanUpload"]

MissionLists = Mapping[MissionKind, Sequence[MissionItem]]
"""The items of each of the vehicle's lists; one that is not there is cleared."""


class PlanUpload:
    """`step(now_us, messages) -> bytes` until `done`; then `differences` tells what came back otherwise.

    Args:
        link: to a vehicle that is known.
        lists: what to upload.
        home_first: the mission's first item is home, which the vehicle overwrites with its own, as ArduPilot does.
    """

    def __init__(self, link: Link, lists: MissionLists, *, home_first: bool = False) -> None:
        self.differences: dict[MissionKind, tuple[str, ...]] = {}
        self._link, self._home_first = link, home_first
        self._lists = [(kind, tuple(lists.get(kind, ()))) for kind in MissionKind]
        self._transfer: MissionTransfer | None = None

    @property
    def done(self) -> bool:
        """Whether all lists have been read back."""
        return len(self.differences) == len(self._lists)

    def step(self, now_us: int, messages: Sequence[Message]) -> bytes:
        """Take in what came; what to send now.

        Raises:
            LimitError: the vehicle refuses a list.
            LinkError: nothing has moved for too long.
        """
        out = b""
        while not self.done:
            kind, items = self._lists[len(self.differences)]
            if self._transfer is None:
                self._transfer = MissionTransfer(self._link, kind, items)
            out += self._transfer.step(now_us, messages)
            if not self._transfer.done:
                break
            own_n = 1 if self._home_first and kind is MissionKind.MISSION else 0
            self.differences[kind] = differences(items[own_n:], self._transfer.back[own_n:])
            self._transfer, messages = None, ()
        return out
