"""All three lists of a plan on their way to a vehicle, one after the other, each read back and compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mavspiral.flight.link import Link
from mavspiral.flight.messages import Message
from mavspiral.flight.mission_differences import differences
from mavspiral.flight.mission_messages import MissionItem, MissionKind
from mavspiral.flight.mission_protocol import MissionTransfer

__all__ = ["MissionLists", "PlanUpload"]

_REPEATS_MAX = 3

MissionLists = Mapping[MissionKind, Sequence[MissionItem]]
"""The items of each of the vehicle's lists; one that is not there is cleared."""


class PlanUpload:
    """`step(now_us, messages) -> bytes` until `done`; then `differences` tells what came back otherwise.

    Args:
        link: to a vehicle that is known.
        lists: what to upload.
        ardupilot: the vehicle is an ArduPilot: the mission's first item is home, which it overwrites with its own, and
            its broken uploads can be mended.
    """

    def __init__(self, link: Link, lists: MissionLists, *, ardupilot: bool = False) -> None:
        self.differences: dict[MissionKind, tuple[str, ...]] = {}
        self._link, self._ardupilot = link, ardupilot
        self._repeats_n = 0
        self._lists = [(kind, tuple(lists.get(kind, ()))) for kind in MissionKind]
        self._transfer: MissionTransfer | None = None

    @property
    def done(self) -> bool:
        """Whether all lists have been read back."""
        return len(self.differences) == len(self._lists)

    @property
    def progress(self) -> str:
        """How far it is, in words."""
        if self._transfer is None:
            return ""
        doing, done_n, of_n = self._transfer.progress
        return f"{self._lists[len(self.differences)][0].name.lower()}: {doing}, {done_n} of {of_n}"

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
                self._transfer = MissionTransfer(self._link, kind, items, ardupilot=self._ardupilot)
            out += self._transfer.step(now_us, messages)
            if not self._transfer.done:
                break
            own_n = 1 if self._ardupilot and kind is MissionKind.MISSION else 0
            wrong = differences(items[own_n:], self._transfer.back[own_n:])
            if wrong and not self._transfer.proven and self._repeats_n < _REPEATS_MAX:
                self._repeats_n += 1
            else:
                self.differences[kind] = wrong
            self._transfer, messages = None, ()
        return out
