"""The course of a flight as one table: `COURSE`, at the end.

A row says when a state is done and what comes then, what is asked of the vehicle meanwhile and how often, in
which modes the vehicle may be, and what follows if it takes too long.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from mavspiral.flight import actions, alignment, failsafes, guidance
from mavspiral.flight.messages import Command
from mavspiral.flight.outcome import State
from mavspiral.flight.profile import Mode, Profile
from mavspiral.flight.situation import Situation

__all__ = ["COURSE", "Late", "Row", "diverted"]


class Late(Enum):
    """What follows when a state takes too long."""

    NOBODY = auto()
    REFUSE = auto()
    GO_ON = auto()
    COME_DOWN = auto()
    GIVE_UP = auto()


@dataclass(frozen=True, slots=True)
class Row:
    """One state of the flight.

    Args:
        done: whether the next state's time has come; on the ground it may refuse with a MavspiralError.
        then: the next state.
        enter: prepares the state.
        ask: the commands to send on entering, and again every `ask_every_s`.
        within_s: how long it may take.
        late: what follows then.
        words: what is told then.
        modes: the modes in which the vehicle is ours; None on the ground, where any will do.
        streams: setpoints go out.
        moves: path time runs; else the setpoint stands still.
        may_disarm: the vehicle's disarming is expected.
        plans: to enter takes some milliseconds, so it waits until what is due has been sent.
    """

    done: Callable[[Situation], bool]
    then: State
    enter: Callable[[Situation], None] | None = None
    ask: Callable[[Situation], bytes] | None = None
    ask_every_s: float = 1.0
    within_s: float = math.inf
    late: Late = Late.REFUSE
    words: Callable[[Situation], str] = lambda _: "took too long"
    modes: Callable[[Profile], tuple[Mode, ...]] | None = None
    streams: bool = False
    moves: bool = False
    may_disarm: bool = False
    plans: bool = False


def _say(words: str) -> Callable[[Situation], str]:
    return lambda _: words


_AUTOPILOTS = {3: "an ArduPilot", 12: "a PX4"}  # MAV_AUTOPILOT


def _awaited(s: Situation) -> str:
    return s.awaited if s.config.system_id is None else f"system {s.config.system_id} as {s.awaited}"


def _instead(s: Situation) -> str:
    """Who was heard instead, and what to do."""
    if s.other_systems:
        systems = sorted(s.other_systems)
        return f"{'systems' if systems[1:] else 'system'} {' and '.join(map(str, systems))} is there: --system names another"
    heard = [name for number, name in _AUTOPILOTS.items() if number in s.overheard]
    if s.no_copters and not heard:
        kinds = " and ".join(f"MAV_TYPE {kind}" for kind in sorted(s.no_copters))
        return f"what is there is no multicopter ({kinds}): connect to one"
    return (
        f"{' and '.join(heard)} is there: leave out --autopilot, or name that one"
        if heard
        else "check the link and the port"
    )


def diverted(state: State, then: State, s: Situation) -> State:
    """What follows `state` for this flight, when the course says `then`: the plan may be aligned first, and a word awaited."""
    if then is State.ROUTE and state is State.ORIGIN and s.alignment is not None:
        return State.MEASURE
    if then is State.FAILSAFES and s.config.question and not (s.consented or s.config.dry_run):
        return State.CONSENT
    return then


COURSE: Mapping[State, Row] = {
    State.CONNECT: Row(
        actions.heard,
        State.IDENTIFY,
        within_s=10.0,
        late=Late.NOBODY,
        words=lambda s: f"nobody answers: no heartbeat of {_awaited(s)} in 10 s; {_instead(s)}",
    ),
    State.IDENTIFY: Row(
        actions.identified,
        State.TELEMETRY,
        ask=actions.ask_version,
        within_s=5.0,
        late=Late.GO_ON,
        words=_say("the autopilot does not tell its version"),
    ),
    State.TELEMETRY: Row(
        actions.telemetry_flows,
        State.ORIGIN,
        ask=actions.ask_telemetry,
        ask_every_s=0.1,
        within_s=10.0,
        late=Late.GO_ON,
        words=_say("the vehicle did not switch its telemetry as asked"),
    ),
    State.ORIGIN: Row(
        actions.origin_known,
        State.ROUTE,
        ask=actions.ask_origin,
        within_s=60.0,
        words=_say("the vehicle knows no position: no local origin in 60 s; wait for its GPS"),
    ),
    State.MEASURE: Row(
        alignment.measured,
        State.APPROVE,
        enter=alignment.prepare,
        within_s=60.0,
        words=_say("the vehicle does not tell its position often enough to be aligned"),
    ),
    State.APPROVE: Row(alignment.approved, State.ROUTE),
    State.ROUTE: Row(actions.routed, State.CHECK),
    State.CHECK: Row(actions.checked, State.FAILSAFES, ask=actions.ask_parameters),
    # A word may be long in coming: where it stands, and the checks, are looked at anew.
    State.CONSENT: Row(actions.consented, State.ROUTE),
    State.FAILSAFES: Row(
        failsafes.are_set,
        State.ARM,
        enter=failsafes.prepare,
        ask=failsafes.ask_set,
        within_s=10.0,
        words=_say("the vehicle does not take the parameters that make a lost link safe"),
    ),
    State.ARM: Row(
        actions.armed,
        State.TAKEOFF,
        ask=actions.ask_arm,
        within_s=60.0,
        words=lambda s: f"it did not arm in 60 s; {s.answer(Command.COMPONENT_ARM_DISARM)}",
    ),
    State.TAKEOFF: Row(
        actions.at_height,
        State.PRESTREAM,
        ask=actions.ask_takeoff,
        within_s=180.0,
        late=Late.COME_DOWN,
        words=lambda s: f"it did not reach its height in 180 s; {s.answer(Command.NAV_TAKEOFF)}",
        modes=lambda p: p.climb,
    ),
    State.PRESTREAM: Row(
        actions.prestreamed,
        State.OFFBOARD,
        enter=guidance.prepare_join,
        modes=lambda p: p.climb,
        streams=True,
    ),
    State.OFFBOARD: Row(
        actions.follows,
        State.ALIGN,
        ask=actions.ask_mode(lambda p: p.follow),
        within_s=8.0,
        late=Late.COME_DOWN,
        words=lambda s: (
            f"it did not change to {s.profile.follow.name} in 8 s; {s.answer(Command.DO_SET_MODE)}"
        ),
        modes=lambda p: (*p.climb, p.follow),
        streams=True,
    ),
    State.ALIGN: Row(actions.finished, State.STREAM, modes=lambda p: (p.follow,), streams=True, moves=True),
    State.STREAM: Row(
        actions.finished,
        State.LAND,
        enter=guidance.prepare_stream,
        modes=lambda p: (p.follow,),
        streams=True,
        moves=True,
    ),
    State.HOLD: Row(actions.never, State.BRAKE, modes=lambda p: (p.follow,), streams=True),
    State.BRAKE: Row(actions.stands, State.RETURN, modes=lambda p: (p.follow,), streams=True),
    State.RETURN: Row(
        actions.finished,
        State.LAND,
        enter=guidance.prepare_return,
        plans=True,
        within_s=900.0,
        late=Late.COME_DOWN,
        words=_say("it did not come home in 900 s; landing it where it is"),
        modes=lambda p: (p.follow,),
        streams=True,
        moves=True,
    ),
    State.HAND_OVER: Row(
        actions.handed_over,
        State.OVER,
        ask=actions.ask_mode(lambda p: p.hold),
        within_s=5.0,
        late=Late.GIVE_UP,
        words=lambda s: (
            f"it does not change to {s.profile.hold.name}: nothing more is sent, so its own failsafe takes over; "
            "change its mode now"
        ),
        modes=lambda p: (p.follow, p.hold),
        streams=True,
    ),
    State.LEAVE: Row(
        actions.finished,
        State.LAND,
        enter=guidance.prepare_leave,
        plans=True,
        within_s=15.0,
        late=Late.GO_ON,
        words=_say("it did not get away from the wall in 15 s; landing it where it is"),
        modes=lambda p: (p.follow,),
        streams=True,
        moves=True,
    ),
    State.LAND: Row(
        actions.disarmed,
        State.RESTORE,
        ask=actions.ask_mode(lambda p: p.land),
        within_s=600.0,
        late=Late.GIVE_UP,
        words=_say("it did not land and disarm in 600 s"),
        modes=lambda p: (p.land,),
        streams=True,
        may_disarm=True,
    ),
    State.RESTORE: Row(
        failsafes.are_restored,
        State.OVER,
        ask=failsafes.ask_restored,
        within_s=10.0,
        late=Late.GO_ON,
        words=_say("the vehicle does not take its parameters back"),
    ),
}
