"""What is watched at every step of a flight, beside its course: `Watch.finds` gives the first thing that changes it.

In this order: silence (the link is lost), a clock that begins anew, a mode that we did not ask for (hands off), a local origin that moves, a position
that is not to be trusted, a height that is not held, a vehicle that does not follow, an empty battery (fly home). Each is
looked at only when what it looks at may have changed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from mavspiral.errors import LinkError
from mavspiral.flight.anchor import Anchor
from mavspiral.flight.checks import loss_words
from mavspiral.flight.course import Row
from mavspiral.flight.doubts import Doubts
from mavspiral.flight.energy import Battery
from mavspiral.flight.follower import Follower
from mavspiral.flight.messages import Command, Heartbeat, MessageId, Origin, SystemStatus
from mavspiral.flight.outcome import State
from mavspiral.flight.schedule import Schedule
from mavspiral.flight.sinking import SAG_M, Sinking
from mavspiral.flight.situation import Situation
from mavspiral.frames import GeoPoint, LocalFrame

__all__ = ["Finding", "Watch", "link_lost"]

_ORIGIN_AGAIN_US = 5_000_000
_ORIGIN_STEP_M = 0.05
"""A move that is worth a word: the last digit that is sent is a centimetre, and some vehicles' flickers."""

_BATTERY_AGAIN_US = 1_000_000
_RECKONS_S = 5.0
"""So long an estimate is worth something without fixes: PX4's EKF2_NOAID_TOUT."""

_ON_THE_WAY = frozenset({State.ALIGN, State.STREAM, State.HOLD, State.BRAKE, State.RETURN})
_FLIES = _ON_THE_WAY - {State.ALIGN}
_CLIMBS = frozenset({State.TAKEOFF, State.PRESTREAM, State.OFFBOARD})
_GOES_HOME = frozenset({State.BRAKE, State.RETURN, State.LEAVE, State.HAND_OVER, State.LAND})
_INSPECTS = frozenset({State.STREAM, State.HOLD})


class Finding(NamedTuple):
    """Why the flight cannot go on as it does, and what it does instead: `then`, or it is over."""

    reason: str
    then: State | None = None
    exit_code: int = 1


def link_lost(s: Situation, row: Row, reason: str) -> Finding:
    """The link is gone for good; `reason`, and in the air what the vehicle does by itself."""
    words = reason if row.modes is None else f"{reason}; {loss_words(s.vehicle, s.profile)}"
    return Finding(words, exit_code=LinkError.exit_code)


def _rebooted(row: Row, why: str) -> Finding:
    if row.modes is None:
        return Finding(f"the vehicle has rebooted ({why}); begin again once it is ready")
    return Finding(f"the vehicle has rebooted in flight ({why}); nothing more is sent to it: take over")


