"""The same session that flies in simulation, driven against the world: a socket and the real clock."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.flight.alignment import shifted
from mavspiral.flight.autopilots import PROFILES, Autopilot
from mavspiral.flight.flight_log import Event, TlogWriter
from mavspiral.flight.journal import JournalWriter, borrowed_in
from mavspiral.flight.outcome import SessionConfig, State, Step
from mavspiral.flight.realtime import drive, signer_now
from mavspiral.flight.session import Session
from mavspiral.flight.transports import open_transport
from mavspiral.flight.wishes import Wish
from mavspiral.frames import LocalFrame
from mavspiral.inspection import Inspection
from mavspiral.logbook.estimated import estimated
from mavspiral.logbook.live_flight import LiveFlight
from mavspiral.logbook.progress import Progress, progress_of
from mavspiral.logbook.recording import Recording
from mavspiral.mission import Mission
from mavspiral.planner import plan
from mavspiral.tour.sorties import Sortie

__all__ = ["fly"]

Place = tuple[float, float] | Literal["home"]
"""Latitude and longitude in degrees, on the plan's ground; or the mission's home."""


def fly(
    mission: Mission | Inspection,
    url: str,
    *,
    dry_run: bool = False,
    rate_hz: float = 50.0,
    folder: Path | None = None,
    resume: bool = False,
    set_failsafes: bool = False,
    signing_key: bytes | None = None,
    autopilot: Autopilot | None = None,
    system_id: int | None = None,
    align_at: Place | None = None,
    asks: bool = False,
    approve: Callable[[str], bool | None] = lambda question: True,
    wished: Callable[[bool], Wish | None] = lambda held: None,
    on_event: Callable[[Event], None] = lambda event: None,
) -> LiveFlight:
    """The mission streamed to the vehicle at `url`, from connecting to disarming. It arms and flies: nobody is asked, unless it `asks`.

    Where one battery does not last, the first sortie is flown. With a `folder`, NAME.journal and NAME.tlog in it grow as it
    flies, and `resume` goes on where the flights in that journal ended; shots that they missed are flown again, the first
    gap first. `set_failsafes` sets the vehicle's parameters for the loss of the link before the flight, and puts them back
    after it; those that an earlier flight of that journal could not put back, too.
    With a `signing_key` (32 bytes, `read_key`) both ends sign, and what is not signed is refused and counted.
    The vehicle that stands `align_at` a known place of the plan says where it lies: `approve` is asked whether the plan may
    be shifted so, and `resume` keeps it. A dry run writes that in the journal, too.
    Where it `asks`, `approve` is asked after the checks whether the vehicle may be armed. It is called again and again until it
    says yes or no, as is `wished`, with whether the vehicle is held, for what the pilot wants then; neither may wait.
    Only a vehicle of `autopilot` and with MAVLink's `system_id` is flown, if they are given; else the first that is heard.

    Raises:
        InputError: the URL cannot be read, or its port is taken; or there is nothing that could be resumed.
        LimitError: the plan does not keep its own limits.
        LinkError: nobody listens at a TCP address.
    """
    inspection = plan(mission) if isinstance(mission, Mission) else mission
    order = _prepared(inspection, folder, resume, align_at)
    name, sortie = inspection.mission.name, order.sortie
    begin_us = time.monotonic_ns() // 1000
    signer = None if signing_key is None else signer_now(signing_key)
    with (
        contextlib.closing(open_transport(url, system_id)) as transport,
        Recording(folder, name) as recording,
    ):
        session = Session(
            lambda home_enu_m: inspection.route_from(home_enu_m, sortie),
            order.frame,
            SessionConfig(
                dry_run=dry_run,
                rate_hz=rate_hz,
                safe_height_enu_m=inspection.safe_height_enu_m,
                set_failsafes=set_failsafes,
                borrowed=order.before.borrowed,
                planned_for=_planned_for(inspection.mission),
                endurance_s=inspection.mission.vehicle.endurance_s,
                home_height_enu_m=inspection.mission.vehicle.home_height_m,
                system_id=system_id,
                question=f"arm the vehicle at {url} and fly {name}" if asks else "",
            ),
            way_home=inspection.way_home,
            profiles=tuple(PROFILES.values()) if autopilot is None else (PROFILES[autopilot],),
            shots=inspection.shot_orders(sortie),
            align_at_enu_m=order.align_at_enu_m,
            tap=TlogWriter(recording.packets, time.time_ns() // 1000).write,
            signer=signer,
        )
        journal = JournalWriter(recording.journal)
        journals = not dry_run or align_at is not None
        if journals:
            _begin(journal, order, resume)

        def told(_: Session, step: Step) -> None:
            for words in recording.news():
                session.warn(words)
            if journals:
                journal.note(session, step)
            for event in step.events:
                on_event(event)
            if session.outcome is None:
                _ask(session, journal, approve, wished)

        try:
            outcome = drive(
                session,
                transport,
                told,
                on_end=lambda: session.wish(Wish.GO_HOME),
                now_us=lambda: time.monotonic_ns() // 1000 - begin_us,
            )
        finally:
            if journals:
                journal.end(session)
    duration_s = (time.monotonic_ns() // 1000 - begin_us) / 1e6
    refused_n = None if signer is None else signer.refused_n
    return estimated(
        inspection,
        order.before,
        order.sorties,
        session,
        outcome,
        recording=recording,
        shift_enu_m=order.shift_enu_m,
        duration_s=duration_s,
        refused_n=refused_n,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Order:
    """What is flown now, and what was flown before it.

    Args:
        sorties: all that are left; the first is flown.
        align_at_enu_m: where the vehicle is said to stand, `(3,)`.
        shift_enu_m: by how much the plan lies elsewhere, as far as that is known before the flight, `(3,)`.
    """

    inspection: Inspection
    before: Progress
    sorties: tuple[Sortie, ...]
    align_at_enu_m: FloatArray | None
    shift_enu_m: FloatArray | None

    @property
    def sortie(self) -> Sortie:
        """The one that is flown."""
        return self.sorties[0]

    @property
    def frame(self) -> LocalFrame:
        """The plan's, where the plan lies."""
        frame = self.inspection.site.heights.frame
        return frame if self.shift_enu_m is None else shifted(frame, self.shift_enu_m)


