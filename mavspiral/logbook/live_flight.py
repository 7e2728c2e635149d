"""A flight on a real vehicle, and what was measured on it by the vehicle's own estimate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mavspiral.arrays import FloatArray
from mavspiral.flight.alignment import Alignment
from mavspiral.flight.flight_log import Event, FlightLog
from mavspiral.flight.outcome import Outcome
from mavspiral.flight.schedule import StreamFigures
from mavspiral.inspection import Inspection
from mavspiral.logbook.figures import SEEN, quantile, rounded, spread
from mavspiral.survey.coverage import Coverage
from mavspiral.survey.shots import Shots
from mavspiral.tour.missed import Stretch

__all__ = ["LiveFlight"]


@dataclass(frozen=True, slots=True, eq=False)
class LiveFlight:
    """A flight on a vehicle whose truth nobody knows: what was measured is against its own estimate.

    Coverage, `inspected_s`, `shots` and `photo_numbers` are of the `earlier` flights too that it went on from.

    Args:
        sorties_left_n: what was left before it, itself among them.
        inspected_s: to where of the inspection's own time it came.
        left_s: the stretches that are left, where it did not come or shots were missed.
        shots: all that were taken, where the vehicle said that it was; the log's places are in the plan as it lay.
        pictures_n: those of this flight.
        missed_shots: were commanded and never taken.
        refused_n: frames not signed with our key, or that had come before; None on a link that is not signed.
        shift_enu_m: by how much the plan lay elsewhere, `(3,)`; None if it was not aligned.
        alignment: what was measured for it.
        photo_numbers: how many pictures lie before each of `shots` on the camera's card; -1 where nobody can say,
            empty where the camera runs by itself.
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
        return (f"{left}; `mavspiral fly … --resume` flies it, with a battery that lasts for it",)

    @property
    def _aligned(self) -> dict[str, float | None] | None:
        """Where the plan lay, and how well that is known if it was measured before this very flight."""
        if self.shift_enu_m is None:
            return None
        east_m, north_m, _ = map(float, self.shift_enu_m)
        measured = self.alignment
        return {
            "east_m": rounded(east_m),
            "north_m": rounded(north_m),
            "spread_m": rounded(measured.spread_m) if measured else None,
            "rise_m": rounded(measured.rise_m) if measured else None,
        }

    def summary(self) -> dict[str, Any]:
        """The figures of `fly --json`, named as `simulate` names them; `source` says whose word they are."""
        return {
            "name": self.inspection.mission.name,
            "autopilot": self.inspection.mission.vehicle.autopilot,
            "via": "stream",
            "source": "estimate",
            "duration_s": round(self.duration_s, 2),
            "tracking": spread(self.tracking_m),
            "clearance_min_m": rounded(quantile(self.clearance_m, 0.0)),
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
