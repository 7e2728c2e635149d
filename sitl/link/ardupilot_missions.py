"""The mission protocol on one link, as ArduPilot speaks it: upload, download, clear, progress.

Sources: ArduCopter 4.6.3 as it was seen, and MissionItemProtocol.cpp. It asks with MISSION_REQUEST, and says aloud what
was wrong. Of the vehicle's links one at a time may upload.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import common

from sitl.link.ardupilot_items import CAPACITY, item_of, message_of, with_home
from sitl.link.codec import Received
from sitl.link.helm import Helm
from sitl.link.messages import Message, MessageType, message_type
from sitl.link.report import Report
from sitl.link.telemetry import Builder
from sitl.orders import GoToItem, Mode, Reposition, TakePlan, Verdict
from sitl.plans import MissionRun, PlanItem, PlanKind

__all__ = ["COPTER_MISSION_MESSAGES", "COPTER_PROGRESS", "CopterPlanService"]

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
_STATUSTEXT = message_type("STATUSTEXT")

_ASK_AGAIN_US = 1_000_000
_GIVE_UP_US = 8_000_000
_ALL_KINDS = 255
_GUIDED_GOAL, _GUIDED_HEIGHT = 2, 3
_ACCEPTED, _ERROR = common.MAV_MISSION_ACCEPTED, common.MAV_MISSION_ERROR


@dataclass(slots=True)
class CopterPlanService:
    """The mission protocol on one link. What it remembers are values: `replace` copies it."""

    taking: bool = False
    kind: int = 0
    partner: tuple[int, int] = (0, 0)
    count: int = 0
    taken: tuple[PlanItem, ...] = ()
    asked_us: int = 0
    heard_us: int = 0
    told: MissionRun | None = None

    def receive(self, received: Received, helm: Helm) -> list[Message]:
        """The answer to a MISSION_ message."""
        handle = _HANDLERS.get(type(received.message))
        if handle is None:
            return []
        return handle(self, received.message, (received.system, received.component), helm)

    def proceed(self, helm: Helm) -> list[Message]:
        """What there is to send unasked in this frame: what was reached, and a request that found no answer."""
        messages: list[Message] = []
        if helm.run is not self.told:
            before, self.told = self.told, helm.run
            if before is not None and helm.run.reached > before.reached:
                messages.append(_ITEM_REACHED(helm.run.reached))
        if not self.taking:
            return messages
        if helm.time_us - self.heard_us >= _GIVE_UP_US:
            self._end(helm)
            text = _STATUSTEXT(common.MAV_SEVERITY_WARNING, b"Mission upload timeout", 0, 0)
            return [*messages, text, *self._answer(common.MAV_MISSION_OPERATION_CANCELLED)]
        if helm.time_us - self.asked_us >= _ASK_AGAIN_US:
            messages.append(self._ask(helm))
        return messages

    def _end(self, helm: Helm) -> None:
        self.taking, self.taken, helm.uploading = False, (), False

    def _ask(self, helm: Helm) -> Message:
        self.asked_us = helm.time_us
        return _REQUEST(len(self.taken), *self.partner, self.kind)

    def _answer(self, result: int, partner: tuple[int, int] | None = None) -> list[Message]:
        return [_ACK(*(partner or self.partner), result, self.kind)]

    def _on_count(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if helm.uploading and not self.taking:
            return [_ACK(*partner, common.MAV_MISSION_DENIED, message.mission_type)]
        if self.taking:
            self._end(helm)
        self.kind, self.partner = message.mission_type, partner
        if self.kind not in CAPACITY:
            return self._answer(common.MAV_MISSION_UNSUPPORTED)
        if message.count > CAPACITY[self.kind]:
            return self._answer(common.MAV_MISSION_NO_SPACE)
        if message.count == 0:
            helm.obey(TakePlan(PlanKind(self.kind), ()))
            return self._answer(_ACCEPTED)
        self.taking, self.count, self.taken, helm.uploading = True, message.count, (), True
        self.heard_us = helm.time_us
        return [self._ask(helm)]

    def _on_item(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if message.current in (_GUIDED_GOAL, _GUIDED_HEIGHT):
            return self._guided(message, partner, helm)
        if not self.taking or message.mission_type != self.kind:
            return [_ACK(*partner, _ERROR, message.mission_type)]
        if partner != self.partner:
            return [_ACK(*partner, common.MAV_MISSION_DENIED, message.mission_type)]
        if message.seq != len(self.taken):
            self._end(helm)
            return self._answer(common.MAV_MISSION_INVALID_SEQUENCE)
        item = item_of(message)
        if isinstance(item, int):
            self._end(helm)
            return self._answer(item)
        self.heard_us, self.taken = helm.time_us, (*self.taken, item)
        if len(self.taken) < self.count:
            return [self._ask(helm)]
        taken = self.taken
        self._end(helm)
        helm.obey(TakePlan(PlanKind(self.kind), taken))
        return self._answer(_ACCEPTED)

    def _guided(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        """An item to go to now, as ground stations send it: `current` is 2."""
        flight, item = helm.report().flight, item_of(message)
        if isinstance(item, int) or flight.mode is not Mode.GUIDED or flight.home is None:
            return [_ACK(*partner, item if isinstance(item, int) else _ERROR, 0)]
        lat_deg, lon_deg, alt_m = item.params[4:]
        base_m = flight.home.point.alt_amsl_m if item.is_relative else 0.0
        verdict = helm.obey(Reposition(lat_deg, lon_deg, base_m + alt_m, float("nan"), float("nan")))
        return [_ACK(*partner, _ACCEPTED if verdict is Verdict.ACCEPTED else _ERROR, 0)]

    def _on_clear(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if helm.uploading:
            return [_ACK(*partner, common.MAV_MISSION_DENIED, message.mission_type)]
        self.kind = message.mission_type
        for kind in PlanKind:
            if self.kind in (kind, _ALL_KINDS):
                helm.obey(TakePlan(kind, ()))
        return self._answer(_ACCEPTED, partner)

    def _on_list(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        self.kind = message.mission_type
        return [_COUNT(len(self._given(helm)), *partner, self.kind)]

    def _on_request(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        kind = message.mission_type
        self.kind = self.kind if self.taking else kind
        given = self._given(helm) if kind in CAPACITY else ()
        if not 0 <= message.seq < len(given):
            return [_ACK(*partner, _ERROR, kind)]
        exact = isinstance(message, _REQUEST_INT)
        current = helm.run.seq if kind == PlanKind.MISSION else -1
        return [message_of(given[message.seq], message.seq, kind, partner, current, exact=exact)]

    def _given(self, helm: Helm) -> tuple[PlanItem, ...]:
        if self.kind not in CAPACITY:
            return ()
        items = helm.plans.of(PlanKind(self.kind))
        return with_home(items, helm.report().flight.home) if self.kind == PlanKind.MISSION else items

    def _on_ack(self, _message: Message, _partner: tuple[int, int], _helm: Helm) -> list[Message]:
        return []

    def _on_set_current(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if helm.obey(GoToItem(message.seq)) is not Verdict.ACCEPTED:
            return [_ACK(*partner, _ERROR, 0)]
        return [_mission_current(helm.report())]


def _mission_current(report: Report) -> Message:
    flight = report.flight
    run, total = flight.run, max(0, len(flight.plans.mission) - 1)
    if not flight.mission_ok:
        state = common.MISSION_STATE_NO_MISSION
    elif run.finished:
        state = common.MISSION_STATE_COMPLETE
    elif flight.mode is Mode.AUTO and flight.armed:
        state = common.MISSION_STATE_ACTIVE
    else:
        state = common.MISSION_STATE_NOT_STARTED
    return _CURRENT(run.seq, total, state, 1 if flight.mode is Mode.AUTO else 2)


_HANDLERS: Mapping[
    MessageType, Callable[[CopterPlanService, Message, tuple[int, int], Helm], list[Message]]
] = {
    _COUNT: CopterPlanService._on_count,
    _ITEM: CopterPlanService._on_item,
    _ITEM_INT: CopterPlanService._on_item,
    _CLEAR_ALL: CopterPlanService._on_clear,
    _REQUEST_LIST: CopterPlanService._on_list,
    _REQUEST: CopterPlanService._on_request,
    _REQUEST_INT: CopterPlanService._on_request,
    _ACK: CopterPlanService._on_ack,
    _SET_CURRENT: CopterPlanService._on_set_current,
}
COPTER_MISSION_MESSAGES = tuple(_HANDLERS)
"""The messages that it understands."""
COPTER_PROGRESS: Mapping[MessageType, Builder] = {_CURRENT: _mission_current}
"""What of the mission can be asked for."""