def _prepared(inspection: Inspection, folder: Path | None, resume: bool, align_at: Place | None) -> _Order:
    name = inspection.mission.name
    if folder is not None:
        path = folder / f"{name}.journal"
        before = progress_of(inspection, path) if resume else Progress(borrowed=borrowed_in(path))
    elif not resume:
        before = Progress()
    else:
        raise InputError(f"{name}: nothing says where its journal is. Fix: give its folder")
    sorties = tuple(sortie for stretch_s in before.left_s for sortie in inspection.sorties(*stretch_s))
    if align_at is None:
        return _Order(inspection, before, sorties, None, before.shift_enu_m)
    return _Order(inspection, before, sorties, _place_enu_m(inspection, align_at), None)


def _begin(journal: JournalWriter, order: _Order, resume: bool) -> None:
    """Write down what is going to be flown."""
    journal.begin(
        {
            "name": order.inspection.mission.name,
            "digest": order.inspection.digest,
            "resumes": resume,
            "begin_s": order.sortie.begin_s,
            "end_s": order.sortie.end_s,
            "unix_us": time.time_ns() // 1000,
        }
    )
    if order.shift_enu_m is not None:
        journal.aligned(order.shift_enu_m)


def _ask(
    session: Session,
    journal: JournalWriter,
    approve: Callable[[str], bool | None],
    wished: Callable[[bool], Wish | None],
) -> None:
    """Hand on what the session asks and what the pilot says."""
    if question := session.question:
        answer = approve(question)
        if answer:
            if session.state is State.APPROVE:
                journal.aligned(_shift_enu_m(session))
            session.approve()
        elif answer is False:
            session.stop()
    if (wish := wished(session.state is State.HOLD)) is not None:
        session.wish(wish)


def _shift_enu_m(session: Session) -> FloatArray:
    """By which the plan is to be shifted, once that is asked."""
    assert session.alignment is not None and session.alignment.shift_enu_m is not None
    return session.alignment.shift_enu_m


def _place_enu_m(inspection: Inspection, place: Place) -> FloatArray:
    """Where a vehicle at that place stands in the plan."""
    if place == "home":
        if inspection.mission.vehicle.home is None:
            raise InputError(
                "--align home: the mission names no home. Fix: --align LAT,LON, or [vehicle] home = [lat, lon]"
            )
        return inspection.home_enu_m
    frame = inspection.site.heights.frame
    return frame.to_enu(*place, frame.origin.alt_amsl_m)


def _planned_for(mission: Mission) -> str | None:
    """The autopilot that the mission names, as people write it; None when it names none."""
    if "autopilot" not in mission.vehicle.model_fields_set:
        return None
    return PROFILES[mission.vehicle.autopilot].name
