"""What the commanders of both dialects show of themselves and hand out alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Generic, TypeVar

from sitl.autopilot.memory import PilotState
from sitl.plans import MissionRun, Plans
from sitl.signals import Demand
from sitl.status import Notice, Shot

__all__ = ["Pilot"]

StateT = TypeVar("StateT", bound=PilotState)


class Pilot(Generic[StateT]):
    """A commander by its state, which is all that it remembers."""

    def __init__(self, state: StateT) -> None:
        self._state = state
        self.holds_until_us = 0
        """Until when its last word holds, or the latest setpoint instead: while ground and position are neither lost nor found."""
        self.onward: Callable[[int], Demand] | None = None
        """What it asks from that time on while its last word holds, where that moves from frame to frame."""

    @property
    def armed(self) -> bool:
        """Whether the motors may turn."""
        return self._state.armed

    @property
    def plans(self) -> Plans:
        """What has been uploaded."""
        return self._state.plans

    @property
    def run(self) -> MissionRun:
        """How far the mission has come."""
        return self._state.run

    @property
    def has_news(self) -> bool:
        """Whether there is something to tell or to show."""
        return bool(self._state.notices or self._state.shots)

    def take_shots(self) -> tuple[Shot, ...]:
        """The pictures since the last call."""
        shots, self._state.shots = self._state.shots, ()
        return shots

    def take_notices(self) -> tuple[Notice, ...]:
        """What there is to tell since the last call."""
        notices, self._state.notices = self._state.notices, ()
        return notices

    def snapshot(self) -> StateT:
        """All that the commander remembers."""
        return replace(self._state)

    def restore(self, state: StateT) -> None:
        """Go on from a snapshot."""
        self._state = replace(state)
        self.holds_until_us = 0
