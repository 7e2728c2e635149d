"""One flight as a state machine: `step(now_us, received) -> Step(send, next_due_us, events)`.

No socket, no clock: whoever drives it brings both, so that the same bytes fly a simulated vehicle in lockstep
and a real one over a radio. The course of the flight is a table (`course`); this is what turns it. Beside it,
it is watched at every step for a mode that we did not ask for (hands off), silence (the link is lost), a local origin
that moves, a position that is not to be trusted, an empty battery (fly home). ACKs are only reported; the HEARTBEAT decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from mavspiral.arrays import FloatArray
from mavspiral.errors import LimitError, LinkError, MavspiralError
from mavspiral.flight.alignment import Alignment
from mavspiral.flight.checks import loss_words
from mavspiral.flight.course import COURSE, Late, Row
from mavspiral.flight.doubts import Doubts
from mavspiral.flight.energy import Battery
from mavspiral.flight.failsafes import left_as_set
from mavspiral.flight.flight_log import Event, FlightLog
from mavspiral.flight.link import Link
from mavspiral.flight.messages import (
    Command,
    CommandAck,
    GpsFix,
    Heartbeat,
    ImageCaptured,
    LocalPosition,
    Message,
    MessageId,
    Origin,
    StatusText,
    SystemStatus,
)
from mavspiral.flight.outcome import Outcome, SessionConfig, State, Step
from mavspiral.flight.profile import Profile
from mavspiral.flight.px4 import PX4
from mavspiral.flight.schedule import Schedule, StreamFigures
from mavspiral.flight.shutter import Picture, ShotOrders, Shutter
from mavspiral.flight.signing import Signer
from mavspiral.flight.sinking import Sinking
from mavspiral.flight.situation import Route, Situation, WayHome
from mavspiral.flight.streamer import Streamer
from mavspiral.flight.telemetry import TelemetryRequest
from mavspiral.flight.wishes import ALREADY, REPLIES, Wish
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.motion.trajectory import Trajectory

__all__ = ["Session"]

_HEARTBEAT_US = 1_000_000
_FAST = 1.5
"""A vehicle whose clock runs this much faster than ours is simulated."""
_ORIGIN_AGAIN_US = 5_000_000
_WARNING = 4  # MAV_SEVERITY
_RECKONS_S = 5.0
"""So long an estimate is worth something without fixes: PX4's EKF2_NOAID_TOUT."""

