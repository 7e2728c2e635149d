"""What comes from the vehicle: whom we listen to, what is remembered of it, and who else wants to know."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mavspiral.flight.messages import Heartbeat, Message, StatusText
from mavspiral.flight.profile import Profile
from mavspiral.flight.situation import Situation
from mavspiral.flight.telemetry import TelemetryRequest

__all__ = ["Listener"]

_WARNING = 4  # MAV_SEVERITY
_AGAIN_US = 30_000_000
"""A text that comes again sooner, as why it does not arm, is no news."""


class Listener:
    """Takes in bytes, and notes in the situation what they say.

    Args:
        situation: of the session.
        profiles: the ways of the autopilots that it may be; the first heartbeat of one of them is the vehicle's.
        told: who is told of messages of one kind.
    """

    def __init__(
        self, situation: Situation, profiles: Sequence[Profile], told: Mapping[type, Callable[[Any], None]]
    ) -> None:
        self._s = situation
        self._profiles = {profile.autopilot: profile for profile in profiles}
        self._told: dict[type, Callable[[Any], None]] = {StatusText: self._hear_text, **told}
        self._refused = self._lacks_key = False
        self._said: dict[str, int] = {}  # when each text last came

    def take_in(self, received: bytes) -> None:
        """Take in what came now."""
        s = self._s
        link, vehicle, told = s.link, s.vehicle, self._told
        before, parameters_n = vehicle.local, len(vehicle.parameters)
        messages = link.receive(received)
        if link.refused_n and not self._refused:
            self._refused = True
            s.tell("warning", "refused: a frame that was not signed with our key, or had come before")
        if link.lacks_key and not self._lacks_key:
            self._lacks_key = True
            s.tell(
                "warning",
                "the vehicle signs what it says and may obey nobody who does not: --signing, with its key",
            )
        for message in messages:
            if link.vehicle is None and not self._is_the_vehicle(message):
                continue
            vehicle.note(message)
            if (listener := told.get(message.__class__)) is not None:
                listener(message)
        if messages and link.vehicle is not None:
            s.heard_us = s.now_us
        if len(vehicle.parameters) > parameters_n:
            s.parameter_us = s.now_us
        local = vehicle.local
        if local is None or local is before:
            return
        s.local_us = s.now_us
        s.clock.observe(s.now_us, local[0])
        if s.follower is not None:
            s.follower.heard(local[0] * 1000.0, local[1:4])

    def _is_the_vehicle(self, message: Message) -> bool:
        """Whether that is the first word of a vehicle that may be flown; from now on it is the one that is."""
        s = self._s
        if not isinstance(message, Heartbeat):
            return False
        if s.config.system_id not in (None, message.system_id):
            if message.is_vehicle:
                s.other_systems.add(message.system_id)
            return False
        if not message.is_copter and message.autopilot in self._profiles:
            s.no_copters.add(message.vehicle_type)
            return False
        if message.autopilot not in self._profiles:
            s.overheard.add(message.autopilot)
            return False
        s.link.vehicle = message.system_id, message.component_id
        s.profile = self._profiles[message.autopilot]
        s.telemetry = TelemetryRequest(s.profile)
        return True

    def _hear_text(self, said: StatusText) -> None:
        again_us = self._said.get(said.text, -_AGAIN_US) + _AGAIN_US
        self._said[said.text] = self._s.now_us
        if self._s.now_us >= again_us:
            self._s.tell("warning" if said.severity <= _WARNING else "info", f"vehicle: {said.text}")
