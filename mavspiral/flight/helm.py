"""Where a flight is on its course (`course`), and what turns it from there: its own progress, what is found, what the pilot wishes."""

from __future__ import annotations

from collections.abc import Callable

from mavspiral.errors import LimitError, LinkError, MavspiralError
from mavspiral.flight.course import COURSE, Late, Row, diverted
from mavspiral.flight.failsafes import left_as_set
from mavspiral.flight.messages import Command
from mavspiral.flight.outcome import Outcome, State
from mavspiral.flight.situation import Situation
from mavspiral.flight.watch import Finding, Watch
from mavspiral.flight.wishes import ALREADY, REPLIES, Wish

__all__ = ["Helm"]


class Helm:
    """Turns one flight along its course.

    Args:
        situation: of the session.
        watch: is told of every state that begins.
        send: takes what is asked of the vehicle.

    Attributes:
        state: where on the course it is, and `row` what the course says there.
        outcome: how it ended; None as long as it goes on.
        ahead: a state that is about to begin, which takes some milliseconds (`settle`); else None.
    """

    def __init__(self, situation: Situation, watch: Watch, send: Callable[[bytes], None]) -> None:
        self.state = State.CONNECT
        self.row = COURSE[State.CONNECT]
        self.outcome: Outcome | None = None
        self.ahead: State | None = None
        self._s = situation
        self._watch = watch
        self._send = send
        self._held = State.STREAM
        self._ask_due_us = 0
        self._failure: str | None = None

    def begin(self) -> None:
        """The session begins."""
        self._enter(State.CONNECT)

    def obey(self, wish: Wish) -> None:
        """What the pilot wishes is done, or answered."""
        if self.state is State.RESTORE:
            self._enter(State.OVER)
        elif self.row.modes is None:
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

    def settle(self) -> None:
        """Begin the state that is ahead; where that is refused, land."""
        state, self.ahead = self.ahead, None
        if state is not None and self.outcome is None:
            try:
                self._begin(state)
            except MavspiralError as refusal:
                self._give_up(f"{refusal}; landing", State.LAND)

    def look_out(self) -> None:
        """Act on all that is found now."""
        while self._goes_on and (finding := self._watch.finds(self.state, self.row)) is not None:
            self.act_on(finding)

    def act_on(self, finding: Finding) -> None:
        """Go on as it says, or not at all."""
        if finding.then is None:
            self._conclude(finding.reason, finding.exit_code)
        else:
            self._give_up(finding.reason, finding.then)

    def turn(self) -> None:
        """Go as far along the course as it lets us, then ask for what the present state needs."""
        s = self._s
        try:
            while self._goes_on and self.row.done(s):
                self._enter(self.row.then)
        except MavspiralError as refusal:
            if self.row.modes is None:
                self._conclude(str(refusal), refusal.exit_code)
            else:
                self._give_up(f"{refusal}; landing", State.LAND)
        if not self._goes_on:
            return
        if (s.now_us - s.entered_us) * 1e-6 > self.row.within_s:
            self._too_late(self.row)
        ask = self.row.ask
        if ask is not None and self._goes_on and s.now_us >= self._ask_due_us:
            self._ask_due_us = s.now_us + round(self.row.ask_every_s * 1e6)
            self._send(ask(s))

    @property
    def _goes_on(self) -> bool:
        """Whether neither an end has come nor a state is ahead."""
        return self.outcome is None and self.ahead is None

    def _enter(self, state: State) -> None:
        s = self._s
        state = diverted(self.state, state, s)
        if state is State.ARM and s.config.dry_run:
            self._conclude("dry run: all but arming went well", 0)
        elif state is State.OVER:
            self._end()
        elif COURSE[state].plans:
            self.ahead = state
        else:
            self._begin(state)

    def _begin(self, state: State) -> None:
        s = self._s
        self.state, self.row = state, COURSE[state]
        s.entered_us = self._ask_due_us = s.now_us
        self._watch.entered(self.row)
        if self.row.enter is not None:
            self.row.enter(s)
        s.tell("info", state.value)

    def _go_on(self) -> None:
        """Where it was stopped: the follower has kept its place."""
        self.state, self.row = self._held, COURSE[self._held]
        self._s.entered_us = self._ask_due_us = self._s.now_us
        self._s.tell("info", f"going on: {self.state.value}")

    def _too_late(self, row: Row) -> None:
        words = row.words(self._s)
        if row.late is Late.GO_ON:
            self._s.tell("warning", words)
            self._enter(row.then)
        elif row.late is Late.COME_DOWN:
            self._give_up(words, State.LAND)
        else:
            self._conclude(words, LinkError.exit_code if row.late is Late.NOBODY else LimitError.exit_code)

    def _give_up(self, reason: str, state: State) -> None:
        """Go on with `state` as best it can; where that is refused, land."""
        self._s.tell("error", reason)
        self._failure = f"{self._failure}; {reason}" if self._failure else reason
        try:
            self._enter(state)
        except MavspiralError as refusal:
            self._give_up(f"{refusal}; landing", State.LAND)

    def _end(self) -> None:
        """The course is at its end."""
        if self.state is State.HAND_OVER:
            self._conclude(f"handed over: it holds in {self._s.profile.hold.name}; change its mode to fly it")
            return
        self.state = State.LAND  # where the flight ended
        if self._failure is None:
            self._conclude("flown, landed, disarmed", 0)
        else:
            self._conclude(f"landed, disarmed ({self._failure})")

    def _conclude(self, reason: str, exit_code: int = 1) -> None:
        self._s.tell("error" if exit_code else "info", reason)
        if (left := left_as_set(self._s)) is not None:
            self._s.tell("warning", left)
        if self.state is State.ARM and exit_code and self._s.link.vehicle is not None:
            self._send(self._s.link.command(Command.COMPONENT_ARM_DISARM, 0.0))  # it may yet obey
        self.outcome = Outcome(exit_code == 0, self.state, reason, exit_code)