class Watch:
    """Watches one flight.

    Args:
        situation: of the session.
        send: takes what the watching itself asks of the vehicle.
    """

    def __init__(self, situation: Situation, send: Callable[[bytes], None]) -> None:
        self.doubts = Doubts(situation.config.governor.reserve_m)
        self._s = situation
        self._send = send
        self._battery, self._battery_looks = Battery(), Schedule(_BATTERY_AGAIN_US)
        self._sinking = Sinking()
        self._anchor = Anchor(situation, send)
        self._origin_requests = Schedule(_ORIGIN_AGAIN_US)
        self._modes: frozenset[int] = frozenset()
        self._begun_at: Origin | None = None  # the origin that the flight began with
        self._moved_m = 0.0
        self._entry_mode: int | None = None
        self._mode_reached = False
        self._beat: Heartbeat | None = None
        self._following_us = self._stood_us = self._watched_us = 0

    def begin(self, now_us: int) -> None:
        """The session begins."""
        self._origin_requests.start(now_us)
        self._battery_looks.start(now_us)

    def entered(self, row: Row) -> None:
        """A state begins: the vehicle may stay in the mode that it is in, until it is in one of the state's own."""
        s = self._s
        self._entry_mode, self._mode_reached, self._beat = s.vehicle.mode, False, None
        if row.modes is not None:
            self._modes = frozenset(mode.custom_mode for mode in row.modes(s.profile))

    def finds(self, state: State, row: Row) -> Finding | None:
        """The first finding of those that are left, None when there is none; ask again after acting on it."""
        s = self._s
        now_us, vehicle, follower, doubts = s.now_us, s.vehicle, s.follower, self.doubts
        found: Finding | None
        if now_us > s.heard_us and (found := self._silence(row)):
            return found
        beat = vehicle.heartbeat
        if s.clock.jump_s and (found := self._jumped_clock(state, row)):
            return found
        if row.modes is None or beat is None:
            return None
        if beat is not self._beat and (found := self._hands(beat, row)):
            return found
        if not beat.armed:
            return None
        anchor = self._anchor
        if not (doubts.jump or vehicle.origin is not anchor.known) or anchor.settled(doubts):
            if (vehicle.origin is not anchor.known or now_us >= self._origin_requests.due_us) and (
                found := self._moved_origin(state)
            ):
                return found
            if (doubts.fault or doubts.jump) and (found := self._doubted_position(state)):
                return found
        if follower is None:
            self._following_us = self._watched_us = now_us
        else:
            if (follower.below_m > SAG_M or self._sinking.began) and (
                found := self._lost_height(state, follower)
            ):
                return found
            if not row.moves or follower.pace.rate > 0.0:
                self._following_us = self._watched_us = now_us
            elif found := self._left_behind(state, follower):
                return found
        return self._low_battery(state) if now_us >= self._battery_looks.due_us else None

    def _silence(self, row: Row) -> Finding | None:
        s = self._s
        silence_s = (s.now_us - s.heard_us) * 1e-6
        if silence_s > s.config.lost_after_s and s.link.vehicle is not None:
            return link_lost(s, row, f"link lost: nothing came for {silence_s:.0f} s")
        return None

    def _jumped_clock(self, state: State, row: Row) -> Finding | None:
        """Hands off one that has rebooted: it flies by nothing that it was told before."""
        clock = self._s.clock
        jump_s, clock.jump_s = clock.jump_s, 0.0
        if jump_s > 0.0:
            self._s.tell(
                "warning", f"the vehicle's clock jumped by {jump_s:.1f} s; the flight goes on as it was"
            )
            return None
        return None if state is State.RESTORE else _rebooted(row, f"its clock went back by {-jump_s:.0f} s")

    def _hands(self, beat: Heartbeat, row: Row) -> Finding | None:
        """Hands off as soon as somebody else flies it."""
        if beat.system_status in (SystemStatus.BOOT, SystemStatus.CALIBRATING):
            return _rebooted(row, "it says that it is starting up")
        if not beat.armed:
            return None if row.may_disarm else Finding("the vehicle disarmed by itself")
        self._beat = beat
        if beat.custom_mode in self._modes:
            self._mode_reached = True
        elif self._mode_reached or beat.custom_mode != self._entry_mode:
            mode = self._s.profile.mode_name(beat.custom_mode)
            if beat.system_status >= SystemStatus.CRITICAL:
                return Finding(f"the vehicle's own failsafe took over: {mode}")
            return Finding(f"pilot took over: {mode}; nothing more is sent to the vehicle")
        return None

    def _moved_origin(self, state: State) -> Finding | None:
        s = self._s
        if self._origin_requests.take(s.now_us):
            self._send(s.link.command(Command.REQUEST_MESSAGE, MessageId.GPS_GLOBAL_ORIGIN))
        told, then = s.vehicle.origin, s.origin
        if told is None or then is None:
            return None
        self._begun_at = self._begun_at or then
        now = s.origin = self._anchor.origin(told)
        if now == then:
            return None
        moved_m = math.hypot(*LocalFrame(GeoPoint(*self._begun_at)).point_enu_m(GeoPoint(*now)))
        words = f"the vehicle's local origin moved by {moved_m:.2f} m in flight"
        if moved_m > s.config.governor.reserve_m and state not in _GOES_HOME:
            if state in _CLIMBS:
                return Finding(f"{words}; landing", State.LAND)
            return Finding(f"{words}; flying home", State.BRAKE)
        if abs(moved_m - self._moved_m) >= _ORIGIN_STEP_M:
            self._moved_m = moved_m
            s.tell("warning", words)
        return None

    def _doubted_position(self, state: State) -> Finding | None:
        """Away from the wall and home as soon as the position is in doubt; on as it was, never after what jumped."""
        s, doubts = self._s, self.doubts
        jumped, fault = doubts.jumped(), doubts.fault
        if state not in _ON_THE_WAY:
            return None
        if doubts.misleads:
            return Finding(
                f"{fault}, which leads it astray; away from the wall and landing it there", State.LEAVE
            )
        if state is not State.RETURN:
            return Finding(f"{jumped or fault}: away from the wall and home", State.RETURN)
        if fault and s.elapsed_s > _RECKONS_S:
            words = f"{fault} still, and it no longer knows where it is; landing it there"
            return Finding(words, State.LAND)
        if jumped and not fault and s.follower is not None:
            s.tell("warning", f"{jumped}; going on home from there")
            north_m, east_m, down_m = doubts.shift_ned_m
            # It may climb after a height that jumped, never come down: there is the roof.
            up_m = 0.0 if math.hypot(north_m, east_m) > abs(down_m) else max(0.0, -down_m)
            s.follower.reference = s.follower.reference.shifted(north_m, east_m, -up_m)
        return None

    def _lost_height(self, state: State, follower: Follower) -> Finding | None:
        """Away from the wall and down, not home over the building, as soon as it cannot hold its height."""
        if state not in _FLIES:
            return None
        why = self._sinking.look(self._s.now_us, follower.below_m, follower.climb_mps)
        return (
            None if why is None else Finding(f"{why}; away from the wall and landing it there", State.LEAVE)
        )

    def _left_behind(self, state: State, follower: Follower) -> Finding | None:
        """Down where it is told no more where it is, or follows no more; home where it was waited for too long in all."""
        s = self._s
        before_us, self._watched_us = self._watched_us, s.now_us
        self._stood_us += s.now_us - max(before_us, self._following_us)
        stands_s, unheard_s = (s.now_us - self._following_us) * 1e-6, (s.now_us - s.local_us) * 1e-6
        if unheard_s > s.config.told_within_s:
            words = f"the vehicle does not tell where it is for {unheard_s:.0f} s; landing it there"
            return Finding(words, State.LAND)
        if stands_s > s.config.follow_within_s:
            why = f"the vehicle is {follower.error_m:.1f} m off its path for {stands_s:.0f} s"
            return Finding(f"{why}; landing it there", State.LAND)
        if state is State.STREAM and self._stood_us * 1e-6 > s.config.stand_at_most_s:
            waited_s = self._stood_us * 1e-6
            return Finding(f"it had to be waited for {waited_s:.0f} s in all; flying home", State.BRAKE)
        return None

    def _low_battery(self, state: State) -> Finding | None:
        """Once a second, and only as long as there is inspection left to give up; a hold lasts no longer either."""
        s = self._s
        if state not in _INSPECTS or s.trajectory is None or not self._battery_looks.take(s.now_us):
            return None
        if state is not State.HOLD and not s.path_t_s < s.inspection_ends_s:
            return None
        why = self._battery.time_to_return(s)
        return None if why is None else Finding(f"{why}; flying home", State.BRAKE)
