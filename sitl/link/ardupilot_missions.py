"""The mission protocol on one link, as ArduPilot speaks it: upload, download, clear, progress.

Sources: ArduCopter 4.6.3 as it was seen, and MissionItemProtocol.cpp with its _Waypoints, _Fence and _Rally. It asks with
MISSION_REQUEST, and says aloud what was wrong. Items of a mission and rally points are kept as they come, so that an upload
that breaks leaves them; a fence is kept when it is complete. Of the vehicle's links one at a time may upload. Where the
source answers a wrong number and goes on waiting, ArduCopter was seen to end the upload, and so does this one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import common

from sitl.link.ardupilot_fence import fence_fault
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
_PARTIAL = message_type("MISSION_WRITE_PARTIAL_LIST")
_CLEAR_ALL = message_type("MISSION_CLEAR_ALL")
_SET_CURRENT = message_type("MISSION_SET_CURRENT")
_CURRENT = message_type("MISSION_CURRENT")
_ITEM_REACHED = message_type("MISSION_ITEM_REACHED")
_STATUSTEXT = message_type("STATUSTEXT")

_ASK_AGAIN_US = 1_000_000
_GIVE_UP_US = 8_000_000
_ALL_KINDS = 255
_DO_JUMP = 177
_GUIDED_GOAL, _GUIDED_HEIGHT = 2, 3
_ACCEPTED, _ERROR = common.MAV_MISSION_ACCEPTED, common.MAV_MISSION_ERROR


@dataclass(slots=True)
class CopterPlanService:
    """The mission protocol on one link. What it remembers are values: `replace` copies it."""

    taking: bool = False
    kind: int = 0
    partner: tuple[int, int] = (0, 0)
    next: int = 0
    last: int = 0
    anew: bool = False
    fence: tuple[PlanItem | None, ...] = ()
    asked_us: int = 0
    heard_us: int = 0
    told: MissionRun | None = None

    def receive(self, received: Received, helm: Helm) -> list[Message]:
        """The answer to a MISSION_ message."""
        handle = _HANDLERS.get(type(received.message))
        if handle is None:
            return []
        return handle(self, received.message, (received.system, received.component), helm)

    def is_busy(self, helm: Helm) -> bool:
        """Whether there may be something to send in this frame."""
        return self.taking or helm.run is not self.told

    def proceed(self, helm: Helm) -> list[Message]:
        """What there is to send unasked in this frame: what was reached, and a request that found no answer."""
        messages: list[Message] = []
        if helm.run is not self.told:
            before, self.told = self.told, helm.run
            if before is not None and -1 < helm.run.reached != before.reached:
                messages.append(_ITEM_REACHED(helm.run.reached))
        if not self.taking:
            return messages
        if helm.time_us - self.heard_us >= _GIVE_UP_US:
            self._end(helm)
            text = f"{PlanKind(self.kind).name.title()} upload timeout"
            return [*messages, _warning(text), *self._answer(common.MAV_MISSION_OPERATION_CANCELLED)]
        if helm.time_us - self.asked_us >= _ASK_AGAIN_US:
            messages.append(self._ask(helm))
        return messages

    def _end(self, helm: Helm) -> None:
        self.taking, self.fence, helm.uploading = False, (), False

    def _ask(self, helm: Helm) -> Message:
        self.asked_us = helm.time_us
        return _REQUEST(self.next, *self.partner, self.kind)

    def _answer(self, result: int) -> list[Message]:
        return [_ACK(*self.partner, result, self.kind)]

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
        kept = helm.plans.of(PlanKind(self.kind))
        if message.count == 0 or (self.kind != PlanKind.FENCE and message.count < len(kept)):
            helm.obey(TakePlan(PlanKind(self.kind), kept[: message.count]))
        if message.count == 0:
            return self._answer(_ACCEPTED)
        self.fence = (None,) * message.count if self.kind == PlanKind.FENCE else ()
        self._expect(0, message.count - 1, helm)
        self.anew = True
        return [self._ask(helm)]

    def _on_partial(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        """Some items again, or one more. It is asked for behind what else came in the same frame, as the source defers it."""
        if helm.uploading and not self.taking:
            return [_ACK(*partner, common.MAV_MISSION_DENIED, message.mission_type)]
        kind = message.mission_type
        if kind not in CAPACITY:
            return [_ACK(*partner, common.MAV_MISSION_UNSUPPORTED, kind)]
        kept = helm.plans.of(PlanKind(kind))
        if not 0 <= message.start_index <= message.end_index <= len(kept):
            return [_warning("Flight plan update rejected"), _ACK(*partner, _ERROR, kind)]
        if self.taking and self.kind == kind == PlanKind.FENCE:
            return [_ACK(*partner, _ERROR, kind)]
        self.kind, self.partner, self.fence = kind, partner, kept if kind == PlanKind.FENCE else ()
        self._expect(message.start_index, message.end_index, helm)
        self.asked_us = helm.time_us - _ASK_AGAIN_US
        return []

    def _expect(self, first: int, last: int, helm: Helm) -> None:
        self.taking, self.next, self.last, helm.uploading = True, first, last, True
        self.heard_us, self.anew = helm.time_us, False

    def _on_item(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if message.current in (_GUIDED_GOAL, _GUIDED_HEIGHT):
            return self._guided(message, partner, helm)
        if not self.taking or message.mission_type != self.kind:
            return [_ACK(*partner, _ERROR, message.mission_type)]
        if partner != self.partner:
            return [_ACK(*partner, common.MAV_MISSION_DENIED, message.mission_type)]
        if message.seq != self.next:
            self._end(helm)
            return self._answer(common.MAV_MISSION_INVALID_SEQUENCE)
        item = item_of(message)
        refusal = item if isinstance(item, int) else self._keep(item, helm)
        if refusal:
            self._end(helm)
            return self._answer(refusal)
        self.heard_us, self.next = helm.time_us, self.next + 1
        if self.next <= self.last:
            return [self._ask(helm)]
        if self.kind == PlanKind.FENCE:
            whole = tuple(corner for corner in self.fence if corner is not None)
            fault = fence_fault(whole)
            if fault is not None:
                self._end(helm)
                return [_warning(fault), *self._answer(_ERROR)]
            helm.obey(TakePlan(PlanKind.FENCE, whole))
        elif self.anew:
            helm.obey(TakePlan(PlanKind(self.kind), helm.plans.of(PlanKind(self.kind))))
        self._end(helm)
        return self._answer(_ACCEPTED)

    def _keep(self, item: PlanItem, helm: Helm) -> int:
        """Put the item where it was asked for; the MAV_MISSION_RESULT that refuses it, or 0."""
        seq = self.next
        if self.kind == PlanKind.FENCE:
            if seq >= len(self.fence):
                return int(common.MAV_MISSION_INVALID_SEQUENCE)
            self.fence = (*self.fence[:seq], item, *self.fence[seq + 1 :])
            return 0
        kept = helm.plans.of(PlanKind(self.kind))
        if item.command == _DO_JUMP:
            target = item.params[0]
            if target == 0 or (target >= len(kept) and target > self.last):
                return int(_ERROR)
        if seq > len(kept):
            return int(_ERROR)
        helm.obey(TakePlan(PlanKind(self.kind), (*kept[:seq], item, *kept[seq + 1 :]), restart=False))
        return 0

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
        for kind in PlanKind:
            if message.mission_type in (kind, _ALL_KINDS):
                helm.obey(TakePlan(kind, ()))
        return [_ACK(*partner, _ACCEPTED, message.mission_type)]

    def _on_list(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        kind = message.mission_type
        if self.taking and kind == self.kind:
            return [_ACK(*partner, common.MAV_MISSION_DENIED, kind)]
        return [_COUNT(len(_given(kind, helm)), *partner, kind)]

    def _on_request(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        kind, exact = message.mission_type, isinstance(message, _REQUEST_INT)
        if self.taking and exact and kind == self.kind:
            return [_ACK(*partner, common.MAV_MISSION_DENIED, kind)]
        given = _given(kind, helm)
        if not 0 <= message.seq < len(given):
            return [_ACK(*partner, _ERROR, kind)]
        current = helm.run.seq if kind == PlanKind.MISSION else -1
        return [message_of(given[message.seq], message.seq, kind, partner, current, exact=exact)]

    def _on_ack(self, _message: Message, _partner: tuple[int, int], _helm: Helm) -> list[Message]:
        return []

    def _on_set_current(self, message: Message, partner: tuple[int, int], helm: Helm) -> list[Message]:
        if helm.obey(GoToItem(message.seq)) is not Verdict.ACCEPTED:
            return [_ACK(*partner, _ERROR, 0)]
        return [_mission_current(helm.report())]


def _given(kind: int, helm: Helm) -> tuple[PlanItem, ...]:
    if kind not in CAPACITY:
        return ()
    items = helm.plans.of(PlanKind(kind))
    return with_home(items, helm.report().flight.home) if kind == PlanKind.MISSION else items


def _warning(text: str) -> Message:
    return _STATUSTEXT(common.MAV_SEVERITY_WARNING, text.encode("ascii"), 0, 0)


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
    _PARTIAL: CopterPlanService._on_partial,
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
