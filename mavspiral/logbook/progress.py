"""How far an inspection has come: what its journal holds, held against its plan."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError
from mavspiral.flight.flight_log import FlightLog
from mavspiral.flight.journal import read_journal
from mavspiral.flight.shutter import Picture
from mavspiral.inspection import Inspection
from mavspiral.survey.shots import Shots, flown_shots, shots_at
from mavspiral.tour.missed import Stretch, stretches_left
from mavspiral.tour.sorties import Sortie, flies

__all__ = [
    "Flown",
    "Progress",
    "captured_shots",
    "estimated_shots",
    "inspected_s",
    "left_of",
    "moved",
    "progress_of",
    "together",
]

DONE_S = 0.1
"""So near to a shot it was come to."""


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """What one flight did: on which sortie, to where of the inspection's own time it came, and its pictures."""

    sortie: Sortie
    came_to_s: float
    pictures: tuple[Picture, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Progress:
    """Earlier flights of an inspection.

    Args:
        flights_n: how many there were.
        done_s: to where it is flown, of the inspection's own time.
        flown: what each of them did.
        left_s: the stretches that are left to fly.
        logs: of those that came off the ground.
        shots: what they saw, from where they believed to be, in the plan as it lay.
        shifts_enu_m: by which the plan lay elsewhere in each of these flights.
        shift_enu_m: by which it was last found to lie elsewhere; None if it was not aligned.
        borrowed: what they have set on the vehicle and not put back (`Session.borrowed`).
    """

    flights_n: int = 0
    done_s: float = 0.0
    flown: tuple[Flown, ...] = ()
    left_s: tuple[Stretch, ...] = ((0.0, math.inf),)
    logs: tuple[FlightLog, ...] = ()
    shots: tuple[Shots, ...] = ()
    shifts_enu_m: tuple[FloatArray, ...] = ()
    shift_enu_m: FloatArray | None = None
    borrowed: dict[str, tuple[float, float]] = field(default_factory=dict)


def progress_of(inspection: Inspection, path: Path) -> Progress:
    """What the flights in the journal at `path` have done of `inspection` since one last took off to begin it afresh.

    Raises:
        InputError: there is no journal, it is of another plan, or nothing is left to fly.
    """
    journal = read_journal(path)
    told = [f for f in journal if len(f.rows) or f.shift_enu_m is not None]
    journaled = [flight for flight in told if len(flight.rows)]  # the others never took off
    afresh = [i for i, flight in enumerate(journaled) if not flight.begin["resumes"]]
    chain = journaled[afresh[-1] :] if afresh else journaled
    flown, logs, shots, shifts_enu_m = list[Flown](), list[FlightLog](), list[Shots](), list[FloatArray]()
    for flight in (*chain, *told[-1:]):
        if (digest := flight.begin["digest"]) != inspection.digest:
            raise InputError(
                f"{path}: holds flights of another plan (digest {digest}, now {inspection.digest}). "
                "Fix: resume with the mission and the map that were flown, or begin afresh without --resume"
            )
    for flight in chain:
        log = flight.log(inspection.site.heights.frame)
        if log is None or flight.place is None:
            continue
        sortie = inspection.sortie(flight.begin["begin_s"], flight.begin["end_s"])
        begins_s = flight.place["inspection_s"]
        flown.append(Flown(sortie, inspected_s(log, sortie, begins_s), flight.pictures))
        logs.append(log)
        shifts_enu_m.append(np.zeros(3) if flight.shift_enu_m is None else flight.shift_enu_m)
        shots.append(estimated_shots(inspection, sortie, log, begins_s, flight.pictures))
    borrowed = next((f.borrowed for f in reversed(journal) if f.borrowed is not None), {})
    if not (left_s := left_of(inspection, tuple(flown))):
        left = [f"{name} = {given:g} (was {own:g})" for name, (own, given) in borrowed.items()]
        also = f"; still set on the vehicle: {', '.join(left)}" if left else ""
        raise InputError(f"{path}: nothing is left to fly{also}. Fix: begin afresh without --resume")
    shift_enu_m = told[-1].shift_enu_m if told else None
    return Progress(
        flights_n=len(chain),
        done_s=max((flight.came_to_s for flight in flown), default=0.0),
        flown=tuple(flown),
        left_s=left_s,
        logs=tuple(logs),
        shots=tuple(shots),
        shifts_enu_m=tuple(shifts_enu_m),
        shift_enu_m=shift_enu_m,
        borrowed=borrowed,
    )


def left_of(inspection: Inspection, flown: tuple[Flown, ...]) -> tuple[Stretch, ...]:
    """The stretches that those flights have left: round every shot that was not taken.

    Where nobody has told of a picture, because the camera runs by itself or cannot tell, what was flown by was taken.
    """
    shots_s, had = inspection.shots_s, np.zeros(len(inspection.shots), dtype=bool)
    told = any(picture.shot >= 0 for flight in flown for picture in flight.pictures)
    for flight in flown:
        on_it = flies(flight.sortie, shots_s)
        if told:
            rows = np.flatnonzero(on_it)
            had[[rows[p.shot] for p in flight.pictures if 0 <= p.shot < len(rows)]] = True
        else:
            had |= on_it & (shots_s <= flight.came_to_s + DONE_S)
    ways_s = inspection.trajectory.duration_s - inspection.duration_s
    return stretches_left(had, shots_s, end_s=inspection.duration_s, ways_s=ways_s)


def estimated_shots(
    inspection: Inspection,
    sortie: Sortie,
    log: FlightLog,
    begins_s: float,
    pictures: tuple[Picture, ...],
) -> Shots:
    """What a flight shot, from where the vehicle believed to be; its inspection began at the path time `begins_s`.

    The pictures that were taken; the planned shots that it came by where nobody commands the camera.
    """
    if inspection.mission.camera.trigger != "none":
        return captured_shots(
            log,
            pictures,
            log.estimate_position_enu_m,
            log.estimate_yaw_enu_rad,
            inspection.pitch_on(sortie, log.path_t_s - begins_s),
        )
    known = np.isfinite(log.estimate_position_enu_m).all(axis=1) & np.isfinite(log.estimate_yaw_enu_rad)
    planned_s = (
        sortie.inspection_s(log.path_t_s[known] - begins_s) + inspection.trajectory.span_s("inspection")[0]
    )
    return flown_shots(
        inspection.shots,
        planned_s,
        log.estimate_position_enu_m[known],
        np.unwrap(log.estimate_yaw_enu_rad[known]),
    )


def captured_shots(
    log: FlightLog,
    pictures: tuple[Picture, ...],
    position_enu_m: FloatArray,
    yaw_enu_rad: FloatArray,
    pitch_rad: FloatArray,
) -> Shots:
    """The pictures from where the vehicle was when they were taken: rows of poses, one for each of the log's."""
    known = np.isfinite(position_enu_m).all(axis=1) & np.isfinite(yaw_enu_rad)
    taken_s = np.array(sorted(picture.vehicle_s for picture in pictures), dtype=np.float64)
    if not known.any():
        return Shots(np.empty(0), np.empty((0, 3)), np.empty(0), np.empty(0))
    return shots_at(
        taken_s,
        np.maximum.accumulate(log.vehicle_s[known]),
        position_enu_m[known],
        np.unwrap(yaw_enu_rad[known]),
        pitch_rad[known],
    )


def moved(shots: Shots, by_enu_m: FloatArray) -> Shots:
    """The shots from elsewhere: `by_enu_m` (3,) away."""
    return replace(shots, position_enu_m=shots.position_enu_m + by_enu_m)


def together(shots: tuple[Shots, ...]) -> Shots:
    """All of them in a row."""
    return Shots(
        np.concatenate([s.t_s for s in shots]),
        np.concatenate([s.position_enu_m for s in shots]),
        np.concatenate([s.yaw_enu_rad for s in shots]),
        np.concatenate([s.pitch_rad for s in shots]),
    )


def inspected_s(log: FlightLog, sortie: Sortie, begins_s: float) -> float:
    """To where of the inspection's own time a flight came; 0 if it never reached it."""
    since_s = float(np.nanmax(log.path_t_s, initial=-math.inf)) - begins_s
    return float(sortie.inspection_s(min(since_s, float(sortie.flown_s[-1])))) if since_s > 0.0 else 0.0
