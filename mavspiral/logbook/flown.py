"""A simulated flight, and what was measured on it by truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.flight.flight_log import FlightLog, joined
from mavspiral.flight.outcome import Outcome
from mavspiral.flight.schedule import StreamFigures
from mavspiral.inspection import Inspection
from mavspiral.logbook.figures import SEEN, mean, quantile, rms, rounded, spread
from mavspiral.logbook.progress import together
from mavspiral.motion.trajectory import Trajectory
from mavspiral.survey.coverage import Coverage
from mavspiral.survey.shots import Shots

__all__ = ["Flight", "one_after_the_other"]


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
        return quantile(self.tracking_m, 0.95)

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
            ("tracking_max_m", quantile(self.tracking_m, 1.0), accept.tracking_max_m, False),
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
            "tracking": spread(self.tracking_m),
            "estimator": {
                "rms_m": rounded(rms(self.estimate_error_m)),
                "nees_mean": rounded(mean(self.nees)),
            },
            "clearance_min_m": rounded(self.clearance_min_m),
            "coverage": {kind: self.coverage.summary()[kind] for kind in SEEN},
            "battery_used_pct": round(100.0 * self.battery_used, 1),
            "setpoints": {"sent": self.stream.sent_n, "rate_hz": round(self.stream.rate_hz, 2)},
            "events": [
                {"t_s": e.t_us / 1e6, "severity": e.severity, "text": e.text} for e in self.log.events
            ],
            "passed": self.passed,
            "warnings": list(self.inspection.warnings),
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
