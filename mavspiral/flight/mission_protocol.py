"""MAVLink's mission protocol from the ground's side, without a socket: upload a list and read it back.

The vehicle leads an upload: it asks for each item, again when no answer comes, and ends it with a MISSION_ACK.
We lead the reading back. Whatever was not answered is sent again, so that loss costs time and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

from mavspiral.errors import LimitError, LinkError
from mavspiral.flight.link import Link
from mavspiral.flight.messages import Message
from mavspiral.flight.mission_messages import (
    MissionAck,
    MissionCount,
    MissionItem,
    MissionKind,
    MissionRequest,
    MissionResult,
)

__all__ = ["MissionTransfer"]

AGAIN_US = 300_000
"""A little more than PX4 waits for an item, 260 ms, before it asks again."""

STUCK_US = 9_000_000
"""PX4 gives an upload up after 5 s without an item, ArduPilot after 8 s; then it can begin anew."""

PATIENCE_US = 30_000_000
STARTS_MAX = 4


class _State(Enum):
    OFFERING = "offering"
    GIVING = "uploading"
    LISTING = "asking for the list"
    TAKING = "reading back"
    OVER = "over"


class MissionTransfer:
    """One list of items on its way up and back down: `step(now_us, messages) -> bytes` until `done`.

    Args:
        link: to a vehicle that is known.
        kind: which of the vehicle's three lists.
        items: numbered from 0; none clears the list.
    """

    def __init__(self, link: Link, kind: MissionKind, items: Sequence[MissionItem]) -> None:
        self.back: tuple[MissionItem, ...] = ()
        self.sent_n = 0
        """How many items and requests went out, repeated ones too."""
        self._link, self._kind, self._items = link, kind, tuple(items)
        self._state = _State.OFFERING
        self._given: int | None = None
        self._taken: list[MissionItem] = []
        self._count = 0
        self._asked_us: int | None = None
        self._stirred_us: int | None = None
        self._starts = 0

    @property
    def done(self) -> bool:
        """Whether the vehicle has the list and we have read it back into `back`."""
        return self._state is _State.OVER

    def step(self, now_us: int, messages: Sequence[Message]) -> bytes:
        """Take in what came; what to send now.

        Raises:
            LimitError: the vehicle refuses the list.
            LinkError: nothing has moved for too long.
        """
        if self._stirred_us is None:
            self._stirred_us = now_us
        out = b"".join(self._answer(now_us, message) for message in messages)
        if self.done:
            return out
        silent_us = now_us - self._stirred_us
        if silent_us > PATIENCE_US:
            raise LinkError(
                f"{self._state.value} the {self._kind.name.lower()}: nothing moved for {silent_us / 1e6:.0f} s"
            )
        if self._state is _State.GIVING and silent_us > STUCK_US:
            self._restart("the vehicle asks for nothing more")
        if self._asked_us is None or now_us - self._asked_us >= AGAIN_US:
            out += self._ask(now_us)
        return out

    def _ask(self, now_us: int) -> bytes:
        """What is waited for, asked for once more."""
        self._asked_us = now_us
        link, kind = self._link, self._kind
        self.sent_n += 1
        match self._state:
            case _State.OFFERING:
                return link.mission_count(len(self._items), kind)
            case _State.GIVING if self._given == len(self._items) - 1:  # perhaps its acknowledgement was lost
                return link.mission_item(self._items[-1])
            case _State.LISTING:
                return link.mission_list_request(kind)
            case _State.TAKING:
                return link.mission_request(len(self._taken), kind)
        self.sent_n -= 1
        return b""

    def _answer(self, now_us: int, message: Message) -> bytes:
        match self._state, message:
            case ((_State.OFFERING | _State.GIVING), MissionRequest(seq, self._kind)):
                return self._give(now_us, seq)
            case ((_State.OFFERING | _State.GIVING), MissionAck(result, self._kind)):
                return self._judged(now_us, result)
            case _State.LISTING, MissionCount(count, self._kind):
                self._count = count
                return self._take_next(now_us)
            case _State.TAKING, MissionItem(seq=seq, kind=self._kind) if seq == len(self._taken):
                self._taken.append(message)
                return self._take_next(now_us)
        return b""

    def _give(self, now_us: int, seq: int) -> bytes:
        if not 0 <= seq < len(self._items):
            return b""
        if seq != self._given:
            self._stirred_us = now_us
        self._state, self._given, self._asked_us = _State.GIVING, seq, now_us
        self.sent_n += 1
        return self._link.mission_item(self._items[seq])

    def _judged(self, now_us: int, result: int) -> bytes:
        complete = self._given == len(self._items) - 1 or not self._items
        if result == MissionResult.ACCEPTED:
            if not complete:  # of an earlier upload
                return b""
            self._state, self._stirred_us = _State.LISTING, now_us
            return self._ask(now_us)
        if result in (MissionResult.ERROR, MissionResult.OPERATION_CANCELLED):
            # PX4's word for an offer that came twice, and goes on asking; if it does not, we begin anew.
            return b""
        name = MissionResult(result).name if result in set(MissionResult) else str(result)
        where = (
            "" if self._given is None else f" at item {self._given + 1}: {_words(self._items[self._given])}"
        )
        raise LimitError(f"the vehicle refuses the {self._kind.name.lower()}{where} ({name})")

    def _take_next(self, now_us: int) -> bytes:
        self._stirred_us = now_us
        if len(self._taken) < self._count:
            self._state = _State.TAKING
            return self._ask(now_us)
        self._state, self.back = _State.OVER, tuple(self._taken)
        return self._link.mission_ack(self._kind)

    def _restart(self, why: str) -> None:
        self._starts += 1
        if self._starts >= STARTS_MAX:
            raise LinkError(f"uploading the {self._kind.name.lower()}: {why}, {self._starts} times in a row")
        self._state, self._given, self._asked_us = _State.OFFERING, None, None


def _words(item: MissionItem) -> str:
    return f"command {item.command} in frame {item.frame}"
