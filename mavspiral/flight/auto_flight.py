"""One flight by the autopilot itself: upload the mission, read it back, arm, start, watch it until it has landed.

A state machine as `session` is, and driven alike: `step(now_us, received) -> Step(send, next_due_us, events)`.
It sends nothing that steers. What was flown is written down row by row, for whoever measures it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

from mavspiral.errors import LimitError, LinkError, MavspiralError
from mavspiral.flight.ardupilot import ARDUPILOT
from mavspiral.flight.flight_log import NO_LEG, Event, FlightLog, Recorder
from mavspiral.flight.link import Link
from mavspiral.flight.messages import (
    Command,
    Heartbeat,
    ImageCaptured,
    Message,
    MessageId,
    StatusText,
)
from mavspiral.flight.outcome import Outcome, State, Step
from mavspiral.flight.plan_upload import MissionLists, PlanUpload
from mavspiral.flight.profile import Profile
from mavspiral.flight.px4 import PX4
from mavspiral.flight.schedule import Schedule
from mavspiral.flight.telemetry import TelemetryRequest
from mavspiral.flight.vehicle import Vehicle
from mavspiral.flight.vehicle_clock import VehicleClock
from mavspiral.frames import GeoPoint, LocalFrame

__all__ = ["AutoFlight"]

_ROW_US = 20_000
_HEARTBEAT_US = 1_000_000
_ASK_US = 500_000
_LOST_US = 5_000_000
_WARNING = 4  # MAV_SEVERITY
_NO_PACE = (math.nan, math.nan)


class _Phase(Enum):
    CONNECT = "connect"
    TELEMETRY = "telemetry"
    ORIGIN = "origin"
    UPLOAD = "upload"
    ARM = "arm"
    START = "start"
    MISSION = "mission"


@dataclass(frozen=True, slots=True)
class _Row:
    """A phase of the flight: what is asked, when it is done, what follows, and how long it may take."""

    ask: Callable[[AutoFlight], bytes]
    done: Callable[[AutoFlight], bool]
    then: _Phase | None
    within_s: float
    state: State


class AutoFlight:
    """One flight of an uploaded mission, from connecting to the vehicle to its disarming.

    Args:
        lists: what to upload.
        profile: the autopilot's ways.
        tap: is handed every whole frame with its time, both directions.
    """

    def __init__(
        self,
        lists: MissionLists,
        profile: Profile = PX4,
        *,
        tap: Callable[[int, bytes], None] | None = None,
    ) -> None:
        self.outcome: Outcome | None = None
        self.events: list[Event] = []
        self.captured: list[ImageCaptured] = []
        self.origin: GeoPoint | None = None
        self._link = Link(tap)
        self._vehicle, self._clock, self._recorder = Vehicle(), VehicleClock(), Recorder()
        self._profile = profile
        self._telemetry = TelemetryRequest(profile)
        self._lists = lists
        self._upload: PlanUpload | None = None
        self._phase = _Phase.CONNECT
        self._entered_us = self._asked_us = self._heard_us = 0
        self._heartbeats, self._rows = Schedule(_HEARTBEAT_US), Schedule(_ROW_US)
        self._begun = False
        self._told_n = 0

    @property
    def state(self) -> State:
        """Where in the flight we are."""
        return _TABLE[self._phase].state

    def step(self, now_us: int, received: bytes) -> Step:
        """Take in `received` at `now_us`; what to send now, and by when to call again at the latest."""
        self._link.now_us = now_us
        if not self._begun:
            self._begun = True
            self._entered_us = self._heard_us = now_us
            self._heartbeats.start(now_us)
            self._rows.start(now_us)
            self._tell("info", self._phase.value)
        out = self._turn(self._take_in(self._link.receive(received))) if self.outcome is None else b""
        if self._rows.take(now_us) and self._phase is _Phase.MISSION:
            self._recorder.row(now_us, self._clock.at(now_us), NO_LEG, _NO_PACE, None, self._vehicle)
        if self._heartbeats.take(now_us):
            out += self._link.heartbeat()
        events = tuple(self.events[self._told_n :])
        self._told_n += len(events)
        return Step(out, min(self._rows.due_us, self._heartbeats.due_us), events)

    def log(self, frame: LocalFrame, legs: tuple[str, ...]) -> FlightLog:
        """The flight from its start on, in the plan's `frame`; nobody has said yet where on its legs it was.

        Raises:
            LimitError: it ended before the vehicle's place was known.
        """
        if self.origin is None:
            raise LimitError(f"no flight to log: it ended in phase {self._phase.value!r}")
        return self._recorder.log(frame.to_vehicle(self.origin), legs, tuple(self.events))

    def _tell(self, severity: str, text: str) -> None:
        self.events.append(Event(self._link.now_us, severity, text))

    def _take_in(self, messages: list[Message]) -> list[Message]:
        for message in messages:
            if self._link.vehicle is None:
                if not isinstance(message, Heartbeat) or message.autopilot != self._profile.autopilot:
                    continue
                self._link.vehicle = message.system_id, message.component_id
            self._heard_us = self._link.now_us
            self._vehicle.note(message)
            if isinstance(message, ImageCaptured):
                self.captured.append(message)
            elif isinstance(message, StatusText):
                severity = "warning" if message.severity <= _WARNING else "info"
                self._tell(severity, f"vehicle: {message.text}")
        if self._vehicle.local is not None:
            self._clock.observe(self._link.now_us, self._vehicle.local.time_boot_ms)
        return messages

    def _turn(self, messages: list[Message]) -> bytes:
        """Go as far along the table as it lets us, then ask for what the present phase needs."""
        out = b""
        try:
            if self._upload is not None and not self._upload.done:
                out += self._upload.step(self._link.now_us, messages)
            while self.outcome is None and _TABLE[self._phase].done(self):
                self._enter(_TABLE[self._phase].then)
        except MavspiralError as refusal:
            self._conclude(str(refusal), refusal.exit_code)
        if self.outcome is not None:
            return out
        row = _TABLE[self._phase]
        if self._link.vehicle is not None and self._link.now_us - self._heard_us > _LOST_US:
            self._conclude("link lost: nothing comes any more", LinkError.exit_code)
        elif (self._link.now_us - self._entered_us) / 1e6 > row.within_s:
            code = LinkError.exit_code if self._phase is _Phase.CONNECT else LimitError.exit_code
            self._conclude(f"{self._phase.value}: not done after {row.within_s:.0f} s", code)
        elif self._link.now_us >= self._asked_us:
            self._asked_us = self._link.now_us + _ASK_US
            out += row.ask(self)
        return out

    def _enter(self, phase: _Phase | None) -> None:
        if phase is None:
            self._conclude("flown, landed, disarmed", 0)
            return
        self._phase = phase
        self._entered_us = self._asked_us = self._link.now_us
        self._tell("info", phase.value)

    def _conclude(self, reason: str, exit_code: int) -> None:
        self._tell("error" if exit_code else "info", reason)
        self.outcome = Outcome(exit_code == 0, self.state, reason, exit_code)

    def _nothing(self) -> bytes:
        return b""

    def _connected(self) -> bool:
        return self._link.vehicle is not None

    def _ask_telemetry(self) -> bytes:
        return b"".join(self._telemetry.ask(self._link.now_us, self._link.arrivals, self._link.command))

    def _telemetry_flows(self) -> bool:
        return self._telemetry.settled and self._vehicle.local is not None

    def _ask_origin(self) -> bytes:
        return self._link.command(Command.REQUEST_MESSAGE, MessageId.GPS_GLOBAL_ORIGIN)

    def _origin_known(self) -> bool:
        if self._vehicle.origin is None:
            return False
        self.origin = GeoPoint(*self._vehicle.origin)
        return True

    def _uploaded(self) -> bool:
        """Whether all lists are up and came back equal."""
        if self._upload is None:
            self._upload = PlanUpload(
                self._link, self._lists, ardupilot=self._profile.autopilot == ARDUPILOT.autopilot
            )
        if not self._upload.done:
            return False
        for kind, wrong in self._upload.differences.items():
            if wrong:
                raise LimitError(f"the {kind.name.lower()} did not come back as it was sent: {wrong[0]}")
            count = len(self._lists.get(kind, ()))
            self._tell("info", f"{kind.name.lower()}: {count} items uploaded, read back and compared")
        return True

    def _ask_arm(self) -> bytes:
        """Where arming wants a mode of its own, that first: it waits there until the vehicle knows its place."""
        mode = self._profile.arm_in
        if mode is not None and self._vehicle.mode != mode.custom_mode:
            return self._link.command(Command.DO_SET_MODE, *mode.command)
        return self._link.command(Command.COMPONENT_ARM_DISARM, 1.0)

    def _armed(self) -> bool:
        return self._vehicle.armed

    def _ask_start(self) -> bytes:
        return self._link.command(Command.MISSION_START)

    def _started(self) -> bool:
        return self._profile.mode_name(self._vehicle.mode or 0) in _MISSION_MODES

    def _landed(self) -> bool:
        return not self._vehicle.armed


_MISSION_MODES = ("AUTO.MISSION", "AUTO")
_TABLE: Mapping[_Phase, _Row] = {
    _Phase.CONNECT: _Row(AutoFlight._nothing, AutoFlight._connected, _Phase.TELEMETRY, 10.0, State.CONNECT),
    _Phase.TELEMETRY: _Row(
        AutoFlight._ask_telemetry, AutoFlight._telemetry_flows, _Phase.ORIGIN, 60.0, State.TELEMETRY
    ),
    _Phase.ORIGIN: _Row(AutoFlight._ask_origin, AutoFlight._origin_known, _Phase.UPLOAD, 60.0, State.ORIGIN),
    _Phase.UPLOAD: _Row(AutoFlight._nothing, AutoFlight._uploaded, _Phase.ARM, 600.0, State.ROUTE),
    _Phase.ARM: _Row(AutoFlight._ask_arm, AutoFlight._armed, _Phase.START, 60.0, State.ARM),
    _Phase.START: _Row(AutoFlight._ask_start, AutoFlight._started, _Phase.MISSION, 20.0, State.TAKEOFF),
    _Phase.MISSION: _Row(AutoFlight._nothing, AutoFlight._landed, None, math.inf, State.STREAM),
}
