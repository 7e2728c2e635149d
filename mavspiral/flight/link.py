"""Our end of a MAVLink 2 conversation, without a socket: what the vehicle says, and the frames that we send.

We are system 245, component 191, a MAV_TYPE_ONBOARD_CONTROLLER without an autopilot.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.framing import Decoder
from mavspiral.flight.messages import Command, CommandAck, Heartbeat, ImageCaptured, Message, Setpoint
from mavspiral.flight.mission_messages import MissionItem
from mavspiral.flight.packing import Layout, frame_of, layout
from mavspiral.flight.signing import SIGNED, Signer, is_signed

__all__ = ["Link"]

LATE_N = 32  # a sequence number this far behind the newest was overtaken; further behind, many were lost

_SETPOINT = layout(mavlink.MAVLink_set_position_target_local_ned_message)


class Link:
    """Both ends of one conversation: `receive(bytes) -> messages`, and a method for each frame that we send.

    Until `vehicle` is set only heartbeats come through; from then on, only the vehicle's own messages, each
    once and none after a newer one.

    Args:
        tap: is handed every whole frame, in and out, as it passes, with `now_us`, which whoever steps us sets.
        signer: signs all that goes out; what it does not accept has not come in.
    """

    def __init__(self, tap: Callable[[int, bytes], None] | None = None, signer: Signer | None = None) -> None:
        self.now_us = 0
        self.vehicle: tuple[int, int] | None = None
        self.lacks_key = False  # the vehicle signs, and we do not
        self.others: dict[int, Heartbeat] = {}  # who else is there, by system, since the vehicle is known
        self.arrivals: Counter[int] = Counter()  # of the vehicle's messages, by MAVLink message id
        self._tap = tap
        self._signer = signer
        self._newest_seq: int | None = None
        self._decoder = Decoder()
        self._seq = 0

    def receive(self, data: bytes) -> list[Message]:
        """The messages that `data` completes. Garbage is counted and skipped."""
        messages: list[Message] = []
        tap, signer, now_us, vehicle = self._tap, self._signer, self.now_us, self.vehicle
        for frame, kind, seq, system_id, component_id in self._decoder.frames(data):
            if tap is not None:
                tap(now_us, frame)
            if signer is not None and not signer.accepts(frame):
                continue
            if kind is None:
                continue
            message_id, _, value = kind
            its_own = (system_id, component_id) == vehicle
            if its_own:
                newest = self._newest_seq
                if newest is not None and (newest - seq) % 256 < LATE_N:
                    continue
                self._newest_seq = seq
                self.arrivals[message_id] += 1
                if signer is None and is_signed(frame):
                    self.lacks_key = True
            if value is not None:
                said = value(frame)
                if its_own or self._concerns_us(said, system_id):
                    messages.append(said)
                elif isinstance(said, Heartbeat) and vehicle is not None and system_id != vehicle[0]:
                    self.others[system_id] = said
        return messages

    def _concerns_us(self, said: Message, system_id: int) -> bool:
        """Of what others say: who may be the vehicle, and once that is known what its camera answers."""
        if self.vehicle is None:
            return isinstance(said, Heartbeat)
        return system_id == self.vehicle[0] and isinstance(said, (CommandAck, ImageCaptured))

    def heartbeat(self) -> bytes:
        """Our HEARTBEAT."""
        return self._pack(
            mavlink.MAVLink_heartbeat_message,
            mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
            mavlink.MAV_AUTOPILOT_INVALID,
            0,
            0,
            mavlink.MAV_STATE_ACTIVE,
            3,
        )

    def command(self, command: Command, *params: float, component: int | None = None) -> bytes:
        """A COMMAND_LONG to the vehicle or another `component` of it; parameters that are not given are zero."""
        filled = (*params, *(0.0,) * (7 - len(params)))
        system_id, autopilot_id = self._addressee
        to = system_id, autopilot_id if component is None else component
        return self._pack(mavlink.MAVLink_command_long_message, *to, int(command), 0, *filled)

    def parameter_request(self, name: str) -> bytes:
        """A PARAM_REQUEST_READ by name."""
        return self._pack(
            mavlink.MAVLink_param_request_read_message, *self._addressee, name.encode("ascii"), -1
        )

    def parameter_set(self, name: str, raw: float, param_type: int) -> bytes:
        """A PARAM_SET."""
        return self._pack(
            mavlink.MAVLink_param_set_message, *self._addressee, name.encode("ascii"), raw, param_type
        )

    def mission_count(self, count: int, kind: int) -> bytes:
        """A MISSION_COUNT: the offer of an upload."""
        return self._pack(mavlink.MAVLink_mission_count_message, *self._addressee, count, kind)

    def mission_part(self, first: int, last: int, kind: int) -> bytes:
        """A MISSION_WRITE_PARTIAL_LIST: the offer of some items of a list."""
        return self._pack(
            mavlink.MAVLink_mission_write_partial_list_message, *self._addressee, first, last, kind
        )

    def mission_item(self, item: MissionItem) -> bytes:
        """A MISSION_ITEM_INT; the first one is the current one."""
        return self._pack(
            mavlink.MAVLink_mission_item_int_message,
            *self._addressee,
            item.seq,
            item.frame,
            item.command,
            int(item.seq == 0),
            int(item.autocontinue),
            *item.params,
            item.x,
            item.y,
            item.z,
            item.kind,
        )

    def mission_list_request(self, kind: int) -> bytes:
        """A MISSION_REQUEST_LIST: how many items are there?"""
        return self._pack(mavlink.MAVLink_mission_request_list_message, *self._addressee, kind)

    def mission_request(self, seq: int, kind: int) -> bytes:
        """A MISSION_REQUEST_INT for one item."""
        return self._pack(mavlink.MAVLink_mission_request_int_message, *self._addressee, seq, kind)

    def mission_ack(self, kind: int) -> bytes:
        """A MISSION_ACK: all items of a download have come."""
        return self._pack(mavlink.MAVLink_mission_ack_message, *self._addressee, 0, kind)

    def setpoint(
        self, time_boot_ms: int, setpoint: Setpoint, *, type_mask: int, coordinate_frame: int
    ) -> bytes:
        """A SET_POSITION_TARGET_LOCAL_NED."""
        fields = time_boot_ms & 0xFFFFFFFF, *setpoint, type_mask, *self._addressee, coordinate_frame
        return self._framed(_SETPOINT, fields)

    @property
    def garbage_n(self) -> int:
        """How many bytes began no frame."""
        return self._decoder.garbage_n

    @property
    def refused_n(self) -> int:
        """How many frames were not signed as they must be."""
        return 0 if self._signer is None else self._signer.refused_n

    @property
    def _addressee(self) -> tuple[int, int]:
        if self.vehicle is None:
            raise RuntimeError("no vehicle to address: set `vehicle` from its heartbeat first")
        return self.vehicle

    def _pack(self, described: Any, *fields: Any) -> bytes:
        """A frame of these fields, in the dialect's order."""
        kind = layout(described)
        return self._framed(kind, [fields[told] for told in kind.order])

    def _framed(self, kind: Layout, fields: Sequence[Any]) -> bytes:
        """A frame of these fields, in their order on the wire."""
        signer, seq = self._signer, self._seq
        self._seq = (seq + 1) % 256
        if signer is None:
            frame = frame_of(kind, fields, seq, 0)
        else:
            frame = signer.sign(frame_of(kind, fields, seq, SIGNED))
        if self._tap is not None:
            self._tap(self.now_us, frame)
        return frame