_ON_THE_WAY = frozenset({State.ALIGN, State.STREAM, State.HOLD, State.BRAKE, State.RETURN})
_FLIES = _ON_THE_WAY - {State.ALIGN}


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
        self.state = State.CONNECT
        self.outcome: Outcome | None = None
        config = config or SessionConfig()
        link = Link(tap, signer)
        self._profiles = {profile.autopilot: profile for profile in profiles}
        first = profiles[0]
        self._s = Situation(route, way_home, frame, config, first, link, TelemetryRequest(first))
        self._s.alignment = None if align_at_enu_m is None else Alignment(align_at_enu_m)
        self._s.awaited = " or ".join(profile.name for profile in profiles)
        self._row = COURSE[State.CONNECT]
        self._streamer = Streamer(self._s)
        self._shutter = None if shots is None else Shutter(self._s, shots)
        self._heartbeats = Schedule(_HEARTBEAT_US)
        self._origin_requests = Schedule(_ORIGIN_AGAIN_US)
        self._battery_looks = Schedule(_HEARTBEAT_US)
        self._battery = Battery()
        self._doubts = Doubts(config.governor.reserve_m)
        self._sinking = Sinking()
        self._listeners: dict[type, Callable[[Any], None]] = {
            LocalPosition: self._doubts.heard,
            GpsFix: self._doubts.heard,
            StatusText: self._hear_text,
        }
        if self._shutter is not None:
            self._listeners |= {ImageCaptured: self._shutter.heard, CommandAck: self._shutter.heard}
        self._begun = False
        self._out: list[bytes] = []
        self._told_n = 0
        self._heard_us = 0
        self._wish: Wish | None = None
        self._held = State.STREAM
        self._ask_due_us = 0
        self._failure: str | None = None
        self._refused = False
        self._modes: frozenset[int] = frozenset()
        self._entry_mode: int | None = None
        self._mode_reached = False
        self._following_us = self._stood_us = self._watched_us = 0
        self._said: StatusText | None = None

    def step(self, now_us: int, received: bytes) -> Step:
        """Take in `received` at `now_us`; what to send now, and by when to call again at the latest."""
        s = self._s
        s.now_us = s.link.now_us = now_us
        if not self._begun:
            self._begin()
        self._take_in(s.link.receive(received))
        if self._wish is not None and self.outcome is None:
            wish, self._wish = self._wish, None
            self._obey(wish)
        if self.outcome is None:
            self._watch()
        if self.outcome is None:
            self._turn()
        if self._streamer.schedule.take(now_us) and s.to_vehicle is not None and self._row.modes is not None:
            self._out.append(self._streamer.tick(streams=self._streams, moves=self._row.moves))
            if self._shutter is not None and self.outcome is None:
                self._out.append(self._shutter.tick())
        if self._heartbeats.take(now_us):
            self._out.append(s.link.heartbeat())
            if s.clock.rate > _FAST:  # its failsafes count seconds of its own
                self._heartbeats.due_us = min(
                    self._heartbeats.due_us, now_us + round(_HEARTBEAT_US / s.clock.rate)
                )
        send = b"".join(self._out)
        self._out.clear()
        events: tuple[Event, ...] = ()
        if len(s.events) > self._told_n:
            events = tuple(s.events[self._told_n :])
            self._told_n += len(events)
        return Step(send, min(self._streamer.schedule.due_us, self._heartbeats.due_us), events)

    def stop(self) -> None:
        """Ask for an end, from any thread or signal: hold in the air; asked again, fly home.

        On the ground it is over, in the climb it lands. The next step acts on it.
        """
        self._wish = Wish.STOP

    def wish(self, wish: Wish) -> None:
        """Ask for something, from any thread or signal; the next step acts on it."""
        self._wish = wish

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

    def link_broke(self, reason: str) -> None:
        """The link is gone for good, says whoever drives us."""
        if self.outcome is None:
            if self._row.modes is not None:
                reason = f"{reason}; {loss_words(self._s.vehicle, self._s.profile)}"
            self._conclude(reason, LinkError.exit_code)

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
        return () if self._shutter is None else tuple(self._shutter.pictures)

    @property
    def missed_shots(self) -> tuple[int, ...]:
        """The shots, from 0 on the flight's own, that were commanded and never taken."""
        return () if self._shutter is None else self._shutter.missed

    @property
    def origin(self) -> Origin | None:
        """Where the vehicle's local frame begins, once its place is known."""
        return self._s.origin

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
        now_us = self._heard_us = self._s.now_us
        for schedule in (
            self._streamer.schedule,
            self._heartbeats,
            self._origin_requests,
            self._battery_looks,
        ):
            schedule.start(now_us)
        self._enter(State.CONNECT)

    def _take_in(self, messages: list[Message]) -> None:
        s = self._s
        local_before = s.vehicle.local
        if s.link.refused_n and not self._refused:
            self._refused = True
            s.tell("warning", "refused: a frame that was not signed with our key, or had come before")
        for message in messages:
            if s.link.vehicle is None:
                if not isinstance(message, Heartbeat):
                    continue
                if message.autopilot not in self._profiles:
                    s.overheard.add(message.autopilot)
                    continue
                s.link.vehicle = message.system_id, message.component_id
                s.profile = self._profiles[message.autopilot]
                s.telemetry = TelemetryRequest(s.profile)
            self._heard_us = s.now_us
            s.vehicle.note(message)
            if (listener := self._listeners.get(message.__class__)) is not None:
                listener(message)
        local = s.vehicle.local
        if local is None or local is local_before:
            return
        s.local_us = s.now_us
        s.clock.observe(s.now_us, local.time_boot_ms)
        if s.follower is not None:
            s.follower.heard(local.time_boot_ms * 1000.0, s.vehicle.position_ned_m)

    def _hear_text(self, said: StatusText) -> None:
        if said != self._said:
            self._said = said
            self._s.tell("warning" if said.severity <= _WARNING else "info", f"vehicle: {said.text}")

    def _watch(self) -> None:
        s = self._s
        silence_s = (s.now_us - self._heard_us) * 1e-6
        if silence_s > s.config.lost_after_s and s.link.vehicle is not None:
            self.link_broke(f"link lost: nothing came for {silence_s:.0f} s")
            return
        beat = s.vehicle.heartbeat
        if self._row.modes is None or beat is None:
            return
        if not beat.armed:
            if not self._row.may_disarm:
                self._conclude("the vehicle disarmed by itself")
            return
        if beat.custom_mode in self._modes:
            self._mode_reached = True
        elif self._mode_reached or beat.custom_mode != self._entry_mode:
            self._hands_off(beat)
            return
        if s.vehicle.origin != s.origin or s.now_us >= self._origin_requests.due_us:
            self._watch_origin()
        self._watch_position()
        self._watch_height()
        self._watch_following()
        if s.now_us >= self._battery_looks.due_us:
            self._watch_battery()

    def _watch_origin(self) -> None:
        s = self._s
        if self._origin_requests.take(s.now_us):
            self._out.append(s.link.command(Command.REQUEST_MESSAGE, MessageId.GPS_GLOBAL_ORIGIN))
        now, then = s.vehicle.origin, s.origin
        if now is None or then is None or now == then:
            return
        s.origin = now
        moved_m = math.hypot(*LocalFrame(GeoPoint(*then)).point_enu_m(GeoPoint(*now)))
        words = f"the vehicle's local origin moved by {moved_m:.2f} m in flight"
        if moved_m > s.config.governor.reserve_m and self.state not in (
            State.BRAKE,
            State.RETURN,
            State.LAND,
        ):
            self._give_up(f"{words}; flying home", State.BRAKE)
        else:
            s.tell("warning", words)

    def _watch_position(self) -> None:
        """Away from the wall and home as soon as the position is in doubt; on as it was, never after what jumped."""
        jumped, fault = self._doubts.jumped(), self._doubts.fault
        if self.state not in _ON_THE_WAY or not (jumped or fault):
            return
        if self._doubts.misleads:
            self._note_failure(f"{fault}, which leads it astray; away from the wall and landing it there")
            self._enter_or_land(State.LEAVE)
        elif self.state is not State.RETURN:
            self._note_failure(f"{jumped or fault}: away from the wall and home")
            self._enter_or_land(State.RETURN)
        elif fault and self._s.elapsed_s > _RECKONS_S:
            self._give_up(f"{fault} still, and it no longer knows where it is; landing it there", State.LAND)
        elif jumped and not fault and self._s.follower is not None:
            self._s.tell("warning", f"{jumped}; going on home from there")
            follower = self._s.follower
            follower.reference = follower.reference.shifted(*self._doubts.shift_ned_m)

    def _watch_height(self) -> None:
        """Away from the wall and down, not home over the building, as soon as it cannot hold its height."""
        s = self._s
        if self.state not in _FLIES or s.follower is None:
            return
        if (why := self._sinking.look(s.now_us, s.follower.below_m, s.follower.climb_mps)) is not None:
            self._note_failure(f"{why}; away from the wall and landing it there")
            self._enter_or_land(State.LEAVE)

    def _watch_following(self) -> None:
        s = self._s
        before_us, self._watched_us = self._watched_us, s.now_us
        if not self._row.moves or s.follower is None or s.follower.pace.rate > 0.0:
            self._following_us = s.now_us
            return
        self._stood_us += s.now_us - max(before_us, self._following_us)
        stands_s, unheard_s = (s.now_us - self._following_us) * 1e-6, (s.now_us - s.local_us) * 1e-6
        if unheard_s > s.config.told_within_s:
            self._give_up(
                f"the vehicle does not tell where it is for {unheard_s:.0f} s; landing it there", State.LAND
            )
        elif stands_s > s.config.follow_within_s:
            why = f"the vehicle is {s.follower.error_m:.1f} m off its path for {stands_s:.0f} s"
            self._give_up(f"{why}; landing it there", State.LAND)
        elif self.state is State.STREAM and self._stood_us * 1e-6 > s.config.stand_at_most_s:
            waited_s = self._stood_us * 1e-6
            self._give_up(f"it had to be waited for {waited_s:.0f} s in all; flying home", State.BRAKE)

    def _watch_battery(self) -> None:
        """Once a second, and only as long as there is inspection left to give up; a hold lasts no longer either."""
        s = self._s
        if (
            self.state not in (State.STREAM, State.HOLD)
            or s.trajectory is None
            or not self._battery_looks.take(s.now_us)
        ):
            return
        held = self.state is State.HOLD
        if (held or s.path_t_s < s.trajectory.span_s("inspection")[1]) and (
            why := self._battery.time_to_return(s)
        ):
            self._give_up(f"{why}; flying home", State.BRAKE)

    def _obey(self, wish: Wish) -> None:
        if self.state is State.RESTORE:
            self._enter(State.OVER)
        elif self._row.modes is None:
            self._conclude("stopped before take-off")
        elif self.state is State.HOLD and wish is Wish.GO_ON:
            self._go_on()
        elif (reply := REPLIES.get((self.state, wish))) is None:
            self._s.tell("warning", ALREADY.get(self.state, "nothing to be done about that now"))
        elif reply[1] is State.HOLD:
            self._held = self.state
            self._s.tell("warning", reply[0])
            self._enter(State.HOLD)
        else:
            self._give_up(*reply)

    def _go_on(self) -> None:
        """Where it was stopped: the follower has kept its place."""
        self.state, self._row = self._held, COURSE[self._held]
        self._s.entered_us = self._ask_due_us = self._s.now_us
        self._s.tell("info", f"going on: {self.state.value}")

    def _hands_off(self, beat: Heartbeat) -> None:
        mode = self._s.profile.mode_name(beat.custom_mode)
        if beat.system_status >= SystemStatus.CRITICAL:
            self._conclude(f"the vehicle's own failsafe took over: {mode}")
        else:
            self._conclude(f"pilot took over: {mode}; nothing more is sent to the vehicle")

    def _turn(self) -> None:
        """Go as far along the course as it lets us, then ask for what the present state needs."""
        s = self._s
        try:
            while self.outcome is None and self._row.done(s):
                self._enter(self._row.then)
        except MavspiralError as refusal:
            if self._row.modes is None:
                self._conclude(str(refusal), refusal.exit_code)
            else:
                self._give_up(f"{refusal}; landing", State.LAND)
        if self.outcome is None and (s.now_us - s.entered_us) * 1e-6 > self._row.within_s:
            self._too_late(self._row)
        ask = self._row.ask
        if self.outcome is None and ask is not None and s.now_us >= self._ask_due_us:
            self._ask_due_us = s.now_us + round(self._row.ask_every_s * 1e6)
            self._out.append(ask(s))

    @property
    def _streams(self) -> bool:
        """Whether setpoints go out; on the way down, until the vehicle has left the mode that follows."""
        s = self._s
        left = self._row.may_disarm and s.vehicle.mode != s.profile.follow.custom_mode
        return self.outcome is None and self._row.streams and not left

    def _too_late(self, row: Row) -> None:
        words = row.words(self._s)
        if row.late is Late.GO_ON:
            self._s.tell("warning", words)
            self._enter(row.then)
        elif row.late is Late.COME_DOWN:
            self._give_up(words, State.LAND)
        else:
            self._conclude(words, LinkError.exit_code if row.late is Late.NOBODY else LimitError.exit_code)

    def _enter(self, state: State) -> None:
        s = self._s
        if state is State.ARM and s.config.dry_run:
            self._conclude("dry run: all but arming went well", 0)
            return
        if state is State.ROUTE and self.state is State.ORIGIN and s.alignment is not None:
            state = State.MEASURE
        if state is State.FAILSAFES and s.config.question and not (s.consented or s.config.dry_run):
            state = State.CONSENT
        if state is State.OVER and self.state is State.HAND_OVER:
            self._conclude(f"handed over: it holds in {s.profile.hold.name}; change its mode to fly it")
            return
        if state is State.OVER:
            self.state = State.LAND  # where the flight ended
            self._conclude(
                f"landed, disarmed ({self._failure})" if self._failure else "flown, landed, disarmed",
                1 if self._failure else 0,
            )
            return
        self.state, self._row = state, COURSE[state]
        s.entered_us = self._ask_due_us = s.now_us
        self._entry_mode, self._mode_reached = s.vehicle.mode, False
        if self._row.modes is not None:
            self._modes = frozenset(mode.custom_mode for mode in self._row.modes(s.profile))
        if self._row.enter is not None:
            self._row.enter(s)
        s.tell("info", state.value)

    def _enter_or_land(self, state: State) -> None:
        try:
            self._enter(state)
        except MavspiralError as refusal:
            self._give_up(f"{refusal}; landing", State.LAND)

    def _give_up(self, reason: str, state: State) -> None:
        self._note_failure(reason)
        self._enter(state)

    def _note_failure(self, reason: str) -> None:
        self._s.tell("error", reason)
        self._failure = f"{self._failure}; {reason}" if self._failure else reason

    def _conclude(self, reason: str, exit_code: int = 1) -> None:
        self._s.tell("error" if exit_code else "info", reason)
        if (left := left_as_set(self._s)) is not None:
            self._s.tell("warning", left)
        if self.state is State.ARM and exit_code and self._s.link.vehicle is not None:
            self._out.append(self._s.link.command(Command.COMPONENT_ARM_DISARM, 0.0))  # it may yet obey
        self.outcome = Outcome(exit_code == 0, self.state, reason, exit_code)
