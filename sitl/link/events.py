"""PX4's events interface, as far as a vehicle without events speaks it.

An EVENT names its text by a hash that ground stations look up in the metadata of PX4's own build; what happens here is
told by STATUSTEXT. So the sequence stands where PX4 begins it, flagged as begun anew, and whoever asks for an
event is told that there is none.
"""

from __future__ import annotations

from collections.abc import Mapping

from sitl.link.codec import Received
from sitl.link.messages import Message, MessageType, message_type
from sitl.link.report import Report
from sitl.link.telemetry import Builder

__all__ = ["EVENTS", "REQUEST_EVENT", "no_event"]

REQUEST_EVENT = message_type("REQUEST_EVENT")
_CURRENT_EVENT_SEQUENCE = message_type("CURRENT_EVENT_SEQUENCE")
_RESPONSE_EVENT_ERROR = message_type("RESPONSE_EVENT_ERROR")

_SEQUENCE = 65535 - 10
"""PX4's `initial_event_sequence`."""
_RESET = 1
"""MAV_EVENT_CURRENT_SEQUENCE_FLAGS_RESET."""
_UNAVAILABLE = 0
"""MAV_EVENT_ERROR_REASON_UNAVAILABLE."""


def _current_sequence(_: Report) -> Message:
    return _CURRENT_EVENT_SEQUENCE(sequence=_SEQUENCE, flags=_RESET)


def no_event(received: Received) -> list[Message]:
    """The answer to REQUEST_EVENT, one for the whole range: it is not to be had."""
    return [
        _RESPONSE_EVENT_ERROR(
            sequence=received.message.first_sequence,
            sequence_oldest_available=_SEQUENCE,
            target_system=received.system,
            target_component=received.component,
            reason=_UNAVAILABLE,
        )
    ]


EVENTS: Mapping[MessageType, Builder] = {_CURRENT_EVENT_SEQUENCE: _current_sequence}
