"""The log protocol, as far as a vehicle that keeps no logs on board speaks it."""

from __future__ import annotations

from sitl.link.messages import Message, message_type

__all__ = ["LOG_REQUEST", "no_logs"]

LOG_REQUEST = message_type("LOG_REQUEST_LIST")
_LOG_ENTRY = message_type("LOG_ENTRY")


def no_logs() -> list[Message]:
    """The answer to LOG_REQUEST_LIST: none."""
    return [_LOG_ENTRY(time_utc=0, size=0, id=0, num_logs=0, last_log_num=0)]
