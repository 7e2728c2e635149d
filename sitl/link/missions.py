"""The mission protocol on one link, as PX4's mission manager speaks it: upload, download, clear, progress.

Sources: PX4 v1.17 as it was seen, and mavlink_mission.cpp. Of the vehicle's links one at a time may upload.
Simpler than PX4: what it says in EVENTs and texts is not said.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from pymavlink.dialects.v20 import common

from sitl.link.codec import Received
from sitl.link.helm import Helm
from sitl.link.messages import Message, MessageType, message_type
from sitl.link.plan_items import CAPACITY, item_of, message_of
from sitl.link.report import Report
from sitl.link.telemetry import Builder
from sitl.orders import GoToItem, Mode, TakePlan
from sitl.plans import MissionRun, PlanItem, PlanKind

__all__ = ["MISSION_MESSAGES", "PROGRESS", "PlanService"]

_COUNT = message_type("MISSION_COUNT")
_REQUEST = message_type("MISSION_REQUEST")
_REQUEST_INT = message_type("MISSION_REQUEST_INT")
_REQUEST_LIST = message_type("MISSION_REQUEST_LIST")
_ITEM = message_type("MISSION_ITEM")
_ITEM_INT = message_type("MISSION_ITEM_INT")
_ACK = message_type("MISSION_ACK")
_CLEAR_ALL = message_type("MISSION_CLEAR_ALL")
_SET_CURRENT = message_type("MISSION_SET_CURRENT")
_CURRENT = message_type("MISSION_CURRENT")
_ITEM_REACHED = message_type("MISSION_ITEM_REACHED")

_ASK_AGAIN_US = 260_000
_GIVE_UP_US = 5_070_000
_SLOWLY_US = 1_000_000
_REACHED_REPEATS = 10
_ALL_KINDS = 255
_ACCEPTED, _ERROR = common.MAV_MISSION_ACCEPTED, common.MAV_MISSION_ERROR
_IN_MISSION = (Mode.MISSION, Mode.TAKEOFF, Mode.LAND)


class _State(Enum):
    IDLE = auto()
    TAKING = auto()
    GIVING = auto()


_IDLE = _State.IDLE


@dataclass(slots=True)
class PlanService:
    """The mission protocol on one link. What it remembers are values: `replace` copies it."""

    state: _State = _State.IDLE
    kind: int = 0
    partner: tuple[int, int] = (0, 0)
    seq: int = 0
    count: int = 0
    taken: tuple[PlanItem, ...] = ()
    current: int = 0
    exact: bool = True
    sent_us: int = 0
    heard_us: int = 0
    told: MissionRun | None = None
    told_reached: int = -1
    repeats: int = 0
    slow_us: int = 0

    def receive(self, received: Received, helm: Helm) -> list[Message]:
        """The answer to a MISSION_ message."""
        handle = _HANDLERS.get(type(received.message))
        if handle is None:
            return []
        return handle(self, received.message, (received.system, received.component), helm)

    def due_us(self, helm: Helm) -> int:
        """When `proceed` will have something to do, unless the mission goes on before; zero is at once."""
        return self.slow_us if self.state is _IDLE and helm.run is self.told else 0

    def proceed(self, helm: Helm) -> list[Message]:
        """What there is to send unasked in this frame: progress, and a request that found no answer."""
        now_us, messages = helm.time_us, []
        if now_us >= self.slow_us or helm.run is not self.told:
            messages += self._progress(helm)
        if self.state is _IDLE:
            return messages
        if self.state is _State.TAKING and now_us - self.sent_us >= _ASK_AGAIN_US:
            messages.append(self._ask(helm))
        if now_us - self.heard_us >= _GIVE_UP_US:
            self._end(helm)
        return messages

    def _progress(self, helm: Helm) -> list[Message]:
        run, news = helm.run, []
        slow = helm.time_us >= self.slow_us
        if slow:
            self.slow_us = helm.time_us + _SLOWLY_US
        if slow or self.told is None or run.seq != self.told.seq:
            news.append(_mission_current(helm.report()))
        if run.reached != self.told_reached:
            self.told_reached, self.repeats = run.reached, _REACHED_REPEATS
            if run.reached >= 0:
                news.append(_ITEM_REACHED(run.reached))
        elif slow and run.reached >= 0 and self.repeats > 0:
            self.repeats -= 1
            news.append(_ITEM_REACHED(run.reached))
        self.told = run
        return news

    def _end(self, helm: Helm) -> None:
        if self.state is _State.TAKING:
            helm.uploading = False
        self.state, self.taken = _State.IDLE, ()

    def _ask(self, helm: Helm) -> Message:
        self.sent_us = helm.time_us
        request = _REQUEST_INT if self.exact else _REQUEST
        return request(self.seq, *self.partner, self.kind)

    def _answer(self, result: int, partner: tuple[int, int] | None = None) -> list[Message]:
        return [_ACK(*(partner or self.partner), result, self.kind)]

    def _on_count(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        again = self.state is _State.TAKING and self.seq == 0 and partner == self.partner
        if again:
            self.heard_us = helm.time_us
            return [self._ask(helm)]
        if self.state is not _State.IDLE or helm.uploading:
            return [_ACK(*partner, _ERROR, message.mission_type)]
        self.kind, self.partner, self.heard_us = message.mission_type, partner, helm.time_us
        if message.count > CAPACITY.get(self.kind, 0):
            return self._answer(common.MAV_MISSION_NO_SPACE)
        if message.count == 0:
            if self.kind in CAPACITY:
                helm.obey(TakePlan(PlanKind(self.kind), ()))
            return self._answer(_ACCEPTED)
        self.state, self.seq, self.count = _State.TAKING, 0, message.count
        self.taken, self.current, helm.uploading = (), 0, True
        return [self._ask(helm)]

    def _on_item(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        self.exact = isinstance(message, _ITEM_INT)
        if partner != self.partner:
            return []
        if message.mission_type != self.kind or self.state is _State.GIVING:
            return self._answer(_ERROR)
        if self.state is _State.IDLE:  # the last one again: our acknowledgement was lost
            return self._answer(_ACCEPTED if self.seq and message.seq + 1 == self.seq else _ERROR)
        self.heard_us = helm.time_us
        if message.seq != self.seq:
            return []
        item = item_of(message)
        if isinstance(item, int):
            self._end(helm)
            self.seq = 0
            return self._answer(item)
        self.taken, self.seq = (*self.taken, item), self.seq + 1
        if message.current:
            self.current = message.seq
        if self.seq < self.count:
            return [self._ask(helm)]
        taken = self.taken
        self._end(helm)
        helm.obey(TakePlan(PlanKind(self.kind), taken, self.current))
        return self._answer(_ACCEPTED)

    def _on_clear(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if self.state is not _State.IDLE:
            return []
        self.kind = message.mission_type
        kinds = tuple(PlanKind) if self.kind == _ALL_KINDS else tuple(k for k in PlanKind if k == self.kind)
        for kind in kinds:
            helm.obey(TakePlan(kind, ()))
        return self._answer(_ACCEPTED, partner)

    def _on_list(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        mine = partner == self.partner and message.mission_type == self.kind
        over = self.state is _State.GIVING and (mine or self.seq == self.count)
        if self.state is not _State.IDLE and not over:
            return []
        self.kind, self.partner, self.heard_us = message.mission_type, partner, helm.time_us
        self.state, self.seq, self.count = _State.GIVING, 0, len(self._given(helm))
        return [_COUNT(self.count, *partner, self.kind)]

    def _on_request(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if self.state is not _State.GIVING or partner != self.partner or message.mission_type != self.kind:
            return []
        self.exact, self.heard_us = isinstance(message, _REQUEST_INT), helm.time_us
        given = self._given(helm)
        wanted = message.seq in (self.seq - 1, self.seq) and 0 <= message.seq < min(self.count, len(given))
        if not wanted:
            self._end(helm)
            return self._answer(_ERROR)
        self.seq = max(self.seq, message.seq + 1)
        current = helm.run.seq if self.kind == PlanKind.MISSION else -1
        return [message_of(given[message.seq], message.seq, self.kind, partner, current, exact=self.exact)]

    def _given(self, helm: Helm) -> tuple[PlanItem, ...]:
        return helm.plans.of(PlanKind(self.kind)) if self.kind in CAPACITY else ()

    def _on_ack(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if partner != self.partner:
            return []
        over = self.state is _State.GIVING and message.mission_type == self.kind
        if over or message.type == common.MAV_MISSION_OPERATION_CANCELLED:
            self._end(helm)
        elif self.state is _State.TAKING and message.type == common.MAV_MISSION_UNSUPPORTED:
            self.exact = not self.exact
            return [self._ask(helm)]
        return []

    def _on_set_current(self, message: Message, _: tuple[int, int], helm: Helm) -> list[Message]:
        if self.state is _State.IDLE:
            helm.obey(GoToItem(message.seq))
        return []


def _mission_current(report: Report) -> Message:
    flight = report.flight
    run, total = flight.run, len(flight.plans.mission)
    if not flight.mission_ok:
        state = common.MISSION_STATE_NO_MISSION
    elif run.finished:
        state = common.MISSION_STATE_COMPLETE
    elif flight.mode in _IN_MISSION:
        state = common.MISSION_STATE_ACTIVE
    elif run.reached >= 0:
        state = common.MISSION_STATE_PAUSED
    else:
        state = common.MISSION_STATE_NOT_STARTED
    return _CURRENT(run.seq, total, state, 1 if flight.mode in _IN_MISSION else 2)


_HANDLERS: Mapping[MessageType, Callable[[PlanService, Message, tuple[int, int], Helm], list[Message]]] = {
    _COUNT: PlanService._on_count,
    _ITEM: PlanService._on_item,
    _ITEM_INT: PlanService._on_item,
    _CLEAR_ALL: PlanService._on_clear,
    _REQUEST_LIST: PlanService._on_list,
    _REQUEST: PlanService._on_request,
    _REQUEST_INT: PlanService._on_request,
    _ACK: PlanService._on_ack,
    _SET_CURRENT: PlanService._on_set_current,
}
MISSION_MESSAGES = tuple(_HANDLERS)
"""The messages that it understands."""
PROGRESS: Mapping[MessageType, Builder] = {_CURRENT: _mission_current}
"""What of the mission can be asked for."""
