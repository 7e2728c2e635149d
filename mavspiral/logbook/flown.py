"""What was flown, and what was measured on it: in simulation by truth, on a real vehicle by its own estimate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.flight.alignment import Alignment
from mavspiral.flight.flight_log import Event, FlightLog, joined
from mavspiral.flight.outcome import Outcome
from mavspiral.flight.schedule import StreamFigures
from mavspiral.inspection import Inspection
from mavspiral.logbook.progress import together
from mavspiral.motion.nearest import path_times_s
from mavspiral.motion.trajectory import Trajectory
from mavspiral.survey.coverage import Coverage
from mavspiral.survey.shots import Shots, shots_at
from mavspiral.tour.missed import Stretch

__all__ = ["Flight", "LiveFlight", "log_along", "one_after_the_other", "pictures_along"]


SEEN = ("walls", "walls_seeable", "walls_of_seeable", "roof", "roof_seeable", "roof_of_seeable")
"""The figures of coverage that a flight's summary has."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """A simulated flight and what was measured on it, by truth; `trajectory` is the one from where it stood."""

    inspection: Inspection
    trajectory: Trajectory
    outcome: Outcome
    log: FlightLog
    tlog: bytes
    seed: int
    sim_s: float
    wall_s: float
    rtf: float
    stream: StreamFigures
    tracking_m: FloatArray
    clearance_t_s: FloatArray
    clearance_m: FloatArray
    shots: Shots
    coverage: Coverage
    estimate_error_m: FloatArray
    nees: FloatArray
    battery_used: float
    via: str = "stream"

    @property
    def left_the_ground(self) -> bool:
        """Whether there is anything to see: the log begins with the take-off."""
        return bool(self.log.t_us.size)

    @property
    def duration_s(self) -> float:
        """From arming to the end: how long a vehicle takes to boot and to find itself is not the plan's."""
        t_us = self.log.t_us
        return float(t_us[-1] - t_us[0]) * 1e-6 if t_us.size else 0.0

    @property
    def tracking_p95_m(self) -> float:
        """95 % of the inspection was flown nearer to the reference than this; NaN if none of it was flown."""
        return _quantile(self.tracking_m, 0.95)

    @property
    def clearance_min_m(self) -> float:
        """The nearest that the vehicle came to anything solid, take-off to landing, be it by its own failsafe."""
        return float(self.clearance_m.min())

    @property
    def failures(self) -> tuple[str, ...]:
        """What does not hold, in words: the flight itself, then each key of [accept]."""
        accept, roof = self.inspection.mission.accept, self.inspection.mission.inspection.roof
        found = [] if self.outcome.ok else [f"the flight: {self.outcome.reason}"]
        if self.clearance_min_m <= self.inspection.mission.vehicle.radius_m:
            found.append(f"collision: {self.clearance_min_m:.2f} m from something solid")
        for name, measured, allowed, at_least in (
            ("tracking_p95_m", self.tracking_p95_m, accept.tracking_p95_m, False),
            ("tracking_max_m", _quantile(self.tracking_m, 1.0), accept.tracking_max_m, False),
            ("clearance_min_m", self.clearance_min_m, accept.clearance_min_m, True),
            ("coverage", self.coverage.walls, accept.coverage, True),
            ("coverage, roof", self.coverage.roof, accept.coverage if roof else None, True),
            ("duration_max_s", self.duration_s, accept.duration_max_s, False),
        ):
            if allowed is None:
                continue
            # Written so that a NaN, nothing measured, fails.
            if not (measured >= allowed if at_least else measured <= allowed):
                bound = "at least" if at_least else "at most"
                found.append(f"[accept] {name}: {measured:.3f}, wanted {bound} {allowed:g}")
        return tuple(found)

    @property
    def passed(self) -> bool:
        """Whether the flight went as planned and everything in [accept] holds."""
        return not self.failures

    def summary(self) -> dict[str, Any]:
        """The figures of `simulate --json`; what is not worked out is None."""
        return {
            "name": self.inspection.mission.name,
            "seed": self.seed,
            "autopilot": self.inspection.mission.vehicle.autopilot,
            "via": self.via,
            "sim_s": round(self.sim_s, 2),
            "wall_s": round(self.wall_s, 3),
            "rtf": round(self.rtf, 1),
            "tracking": _spread(self.tracking_m),
            "estimator": {
                "rms_m": _rounded(_rms(self.estimate_error_m)),
                "nees_mean": _rounded(_mean(self.nees)),
            },
            "clearance_min_m": _rounded(self.clearance_min_m),
            "coverage": {kind: self.coverage.summary()[kind] for kind in SEEN},
            "battery_used_pct": round(100.0 * self.battery_used, 1),
            "setpoints": {"sent": self.stream.sent_n, "rate_hz": round(self.stream.rate_hz, 2)},
            "events": [
                {"t_s": e.t_us / 1e6, "severity": e.severity, "text": e.text} for e in self.log.events
            ],
            "passed": self.passed,
            "failures": list(self.failures),
        }


