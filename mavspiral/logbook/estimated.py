"""A flight on a real vehicle, measured by the vehicle's own estimate, together with those before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.flight.autopilots import autopilot_name
from mavspiral.flight.flight_log import FlightLog
from mavspiral.flight.outcome import Outcome
from mavspiral.flight.session import Session
from mavspiral.inspection import Inspection
from mavspiral.logbook.card import card_numbers
from mavspiral.logbook.live_flight import LiveFlight
from mavspiral.logbook.progress import (
    Flown,
    Progress,
    estimated_shots,
    inspected_s,
    left_of,
    moved,
    together,
)
from mavspiral.logbook.recording import Recording
from mavspiral.survey.shots import Shots
from mavspiral.survey.solids import Solids
from mavspiral.tour.sorties import Sortie

__all__ = ["estimated"]

STALE_US = 300_000


def estimated(
    inspection: Inspection,
    before: Progress,
    sorties: tuple[Sortie, ...],
    session: Session,
    outcome: Outcome,
    *,
    recording: Recording,
    shift_enu_m: FloatArray | None,
    duration_s: float,
    refused_n: int | None,
) -> LiveFlight:
    """The flight of the first of `sorties` that `session` led to `outcome`, after those `before` it.

    Args:
        inspection: that was flown.
        before: the flights that this one went on from.
        sorties: all that were left before it.
        session: that is over.
        outcome: how.
        recording: the files that it was written to.
        shift_enu_m: by how much the plan was taken to lie elsewhere before it, `(3,)`; None if it was not aligned.
        duration_s: by the wall clock.
        refused_n: frames that were refused on a link that is signed.
    """
    inspection = inspection.flown_by(autopilot_name(session.profile))
    log = session.log() if session.left_the_ground else None
    tracking_m, clearance_m = _measured(inspection, log)
    alignment = session.alignment
    if alignment is not None and alignment.approved:
        shift_enu_m = alignment.shift_enu_m
    shots, shifts_enu_m = before.shots, before.shifts_enu_m
    flown = before.flown
    if log is not None and session.trajectory is not None:
        begins_s = session.trajectory.span_s("inspection")[0]
        shots = (*shots, estimated_shots(inspection, sorties[0], log, begins_s, session.pictures))
        shifts_enu_m = (*shifts_enu_m, np.zeros(3) if shift_enu_m is None else shift_enu_m)
        flown = (*flown, Flown(sorties[0], inspected_s(log, sorties[0], begins_s), session.pictures))
    return LiveFlight(
        inspection=inspection,
        outcome=outcome,
        events=session.events,
        log=log,
        files=recording.files,
        troubles=recording.troubles,
        duration_s=duration_s,
        stream=session.figures,
        tracking_m=tracking_m,
        clearance_m=clearance_m,
        coverage=inspection.coverage_from(together(shots)) if shots else None,
        flights_n=before.flights_n + 1,
        sorties_left_n=len(sorties),
        inspected_s=max((flight.came_to_s for flight in flown), default=0.0),
        left_s=left_of(inspection, flown),
        earlier=before.logs,
        shots=together(tuple(map(moved, shots, shifts_enu_m))) if shots else None,
        pictures_n=len(session.pictures),
        missed_shots=session.missed_shots,
        refused_n=refused_n,
        shift_enu_m=shift_enu_m,
        alignment=alignment,
        photo_numbers=_photo_numbers(inspection, flown, shots),
    )


def _photo_numbers(
    inspection: Inspection, flown: tuple[Flown, ...], shots: tuple[Shots, ...]
) -> tuple[int, ...]:
    """Of each of the `shots`, all flights in a row; none where the camera runs by itself and nobody counts."""
    if inspection.mission.camera.trigger == "none":
        return ()
    numbers = card_numbers([flight.pictures for flight in flown])
    return tuple(number for row, posed in zip(numbers, shots, strict=True) if len(posed) for number in row)


def _measured(inspection: Inspection, log: FlightLog | None) -> tuple[FloatArray, FloatArray]:
    """Distances from the reference on the inspection, and from anything solid on the whole flight, as estimated."""
    if log is None or not log.t_us.size:
        return np.empty(0), np.empty(0)
    known = np.isfinite(log.estimate_position_enu_m).all(axis=1) & _fresh(log)
    away_m = np.sqrt(((log.estimate_position_enu_m - log.reference_position_enu_m) ** 2).sum(axis=1))
    tracking_m = away_m[log.on_leg("inspection") & known & np.isfinite(away_m)]
    solids = Solids.of_map(inspection.site.heights)
    return tracking_m, solids.distance_m(log.estimate_position_enu_m[known])


def _fresh(log: FlightLog) -> NDArray[np.bool_]:
    """Which rows hold an estimate that was not much older: where the link was silent, the last one stands still."""
    rows = np.arange(len(log.t_us))
    changed = np.append(True, np.any(np.diff(log.estimate_position_enu_m, axis=0) != 0.0, axis=1))
    since = np.maximum.accumulate(np.where(changed, rows, 0))
    return np.asarray((log.t_us - log.t_us[since]) < STALE_US)
