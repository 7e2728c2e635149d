"""MAVLink's mission protocol from the ground's side, without a socket: upload a list and read it back.

The vehicle leads an upload: it asks for each item, again when no answer comes, and ends it with a MISSION_ACK. Where an
ArduPilot has ended it too early, we go on (`mission_mending`). We lead the reading back. Whatever was not answered is sent
again, so that loss costs time and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

from mavspiral.errors import LimitError, LinkError
from mavspiral.flight.link import Link
from mavspiral.flight.messages import Message
from mavspiral.flight.mission_mending import MissionMending
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

OFFER_AGAIN_US = 1_000_000
"""An offer that comes late, behind the first item, would begin the upload anew."""

AGAIN_MAX_US = 1_000_000

STUCK_US = 9_000_000
"""PX4 gives an upload up after 5 s without an item, ArduPilot after 8 s; then it can begin anew."""

STALLED_US = 3_000_000
"""Without a new request for so long, an ArduPilot's upload is mended: it has asked three times, and will five times more."""

PATIENCE_US = 30_000_000
STARTS_MAX = 8
"""With 30 % lost each way an ArduPilot ends one upload of 20 corners in ten, and one of 70 in four: eight will not all end."""


class _State(Enum):
    OFFERING = "offering"
    GIVING = "uploading"
    MENDING = "mending"
    LISTING = "asking for the list"
    TAKING = "reading back"
    OVER = "over"


_UPLOADING = (_State.OFFERING, _State.GIVING, _State.MENDING)
_PASSING = {
    # PX4's word for an offer that came twice, ArduPilot's for an item or a partial list that nobody waits for.
    MissionResult.ERROR,
    # ArduPilot's for an item that came twice. It may have ended the upload or not: we do not count on either.
    MissionResult.INVALID_SEQUENCE,
    # ArduPilot has given the upload up.
    MissionResult.OPERATION_CANCELLED,
}


