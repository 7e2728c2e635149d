"""A simulated flight, measured by truth: how well it followed, what it saw, how near it came, what its estimator was worth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.flight.auto_flight import AutoFlight
from mavspiral.flight.flight_log import FlightLog
from mavspiral.flight.outcome import Outcome
from mavspiral.flight.schedule import StreamFigures
from mavspiral.flight.session import Session
from mavspiral.frames import GeoPoint, yaw_ned_to_enu
from mavspiral.inspection import Inspection
from mavspiral.logbook.along import log_along, pictures_along
from mavspiral.logbook.flown import Flight
from mavspiral.logbook.progress import captured_shots
from mavspiral.motion.trajectory import Trajectory
from mavspiral.survey.shots import Shots
from mavspiral.survey.solids import Solids
from mavspiral.tour.sorties import Sortie

__all__ = ["Seen", "measured"]


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What a witness wrote down of a simulated vehicle, from before its session began to its end.

    Args:
        time_us: of each row.
        position_ned_m: the truth, about home.
        velocity_ned_mps: the truth.
        yaw_ned_rad: the truth.
        believed_ned_m: the estimate, about its own origin.
        variance_ned_m2: what it believed of its error.
        believed_origin: where the estimator's frame begins.
        battery_used: share of it, in [0, 1].
    """

    time_us: NDArray[np.int64]
    position_ned_m: FloatArray
    velocity_ned_mps: FloatArray
    yaw_ned_rad: FloatArray
    believed_ned_m: FloatArray
    variance_ned_m2: FloatArray
    believed_origin: GeoPoint
    battery_used: float


def measured(
    inspection: Inspection,
    sortie: Sortie,
    trajectory: Trajectory,
    session: Session | AutoFlight,
    outcome: Outcome,
    seen: Seen,
    *,
    tlog: bytes,
    seed: int,
    sim_s: float,
    wall_s: float,
    rtf: float,
) -> Flight:
    """The flight along `trajectory` that `session` led to `outcome`, by what was `seen` of it.

    Every row of the session's log needs one of `seen` at its time.
    """
    frame, heights = inspection.site.heights.frame, inspection.site.heights
    to_home = frame.to_vehicle(frame.geo_point(inspection.home_enu_m))
    position_enu_m = to_home.position_enu_m(seen.position_ned_m)

    if isinstance(session, AutoFlight):
        log = session.log(frame, tuple(leg.name for leg in trajectory.legs))
    else:
        log = session.log()
    at = np.searchsorted(seen.time_us, log.t_us)
    yaw_enu_rad = np.unwrap(yaw_ned_to_enu(seen.yaw_ned_rad[at]))
    log = log.with_truth(position_enu_m[at], seen.velocity_ned_mps[at] @ to_home.R_ned_enu, yaw_enu_rad)
    if isinstance(session, AutoFlight):
        log = log_along(log, trajectory)
        captured_s = np.array([picture.time_boot_ms / 1e3 for picture in session.captured if picture.taken])
        shots = pictures_along(log, captured_s, trajectory)
    else:
        shots = _shots(inspection, sortie, trajectory, session, log, position_enu_m[at], yaw_enu_rad)
    inspecting = log.on_leg("inspection")
    tracking_m = np.sqrt(((position_enu_m[at] - log.reference_position_enu_m)[inspecting] ** 2).sum(axis=1))
    error_m = (
        frame.to_vehicle(seen.believed_origin).position_enu_m(seen.believed_ned_m[at]) - position_enu_m[at]
    )
    variance_enu_m2 = seen.variance_ned_m2[at][:, [1, 0, 2]]
    nees = (error_m**2 / variance_enu_m2).sum(axis=1) / 3.0
    return Flight(
        inspection=inspection,
        trajectory=trajectory,
        outcome=outcome,
        log=log,
        tlog=tlog,
        seed=seed,
        sim_s=sim_s,
        wall_s=wall_s,
        rtf=rtf,
        stream=StreamFigures(0, 0.0, 0.0) if isinstance(session, AutoFlight) else session.figures,
        via="mission" if isinstance(session, AutoFlight) else "stream",
        tracking_m=tracking_m,
        clearance_t_s=seen.time_us / 1e6,
        clearance_m=Solids.of_map(heights).distance_m(position_enu_m),
        shots=shots,
        coverage=inspection.coverage_from(shots),
        estimate_error_m=np.sqrt((error_m[inspecting] ** 2).sum(axis=1)),
        nees=nees[inspecting],
        battery_used=seen.battery_used,
    )


def _shots(
    inspection: Inspection,
    sortie: Sortie,
    trajectory: Trajectory,
    session: Session,
    log: FlightLog,
    position_enu_m: FloatArray,
    yaw_enu_rad: FloatArray,
) -> Shots:
    """From where a streamed flight's pictures were truly taken: those that were told, or that an intervalometer takes."""
    if inspection.mission.camera.trigger == "none":
        return inspection.flown_shots(trajectory, log.path_t_s, position_enu_m, yaw_enu_rad, sortie)
    since_s = log.path_t_s - trajectory.span_s("inspection")[0]
    pitch_rad = inspection.pitch_on(sortie, since_s)
    return captured_shots(log, session.pictures, position_enu_m, yaw_enu_rad, pitch_rad)