def one_after_the_other(flights: Sequence[Flight]) -> Flight:
    """The sorties of an inspection as one flight: figures over all of them, the battery of the one that used most.

    `trajectory` is the first one's, and so are the path times of its rows alone.
    """
    first, last = flights[0], flights[-1]
    begins_s = [sum(flight.sim_s for flight in flights[:number]) for number in range(len(flights))]
    sim_s, wall_s = sum(flight.sim_s for flight in flights), sum(flight.wall_s for flight in flights)
    sent_n = sum(flight.stream.sent_n for flight in flights)
    shots = together(tuple(flight.shots for flight in flights))
    return replace(
        first,
        outcome=last.outcome,
        log=joined([flight.log for flight in flights], [round(1e6 * begin_s) for begin_s in begins_s]),
        tlog=b"".join(flight.tlog for flight in flights),
        sim_s=sim_s,
        wall_s=wall_s,
        rtf=sum(flight.rtf * flight.wall_s for flight in flights) / wall_s,
        stream=StreamFigures(
            sent_n,
            sum(flight.stream.rate_hz * flight.stream.sent_n for flight in flights) / max(sent_n, 1),
            max(flight.stream.worst_gap_s for flight in flights),
        ),
        clearance_t_s=np.concatenate(
            [flight.clearance_t_s + begin_s for flight, begin_s in zip(flights, begins_s, strict=True)]
        ),
        shots=shots,
        coverage=first.inspection.coverage_from(shots),
        battery_used=max(flight.battery_used for flight in flights),
        tracking_m=np.concatenate([flight.tracking_m for flight in flights]),
        clearance_m=np.concatenate([flight.clearance_m for flight in flights]),
        estimate_error_m=np.concatenate([flight.estimate_error_m for flight in flights]),
        nees=np.concatenate([flight.nees for flight in flights]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class LiveFlight:
    """A flight on a vehicle whose truth nobody knows: what was measured is against its own estimate.

    Coverage and `inspected_s`, to where of the inspection's own time it came, are of the `earlier` flights too that it went
    on from; `left_s` are the stretches that are left, where it did not come or shots were missed; `sorties_left_n` counts what was left before it, itself among them.
    `shots` are all that were taken, where the vehicle said that it was (the log's places are in the plan as it lay), `photo_numbers` how many pictures lie before each
    of them on the camera's card (-1: nobody can say; empty where the camera runs by itself), `pictures_n` those of this flight; `missed_shots` were commanded and never taken.
    `shift_enu_m` (3,) is by how much the plan lay elsewhere, None if it was not aligned, `alignment` what was measured for it.
    `refused_n` frames were not signed with our key, or had come before; None on a link that is not signed.
    """

    inspection: Inspection
    outcome: Outcome
    events: tuple[Event, ...]
    log: FlightLog | None
    files: dict[str, str]
    troubles: tuple[str, ...]
    duration_s: float
    stream: StreamFigures
    tracking_m: FloatArray
    clearance_m: FloatArray
    coverage: Coverage | None
    flights_n: int
    sorties_left_n: int
    inspected_s: float
    left_s: tuple[Stretch, ...]
    earlier: tuple[FlightLog, ...]
    shots: Shots | None
    pictures_n: int
    missed_shots: tuple[int, ...]
    refused_n: int | None = None
    shift_enu_m: FloatArray | None = None
    alignment: Alignment | None = None
    photo_numbers: tuple[int, ...] = ()

    @property
    def _left(self) -> tuple[str, ...]:
        """What is left to fly, in words."""
        if self.log is None or not self.left_s:
            return ()
        where = ", ".join(f"{begin_s:.0f} to {end_s:.0f} s" for begin_s, end_s in self.left_s)
        left = f"left to inspect: {where} of {self.inspection.duration_s:.0f} s"
        return (f"{left}; with a full battery, `mavspiral fly … --resume` flies it",)

    @property
    def _aligned(self) -> dict[str, float | None] | None:
        """Where the plan lay, and how well that is known if it was measured before this very flight."""
        if self.shift_enu_m is None:
            return None
        east_m, north_m, _ = map(float, self.shift_enu_m)
        measured = self.alignment
        return {
            "east_m": _rounded(east_m),
            "north_m": _rounded(north_m),
            "spread_m": _rounded(measured.spread_m) if measured else None,
            "rise_m": _rounded(measured.rise_m) if measured else None,
        }

    def summary(self) -> dict[str, Any]:
        """The figures of `fly --json`, named as `simulate` names them; `source` says whose word they are."""
        return {
            "name": self.inspection.mission.name,
            "autopilot": self.inspection.mission.vehicle.autopilot,
            "via": "stream",
            "source": "estimate",
            "duration_s": round(self.duration_s, 2),
            "tracking": _spread(self.tracking_m),
            "clearance_min_m": _rounded(_quantile(self.clearance_m, 0.0)),
            "coverage": {kind: self.coverage.summary()[kind] if self.coverage else None for kind in SEEN},
            "inspected": {
                "flights": self.flights_n,
                "sorties_left": self.sorties_left_n,
                "done_s": round(self.inspected_s, 2),
                "of_s": round(self.inspection.duration_s, 2),
                "left_s": [[round(begin_s, 2), round(end_s, 2)] for begin_s, end_s in self.left_s],
            },
            "shots": {"taken": self.pictures_n, "missed": [shot + 1 for shot in self.missed_shots]},
            "aligned": self._aligned,
            "setpoints": {
                "sent": self.stream.sent_n,
                "rate_hz": round(self.stream.rate_hz, 2),
                "worst_gap_s": round(self.stream.worst_gap_s, 3),
            },
            "refused": self.refused_n,
            "events": [
                {"t_s": round(e.t_us / 1e6, 3), "severity": e.severity, "text": e.text} for e in self.events
            ],
            "passed": self.outcome.ok,
            "failures": [] if self.outcome.ok else [self.outcome.reason],
            "warnings": [*self.troubles, *self._left],
        }


def log_along(log: FlightLog, trajectory: Trajectory) -> FlightLog:
    """The log of a flight that followed no clock of ours: the reference of each row is the nearest point, by truth."""
    assert log.truth_position_enu_m is not None
    path_t_s = path_times_s(trajectory, log.truth_position_enu_m)
    states = trajectory(path_t_s)
    begins_s = [trajectory.span_s(leg.name)[0] for leg in trajectory.legs]
    return replace(
        log,
        path_t_s=path_t_s,
        leg=np.searchsorted(begins_s, path_t_s, side="right") - 1,
        reference_position_enu_m=states.position_enu_m,
        reference_velocity_enu_mps=states.velocity_enu_mps,
        reference_yaw_enu_rad=states.yaw_enu_rad,
    )


def pictures_along(log: FlightLog, vehicle_s: FloatArray, trajectory: Trajectory) -> Shots:
    """The pictures taken at those times of the vehicle's clock, from where it truly was; pitch as planned for the place."""
    assert log.truth_position_enu_m is not None and log.truth_yaw_enu_rad is not None
    if not len(log.vehicle_s):  # it never left the ground
        return Shots(np.empty(0), np.empty((0, 3)), np.empty(0), np.empty(0))
    logged = (vehicle_s >= log.vehicle_s[0]) & (vehicle_s <= log.vehicle_s[-1])
    path_t_s = np.interp(vehicle_s[logged], log.vehicle_s, log.path_t_s)
    pitch_rad = trajectory(log.path_t_s).gimbal_pitch_rad
    posed = shots_at(
        vehicle_s[logged], log.vehicle_s, log.truth_position_enu_m, log.truth_yaw_enu_rad, pitch_rad
    )
    return replace(posed, t_s=path_t_s)


def _spread(errors_m: FloatArray) -> dict[str, float | None]:
    return {
        "rms_m": _rounded(_rms(errors_m)),
        "p95_m": _rounded(_quantile(errors_m, 0.95)),
        "max_m": _rounded(_quantile(errors_m, 1.0)),
    }


def _rms(values: FloatArray) -> float:
    return math.sqrt(float((values**2).mean())) if len(values) else math.nan


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else math.nan


def _quantile(values: FloatArray, share: float) -> float:
    return float(np.quantile(values, share)) if len(values) else math.nan


def _rounded(value: float) -> float | None:
    """Three decimals; None for what was not measured, because JSON has no NaN."""
    return round(value, 3) if math.isfinite(value) else None