class MissionTransfer:
    """One list of items on its way up and back down: `step(now_us, messages) -> bytes` until `done`.

    Args:
        link: to a vehicle that is known.
        kind: which of the vehicle's three lists.
        items: numbered from 0; none clears the list.
        ardupilot: the vehicle is an ArduPilot, whose broken uploads can be mended.
    """

    def __init__(
        self, link: Link, kind: MissionKind, items: Sequence[MissionItem], *, ardupilot: bool = False
    ) -> None:
        self.back: tuple[MissionItem, ...] = ()
        self.sent_n = 0
        """How many times something was sent: an offer, an item, a request, a handful of partial lists."""
        self.proven = True
        """Whether the vehicle said that it has all of it; else only what is read back tells."""
        self._link, self._kind, self._items = link, kind, tuple(items)
        self._ardupilot = ardupilot
        self._state = _State.OFFERING
        self._given: int | None = None
        self._mending: MissionMending | None = None
        self._taken: list[MissionItem] = []
        self._count = 0
        self._asked_us: int | None = None
        self._first_asked_us = 0
        self._round_trip_us: int | None = None
        self._stirred_us: int | None = None
        self._starts = 0

    @property
    def done(self) -> bool:
        """Whether the vehicle has the list and we have read it back into `back`."""
        return self._state is _State.OVER

    @property
    def progress(self) -> tuple[str, int, int]:
        """What is being done, how many items of it are behind us, and of how many."""
        if self._state in (_State.LISTING, _State.TAKING, _State.OVER):
            return _State.TAKING.value, len(self._taken), self._count or len(self._items)
        there_n = self._given or 0 if self._mending is None else self._mending.stored_n
        return _State.GIVING.value, there_n, len(self._items)

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
        if self._state is _State.GIVING:
            if silent_us > STALLED_US and self._mendable:
                self._mend(now_us)
            elif silent_us > STUCK_US:
                self._restart("the vehicle asks for nothing more")
        if self._asked_us is None or now_us - self._asked_us >= self._again_us:
            out += self._ask(now_us)
        return out

    @property
    def _again_us(self) -> int:
        """After which time to repeat what was not answered: not before the link's quickest answer could have come."""
        if self._state is _State.OFFERING:
            return OFFER_AGAIN_US
        return min(max(AGAIN_US, 5 * (self._round_trip_us or 0) // 4), AGAIN_MAX_US)

    @property
    def _mendable(self) -> bool:
        return self._ardupilot and self._kind is not MissionKind.FENCE and bool(self._given)

    def _mend(self, now_us: int) -> None:
        self._state, self._stirred_us, self._asked_us = _State.MENDING, now_us, None
        self._first_asked_us = now_us
        self._mending = MissionMending(self._link, self._kind, self._items, self._given or 0)

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
            case _State.MENDING if self._mending is not None:
                return self._mending.ask()
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
            case state, MissionAck(result, self._kind) if state in _UPLOADING:
                return self._judged(now_us, result)
            case _State.MENDING, (MissionRequest() | MissionCount()):
                return self._mended(now_us, message)
            case _State.LISTING, MissionCount(count, self._kind):
                self._count = count
                return self._take_next(now_us)
            case _State.TAKING, MissionItem(seq=seq, kind=self._kind) if seq == len(self._taken):
                self._measure(now_us)
                self._taken.append(message)
                return self._take_next(now_us)
        return b""

    def _give(self, now_us: int, seq: int) -> bytes:
        if not 0 <= seq < len(self._items):
            return b""
        if seq != self._given:
            if self._given == seq - 1:
                self._measure(now_us)
            self._stirred_us = self._first_asked_us = now_us
        self._state, self._given, self._asked_us = _State.GIVING, seq, now_us
        self.sent_n += 1
        return self._link.mission_item(self._items[seq])

    def _mended(self, now_us: int, message: Message) -> bytes:
        mending = self._mending
        assert mending is not None
        there_n = mending.stored_n
        if mending.hear(message):
            self._asked_us = None
        if mending.stored_n > there_n:
            self._measure(now_us)
            self._stirred_us = self._first_asked_us = now_us
        if not mending.done:
            return b""
        self._count = len(self._items)
        return self._take_next(now_us)

    def _measure(self, now_us: int) -> None:
        """The quickest answer there ever was, to what may have been asked more than once."""
        round_trip_us = now_us - self._first_asked_us
        self._round_trip_us = min(round_trip_us, self._round_trip_us or round_trip_us)

    def _judged(self, now_us: int, result: int) -> bytes:
        complete = self._given == len(self._items) - 1 or not self._items
        if result == MissionResult.ACCEPTED:
            if not complete or self._state is _State.MENDING:  # of an earlier upload, or of a part
                return b""
            return self._list(now_us)
        if result in _PASSING:
            return self._passed(now_us, result)
        # It is being written, not listed.
        if self._state is _State.MENDING and result == MissionResult.DENIED:
            return b""
        name = MissionResult(result).name if result in set(MissionResult) else str(result)
        raise LimitError(f"the vehicle refuses the {self._kind.name.lower()}{self._where()} ({name})")

    def _passed(self, now_us: int, result: int) -> bytes:
        """An ArduPilot that is not uploading any more has all of it, or has given it up."""
        if not self._ardupilot or self._state is not _State.GIVING:
            return b""
        if result == MissionResult.ERROR and self._given == len(self._items) - 1:
            self.proven = False
            return self._list(now_us)
        if result == MissionResult.OPERATION_CANCELLED:
            if self._mendable:
                self._mend(now_us)
            else:
                self._restart("the vehicle gives it up")
        return b""

    def _list(self, now_us: int) -> bytes:
        self._state, self._stirred_us = _State.LISTING, now_us
        return self._ask(now_us)

    def _where(self) -> str:
        if self._mending is not None:
            numbers = self._mending.on_the_way
            return f" at one of the items {numbers.start + 1} to {numbers.stop}"
        if self._given is None:
            return ""
        item = self._items[self._given]
        return f" at item {self._given + 1}: command {item.command} in frame {item.frame}"

    def _take_next(self, now_us: int) -> bytes:
        self._stirred_us = self._first_asked_us = now_us
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
