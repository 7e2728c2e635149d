"""The course of a flight as one table: `COURSE`, at the end.

A row says when a state is done and what comes then, what is asked of the vehicle meanwhile and how often, in
which modes the vehicle may be, and what follows if it takes too long.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from mavspiral.errors import LimitError
from mavspiral.flight.checks import check_before_arming
from mavspiral.flight.follower import Follower
from mavspiral.flight.governor import Pace
from mavspiral.flight.messages import Command, MessageId, Target
from mavspiral.flight.origin import origin_from_pair
from mavspiral.flight.outcome import State
from mavspiral.flight.profile import Mode, Profile
from mavspiral.flight.reference import Reference
from mavspiral.flight.situation import Situation
from mavspiral.frames import GeoPoint

__all__ = ["COURSE", "Late", "Row"]

_PARAMETERS_S = 4.0  # an unknown name is met with silence
_PAIR_AFTER_S = 3.0
_JOIN_MPS = 1.0
_JOIN_RADPS = 0.5
_HOVER_MPS = 0.5


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


def _say(words: str) -> Callable[[Situation], str]:
    return lambda _: words


def _never(_: Situation) -> bool:
    return False


def _heard(s: Situation) -> bool:
    return s.link.vehicle is not None


def _identified(s: Situation) -> bool:
    if s.vehicle.version is None:
        return False
    s.tell("info", f"{s.profile.name} {s.vehicle.version.version}")
    return True


def _ask_version(s: Situation) -> bytes:
    return s.link.command(Command.REQUEST_MESSAGE, MessageId.AUTOPILOT_VERSION)


def _telemetry_flows(s: Situation) -> bool:
    return s.telemetry.settled and s.vehicle.local is not None


def _ask_telemetry(s: Situation) -> bytes:
    return b"".join(s.telemetry.ask(s.now_us, s.link.arrivals, s.link.command))


def _origin_known(s: Situation) -> bool:
    vehicle = s.vehicle
    if vehicle.local is None:
        return False
    if vehicle.origin is None and s.elapsed_s > _PAIR_AFTER_S and vehicle.place is not None:
        vehicle.origin = origin_from_pair(vehicle.place, vehicle.local)
    return vehicle.origin is not None


def _ask_origin(s: Situation) -> bytes:
    asked = s.link.command(Command.REQUEST_MESSAGE, MessageId.GPS_GLOBAL_ORIGIN)
    if s.elapsed_s > _PAIR_AFTER_S - 1:
        asked += s.link.command(Command.REQUEST_MESSAGE, MessageId.GLOBAL_POSITION_INT)
    return asked


def _routed(s: Situation) -> bool:
    assert s.vehicle.origin is not None
    s.origin = s.vehicle.origin
    s.to_vehicle = s.frame.to_vehicle(GeoPoint(*s.origin))
    home_enu_m = s.to_vehicle.position_enu_m(s.vehicle.position_ned_m)
    s.trajectory = s.route(home_enu_m)
    s.reference = Reference.of(s.trajectory, s.to_vehicle)
    east_m, north_m, up_m = home_enu_m
    where = f"home is {east_m:.1f} m east, {north_m:.1f} m north, {up_m:.1f} m up of the plan's origin"
    s.tell("info", f"{where}; the flight takes {s.trajectory.duration_s:.0f} s")
    return True


def _checked(s: Situation) -> bool:
    missing = [name for name in s.profile.parameters if name not in s.vehicle.parameters]
    if missing and s.elapsed_s < _PARAMETERS_S:
        return False
    assert s.reference is not None
    findings = check_before_arming(
        s.vehicle, s.profile, s.reference.extremes(), battery_min_pct=s.config.battery_min_pct
    )
    for severity, text in findings:
        if severity == "warning":
            s.tell(severity, text)
    errors = [text for severity, text in findings if severity == "error"]
    if errors:
        raise LimitError("; ".join(errors))
    return True


def _ask_parameters(s: Situation) -> bytes:
    missing = (name for name in s.profile.parameters if name not in s.vehicle.parameters)
    return b"".join(s.link.parameter_request(name) for name in missing)


def _armed(s: Situation) -> bool:
    return s.vehicle.armed


def _ask_arm(s: Situation) -> bytes:
    return s.link.command(Command.COMPONENT_ARM_DISARM, 1.0)


def _at_height(s: Situation) -> bool:
    assert s.reference is not None
    here, first = s.vehicle.position_ned_m, s.reference.at(0.0).position_ned_m
    if (
        math.hypot(*s.vehicle.velocity_ned_mps) > _HOVER_MPS
        or abs(here[2] - first[2]) > s.profile.takeoff_within_m
    ):
        return False
    if (off_m := math.dist(here, first)) > s.config.join_max_m:
        raise LimitError(f"it hovers {off_m:.1f} m from the first point, more than {s.config.join_max_m:g} m")
    return True


def _ask_takeoff(s: Situation) -> bytes:
    if s.vehicle.flying or s.vehicle.mode == s.profile.climb[0].custom_mode:
        return b""
    assert s.trajectory is not None and s.reference is not None
    first_enu_m = s.trajectory(0.0).position_enu_m
    alt_amsl_m = s.frame.geo_point(first_enu_m).alt_amsl_m
    climb_m = s.vehicle.position_ned_m[2] - s.reference.at(0.0).position_ned_m[2]
    return s.link.command(Command.NAV_TAKEOFF, *s.profile.takeoff_params(alt_amsl_m, climb_m))


def _prepare_join(s: Situation) -> None:
    """From where it hovers, as it looks, to the first point and its yaw."""
    assert s.reference is not None
    still = (0.0, 0.0, 0.0)
    first = s.reference.at(0.0)
    yaw = s.vehicle.yaw_ned_rad
    here = Target(s.vehicle.position_ned_m, still, still, first.yaw_ned_rad if math.isnan(yaw) else yaw, 0.0)
    join = Reference.move(here, first, speed_mps=_JOIN_MPS, yaw_rate_radps=_JOIN_RADPS)
    s.follower = Follower(join, s.config.governor, s.clock.at(s.now_us), pace=Pace(0.0, 0.0, 0.0))


def _prestreamed(s: Situation) -> bool:
    return s.elapsed_s >= s.profile.pre_stream_s


def _ask_mode(mode: Callable[[Profile], Mode]) -> Callable[[Situation], bytes]:
    def ask(s: Situation) -> bytes:
        wanted = mode(s.profile)
        if s.vehicle.mode == wanted.custom_mode:
            return b""
        return s.link.command(Command.DO_SET_MODE, *wanted.command)

    return ask


def _follows(s: Situation) -> bool:
    return s.vehicle.mode == s.profile.follow.custom_mode


def _prepare_stream(s: Situation) -> None:
    assert s.reference is not None
    lead_s = s.profile.lead_s
    s.follower = Follower(s.reference, s.config.governor, s.clock.at(s.now_us), lead_s=lead_s)


def _finished(s: Situation) -> bool:
    return s.follower is not None and s.follower.finished


def _disarmed(s: Situation) -> bool:
    return not s.vehicle.armed


COURSE: Mapping[State, Row] = {
    State.CONNECT: Row(
        _heard,
        State.IDENTIFY,
        within_s=10.0,
        late=Late.NOBODY,
        words=lambda s: (
            f"nobody answers: no heartbeat of {s.profile.name} in 10 s; check the link and the port"
        ),
    ),
    State.IDENTIFY: Row(
        _identified,
        State.TELEMETRY,
        ask=_ask_version,
        within_s=5.0,
        late=Late.GO_ON,
        words=_say("the autopilot does not tell its version"),
    ),
    State.TELEMETRY: Row(
        _telemetry_flows,
        State.ORIGIN,
        ask=_ask_telemetry,
        ask_every_s=0.1,
        within_s=10.0,
        late=Late.GO_ON,
        words=_say("the vehicle did not switch its telemetry as asked"),
    ),
    State.ORIGIN: Row(
        _origin_known,
        State.ROUTE,
        ask=_ask_origin,
        within_s=60.0,
        words=_say("the vehicle knows no position: no local origin in 60 s; wait for its GPS"),
    ),
    State.ROUTE: Row(_routed, State.CHECK),
    State.CHECK: Row(_checked, State.ARM, ask=_ask_parameters),
    State.ARM: Row(
        _armed,
        State.TAKEOFF,
        ask=_ask_arm,
        within_s=60.0,
        words=lambda s: f"it did not arm in 60 s; {s.answer(Command.COMPONENT_ARM_DISARM)}",
    ),
    State.TAKEOFF: Row(
        _at_height,
        State.PRESTREAM,
        ask=_ask_takeoff,
        ask_every_s=2.0,
        within_s=180.0,
        late=Late.COME_DOWN,
        words=lambda s: f"it did not reach its height in 180 s; {s.answer(Command.NAV_TAKEOFF)}",
        modes=lambda p: p.climb,
    ),
    State.PRESTREAM: Row(
        _prestreamed, State.OFFBOARD, enter=_prepare_join, modes=lambda p: p.climb, streams=True
    ),
    State.OFFBOARD: Row(
        _follows,
        State.ALIGN,
        ask=_ask_mode(lambda p: p.follow),
        within_s=8.0,
        late=Late.COME_DOWN,
        words=lambda s: (
            f"it did not change to {s.profile.follow.name} in 8 s; {s.answer(Command.DO_SET_MODE)}"
        ),
        modes=lambda p: (*p.climb, p.follow),
        streams=True,
    ),
    State.ALIGN: Row(_finished, State.STREAM, modes=lambda p: (p.follow,), streams=True, moves=True),
    State.STREAM: Row(
        _finished,
        State.LAND,
        enter=_prepare_stream,
        modes=lambda p: (p.follow,),
        streams=True,
        moves=True,
    ),
    State.HOLD: Row(_never, State.RETURN, modes=lambda p: (p.follow,), streams=True),
    State.RETURN: Row(
        _disarmed,
        State.OVER,
        ask=_ask_mode(lambda p: p.go_home),
        within_s=1800.0,
        late=Late.GIVE_UP,
        words=_say("it flew home and did not disarm"),
        modes=lambda p: (p.go_home, p.land),
        streams=True,
        may_disarm=True,
    ),
    State.LAND: Row(
        _disarmed,
        State.OVER,
        ask=_ask_mode(lambda p: p.land),
        within_s=600.0,
        late=Late.GIVE_UP,
        words=_say("it did not land and disarm in 600 s"),
        modes=lambda p: (p.land,),
        streams=True,
        may_disarm=True,
    ),
}
