"""An upload as a state machine, driven as a flight is: find the vehicle, hand the plan over, compare what comes back.

MAVSDK 4.1 uploads 500 items and reads them back in 10 s, but gives up when 30 % of the datagrams are lost each way
(measured: TIMEOUT after 20 s, and no second upload takes). So this is our own `mission_protocol`. How far it is, its steps'
events tell every 3 s.
"""

from __future__ import annotations

from collections.abc import Callable

from mavspiral.errors import LimitError, LinkError, MavspiralError
from mavspiral.flight.flight_log import Event
from mavspiral.flight.link import Link
from mavspiral.flight.messages import Heartbeat
from mavspiral.flight.outcome import Outcome, State, Step
from mavspiral.flight.plan_upload import MissionLists, PlanUpload
from mavspiral.flight.schedule import Schedule
from mavspiral.flight.signing import Signer

__all__ = ["AUTOPILOTS", "Upload"]

AUTOPILOTS = {12: "PX4", 3: "ArduPilot"}
"""MAV_AUTOPILOT of those that we know."""

_ARDUPILOT = 3
_HEARTBEAT_US = 1_000_000
_TICK_US = 20_000
_NOBODY_US = 10_000_000
_TELL_US = 3_000_000
"""What is done sooner needs no word on how far it is."""


class Upload:
    """Uploads `lists`, which were made for the autopilot `firmware` (None: for any).

    With a `signer` all that goes out is signed, and what it does not accept has not come in. `system_id` says whose it is; else
    it is the first vehicle's that is heard.
    """

    def __init__(
        self,
        lists: MissionLists,
        firmware: int | None,
        *,
        tap: Callable[[int, bytes], None] | None = None,
        signer: Signer | None = None,
        system_id: int | None = None,
    ) -> None:
        self.outcome: Outcome | None = None
        self.differences: tuple[str, ...] = ()
        self._lists, self._firmware, self._system_id = lists, firmware, system_id
        self._others: set[int] = set()
        self._link = Link(tap, signer)
        self._upload: PlanUpload | None = None
        self._heartbeats = Schedule(_HEARTBEAT_US)
        self._told = Schedule(_TELL_US)
        self._begun_us: int | None = None

    def step(self, now_us: int, received: bytes) -> Step:
        """Take in `received` at `now_us`; what to send now, and by when to call again at the latest."""
        self._link.now_us = now_us
        if self._begun_us is None:
            self._begun_us = now_us
            self._heartbeats.start(now_us)
            self._told.start(now_us + _TELL_US)
        out, messages = b"", self._link.receive(received)
        try:
            if self._upload is None:
                known = [beat for beat in messages if isinstance(beat, Heartbeat) and _is_known(beat)]
                meant = [beat for beat in known if self._system_id in (None, beat.system_id)]
                self._others |= {beat.system_id for beat in known if beat not in meant}
                if meant:
                    self._upload = self._met(meant[0])
                elif now_us - self._begun_us > _NOBODY_US:
                    raise self._nobody()
            elif self.outcome is None:
                out = self._upload.step(now_us, messages)
                if self._upload.done:
                    self._compare(self._upload)
        except MavspiralError as refusal:
            self._conclude(str(refusal), refusal.exit_code)
        if self._heartbeats.take(now_us):
            out += self._link.heartbeat()
        return Step(out, min(now_us + _TICK_US, self._heartbeats.due_us), self._progress(self._begun_us))

    def _progress(self, begun_us: int) -> tuple[Event, ...]:
        if self._upload is None or self.outcome is not None or not self._told.take(self._link.now_us):
            return ()
        return (Event(self._link.now_us - begun_us, "info", self._upload.progress),)

    def stop(self) -> None:
        """Ends it: what has not been sent stays unsent."""
        self._conclude("stopped; the vehicle may hold an unfinished plan", 1)

    def link_broke(self, reason: str) -> None:
        """The link is gone for good, says whoever drives us."""
        self._conclude(reason, LinkError.exit_code)

    def _nobody(self) -> LinkError:
        if self._link.refused_n:
            return LinkError(
                f"no vehicle within 10 s that signs with our key: {self._link.refused_n} frames refused. "
                "Fix: the vehicle's own key as --signing"
            )
        if self._others:
            there = ", ".join(map(str, sorted(self._others)))
            return LinkError(
                f"no system {self._system_id} within 10 s, but {there}. Fix: --system with one of them, or connect to the other"
            )
        return LinkError("no vehicle within 10 s. Fix: start it, or check the address")

    def _met(self, beat: Heartbeat) -> PlanUpload:
        if self._firmware is not None and beat.autopilot != self._firmware:
            made_for = AUTOPILOTS.get(self._firmware, f"autopilot {self._firmware}")
            raise LimitError(
                f"the plan was made for {made_for}, the vehicle is {AUTOPILOTS[beat.autopilot]}. "
                "Fix: [vehicle] autopilot, and plan it again"
            )
        self._link.vehicle = beat.system_id, beat.component_id
        return PlanUpload(self._link, self._lists, ardupilot=beat.autopilot == _ARDUPILOT)

    def _compare(self, upload: PlanUpload) -> None:
        self.differences = tuple(
            f"{kind.name.lower()}: {line}" for kind, lines in upload.differences.items() for line in lines
        )
        if self.differences:
            self._conclude("it did not come back as it was sent", LimitError.exit_code)
        else:
            self._conclude("uploaded, read back, equal", 0)

    def _conclude(self, reason: str, exit_code: int) -> None:
        if self.outcome is None:
            self.outcome = Outcome(exit_code == 0, State.CONNECT, reason, exit_code)


def _is_known(beat: Heartbeat) -> bool:
    return beat.is_vehicle and beat.autopilot in AUTOPILOTS
