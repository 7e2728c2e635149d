"""The values around a flight: its states, what it may be told, what a step gives back, how it ended."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from mavspiral.errors import InputError
from mavspiral.flight.flight_log import Event
from mavspiral.flight.governor import GovernorLimits

__all__ = ["Outcome", "SessionConfig", "State", "Step"]

RATE_MIN_HZ, RATE_MAX_HZ = 10.0, 100.0


class State(Enum):
    """Where in the flight we are."""

    CONNECT = "connect"
    IDENTIFY = "identify"
    TELEMETRY = "telemetry"
    ORIGIN = "origin"
    MEASURE = "measure where the plan lies"
    APPROVE = "await approval"
    ROUTE = "route"
    CHECK = "check"
    CONSENT = "await your word"
    FAILSAFES = "failsafes"
    ARM = "arm"
    TAKEOFF = "take off"
    PRESTREAM = "pre-stream"
    OFFBOARD = "offboard"
    ALIGN = "align"
    STREAM = "stream"
    HOLD = "hold"
    BRAKE = "brake"
    RETURN = "return"
    LEAVE = "leave"
    HAND_OVER = "hand over"
    LAND = "land"
    RESTORE = "restore"
    OVER = "over"


@dataclass(frozen=True, slots=True)
class SessionConfig:
    """What a flight may be told.

    Args:
        rate_hz: of the setpoints.
        governor: when path time slows down; its reserve also bounds how far the origin may move.
        battery_min_pct: below it the vehicle is not armed.
        battery_reserve_pct: the inspection ends when less would be left after the way home.
        join_max_m: farther than this from the first point after take-off, it lands instead of joining.
        follow_within_s: how long the vehicle may stay too far off its path before it is landed where it is.
        told_within_s: how long it may not tell where it is before it is landed there.
        stand_at_most_s: for so long path time may stand in all before the inspection is given up.
        safe_height_enu_m: the height in the plan's ENU above which nothing stands in a straight way home.
        lost_after_s: a silence after which the link is lost and the setpoints end.
        set_failsafes: set the parameters that make a lost link safe before the flight, and put them back after it.
        borrowed: parameters that an earlier flight has set and could not put back: the vehicle's own value of each, and
            the one that it was given. Those that are still so are put back after this flight.
        dry_run: do everything but arm; nothing is set either.
        question: what must be approved after the checks, before anything is set or armed; empty if nothing.
        planned_for: the autopilot that the mission names, if it names one; another one is told of.
        endurance_s: how long a flight may take as planned.
        home_height_enu_m: how high in the plan's ENU the mission has its home; NaN where it does not say.
        system_id: which MAVLink system is flown; None for the first vehicle that is heard.
    """

    rate_hz: float = 50.0
    governor: GovernorLimits = field(default_factory=GovernorLimits)
    battery_min_pct: float = 30.0
    battery_reserve_pct: float = 7.0
    join_max_m: float = 5.0
    follow_within_s: float = 20.0
    told_within_s: float = 5.0
    stand_at_most_s: float = 120.0
    safe_height_enu_m: float = -math.inf
    lost_after_s: float = 5.0
    set_failsafes: bool = False
    borrowed: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    dry_run: bool = False
    question: str = ""
    planned_for: str | None = None
    endurance_s: float = math.inf
    home_height_enu_m: float = math.nan
    system_id: int | None = None

    def __post_init__(self) -> None:
        """Checks the rate."""
        if not RATE_MIN_HZ <= self.rate_hz <= RATE_MAX_HZ:
            raise InputError(
                f"rate_hz is {self.rate_hz:g}, wanted {RATE_MIN_HZ:g} to {RATE_MAX_HZ:g}; take 50"
            )


@dataclass(frozen=True, slots=True)
class Outcome:
    """How it ended: in which state, why, and with which exit code (0 flown, 1 not as planned, 2, 3 link)."""

    ok: bool
    state: State
    reason: str
    exit_code: int


class Step(NamedTuple):
    """What to send, when to call again at the latest, and what there is to tell.

    `afterwards` is still to be done once `send` has gone, because it takes long; the next step does it first where nobody has.
    """

    send: bytes
    next_due_us: int
    events: tuple[Event, ...]
    afterwards: Callable[[], None] | None = None
