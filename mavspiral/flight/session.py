"""One flight as a state machine: `step(now_us, received) -> Step(send, next_due_us, events)`.

No socket, no clock: whoever drives it brings both, so that the same bytes fly a simulated vehicle in lockstep
and a real one over a radio. The course of the flight is a table (`course`), and the `helm` turns it along that. Beside it,
it is watched at every step (`watch`), and the pilot may have wishes (`wishes`). ACKs are only reported; the HEARTBEAT decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from mavspiral.arrays import FloatArray
from mavspiral.errors import LimitError
from mavspiral.flight.alignment import Alignment
from mavspiral.flight.flight_log import Event, FlightLog
from mavspiral.flight.helm import Helm
from mavspiral.flight.link import Link
from mavspiral.flight.listening import Listener
from mavspiral.flight.messages import CommandAck, GpsFix, ImageCaptured, LocalPosition, Origin
from mavspiral.flight.outcome import Outcome, SessionConfig, State, Step
from mavspiral.flight.profile import Profile
from mavspiral.flight.px4 import PX4
from mavspiral.flight.schedule import Schedule, StreamFigures
from mavspiral.flight.shutter import Picture, ShotOrders, Shutter
from mavspiral.flight.signing import Signer
from mavspiral.flight.situation import Route, Situation, WayHome
from mavspiral.flight.streamer import Streamer
from mavspiral.flight.telemetry import TelemetryRequest
from mavspiral.flight.watch import Watch, link_lost
from mavspiral.flight.wishes import Wish
from mavspiral.frames import LocalFrame
from mavspiral.motion.trajectory import Trajectory

__all__ = ["Session"]

_HEARTBEAT_US = 1_000_000
_FAST = 1.5
"""A vehicle whose clock runs this much faster than ours is simulated."""


class Session:
    """One flight, from connecting to the vehicle to its disarming.

    Args:
        route: gives the trajectory for a home at `(3,)` in the plan's ENU, or refuses with a MavspiralError.
        frame: the plan's ENU.
        config: what may be told.
        way_home: gives the way back from anywhere on the flight; without it a flight that is given up lands there.
        profiles: the ways of the autopilots that it may be; the vehicle's first heartbeat tells which it is.
        shots: what camera and gimbal are told; without it nothing.
        align_at_enu_m: where in the plan the vehicle stands, `(3,)`: the plan is shifted by how far it is from there.
        tap: is handed every whole frame with its time, both directions (`TlogWriter.write`).
        signer: for a link whose both ends sign.
    """

    def __init__(
        self,
        route: Route,
        frame: LocalFrame,
        config: SessionConfig | None = None,
        *,
        way_home: WayHome | None = None,
        profiles: Sequence[Profile] = (PX4,),
        shots: ShotOrders | None = None,
        align_at_enu_m: FloatArray | None = None,
        tap: Callable[[int, bytes], None] | None = None,
        signer: Signer | None = None,
    ) -> None:
        config = config or SessionConfig()
        link = Link(tap, signer)
        first = profiles[0]
        s = self._s = Situation(
            route=route,
            way_home=way_home,
            frame=frame,
            config=config,
            profile=first,
            link=link,
            telemetry=TelemetryRequest(first),
        )
        s.alignment = None if align_at_enu_m is None else Alignment(align_at_enu_m)
        s.awaited = " or ".join(profile.name for profile in profiles)
        self._out: list[bytes] = []
        self._streamer = Streamer(s)
        self._shutter = None if shots is None else Shutter(s, shots)
        self._heartbeats = Schedule(_HEARTBEAT_US)
        self._watch = Watch(s, self._out.append)
        self._helm = Helm(s, self._watch, self._out.append)
        told: dict[type, Callable[[Any], None]] = {
            LocalPosition: self._watch.doubts.moved,
            GpsFix: self._watch.doubts.fixed,
        }
        if self._shutter is not None:
            told |= {ImageCaptured: self._shutter.heard, CommandAck: self._shutter.heard}
        self._listener = Listener(s, profiles, told)
        self._begun = False
        self._told_n = 0
        self._wish: Wish | None = None

    def step(self, now_us: int, received: bytes) -> Step:
        """Take in `received` at `now_us`; what to send now, and by when to call again at the latest."""
        s, out, helm = self._s, self._out, self._helm
        heartbeats, setpoints = self._heartbeats, self._streamer.schedule
        s.now_us = s.link.now_us = now_us
        if not self._begun:
            self._begin()
        if helm.ahead is not None:
            helm.settle()
        self._listener.take_in(received)
        if helm.outcome is None:
            if self._wish is not None:
                wish, self._wish = self._wish, None
                helm.obey(wish)
            helm.look_out()
            helm.turn()
        if setpoints.take(now_us):
            self._tick()
        if heartbeats.take(now_us):
            out.append(s.link.heartbeat())
            if s.clock.rate > _FAST:  # its failsafes count seconds of its own
                heartbeats.due_us = min(heartbeats.due_us, now_us + round(_HEARTBEAT_US / s.clock.rate))
        send = b"".join(out)
        out.clear()
        events: tuple[Event, ...] = ()
        if len(s.events) > self._told_n:
            events = tuple(s.events[self._told_n :])
            self._told_n += len(events)
        afterwards = None if helm.ahead is None else helm.settle
        return Step(send, min(setpoints.due_us, heartbeats.due_us), events, afterwards)

    def stop(self) -> None:
        """Ask for an end, from any thread or signal: hold in the air; asked again, fly home.

        On the ground it is over, in the climb it lands. The next step acts on it.
        """
        self._wish = Wish.STOP

    def wish(self, wish: Wish) -> None:
        """Ask for something, from any thread or signal; the next step acts on it."""
        self._wish = wish

    @property
    def state(self) -> State:
        """Where on its course the flight is."""
        return self._helm.state

    @property
    def outcome(self) -> Outcome | None:
        """How it ended; None as long as it goes on."""
        return self._helm.outcome

    @property
    def question(self) -> str:
        """What must be approved before the flight goes on: how the plan is shifted, then the flight itself; else empty."""
        alignment = self._s.alignment
        if self.state is State.APPROVE and alignment is not None and not alignment.approved:
            return alignment.question
        return self._s.config.question if self.state is State.CONSENT and not self._s.consented else ""

    @property
    def alignment(self) -> Alignment | None:
        """What came of the alignment, if there was to be one; with a `question` that is not `approved` the flight waits."""
        return self._s.alignment

    def approve(self) -> None:
        """Agree to the question; `stop` says no."""
        if self.state is State.CONSENT:
            self._s.consented = True
        elif self._s.alignment is not None and self._s.alignment.question:
            self._s.alignment.approved = True

    def warn(self, words: str) -> None:
        """Have the next step tell a warning of whoever drives us."""
        self._s.tell("warning", words)

    def link_broke(self, reason: str) -> None:
        """The link is gone for good, says whoever drives us."""
        if self.outcome is None:
            self._helm.act_on(link_lost(self._s, self._helm.row, reason))

    @property
    def profile(self) -> Profile:
        """The vehicle's ways; before it is heard, those of the first autopilot that it may be."""
        return self._s.profile

    @property
    def trajectory(self) -> Trajectory | None:
        """What is flown, once home is known."""
        return self._s.trajectory

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """Those that camera or vehicle said were taken, in their order."""
        return self.pictures_since(0)

    @property
    def missed_shots(self) -> tuple[int, ...]:
        """The shots, from 0 on the flight's own, that were commanded and never taken."""
        return () if self._shutter is None else self._shutter.missed

    @property
    def borrowed(self) -> dict[str, tuple[float, float]]:
        """Of each parameter that this flight has yet to put back: the vehicle's own value, and the one that it was given."""
        return self._s.borrowed

    @property
    def origin(self) -> Origin | None:
        """Where the vehicle's local frame begins, once its place is known."""
        return self._s.origin

    def pictures_since(self, number: int) -> tuple[Picture, ...]:
        """The pictures from that one on, counted from 0."""
        return () if self._shutter is None else tuple(self._shutter.pictures[number:])

    def rows_since(self, row: int) -> bytes:
        """The log's rows from number `row` on, raw (`journal`)."""
        return self._streamer.recorder.since(row)

    @property
    def left_the_ground(self) -> bool:
        """Whether there is anything to log: it was armed, and asked to take off."""
        return self._s.trajectory is not None and bool(self.rows_since(0))

    @property
    def events(self) -> tuple[Event, ...]:
        """All that was told so far."""
        return tuple(self._s.events)

    @property
    def figures(self) -> StreamFigures:
        """How steadily the setpoints went out."""
        return self._streamer.schedule.figures

    @property
    def garbage_n(self) -> int:
        """How many bytes came that are not MAVLink."""
        return self._s.link.garbage_n

    @property
    def path_t_s(self) -> float:
        """Path time on the trajectory; NaN while not on it."""
        return self._s.path_t_s

    def log(self) -> FlightLog:
        """The flight so far, from arming on.

        Raises:
            LimitError: it ended before the vehicle's place was known.
        """
        s = self._s
        if s.to_vehicle is None or s.trajectory is None:
            raise LimitError(f"no flight to log: it ended in state {self.state.value!r}")
        legs = tuple(leg.name for leg in s.trajectory.legs)
        return self._streamer.recorder.log(s.to_vehicle, legs, self.events)

    def _begin(self) -> None:
        self._begun = True
        now_us = self._s.heard_us = self._s.now_us
        self._streamer.schedule.start(now_us)
        self._heartbeats.start(now_us)
        self._watch.begin(now_us)
        self._helm.begin()

    def _tick(self) -> None:
        """The setpoint that is due, and what camera and gimbal are told with it."""
        s, row, goes_on = self._s, self._helm.row, self._helm.outcome is None
        if s.to_vehicle is None or row.modes is None:
            return
        streams = goes_on and row.streams
        if row.may_disarm and s.vehicle.mode != s.profile.follow.custom_mode:
            streams = False  # on its way down the vehicle has left the mode that follows
        self._out.append(self._streamer.tick(streams=streams, moves=row.moves))
        if self._shutter is not None and goes_on:
            self._out.append(self._shutter.tick())
