"""The same inspection streamed and as a `.plan` in AUTO, side by side: `python tests/bench/stream_vs_mission.py [px4|ardupilot] [MISSION …]`.

All by truth. `beside`: how far from the nearest point of the planned curve; `heading`: off the planned gaze, when a
picture was taken. The mission is what `mavspiral plan` writes, with its own camera orders.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral import load_mission, plan
from mavspiral.closedloop import Via, simulate
from mavspiral.flight.autopilots import PROFILES, Autopilot
from mavspiral.frames import wrap_rad
from mavspiral.handover import inspection_missions
from mavspiral.logbook.along import log_along
from mavspiral.logbook.flown import Flight

ROOT = Path(__file__).parents[2]
GRID_S = 0.05
MISSIONS = ("kiosk", "asilo", "torre")


def beside_m(flight: Flight) -> np.ndarray:
    """Distances from the curve during the inspection, whatever the clock says."""
    log = log_along(flight.log, flight.trajectory)
    away = log.truth_position_enu_m - log.reference_position_enu_m
    return np.sqrt((away[log.on_leg("inspection")] ** 2).sum(axis=1))


def gaze_off_deg(flight: Flight) -> np.ndarray:
    """At each picture, the angle to the gaze that is planned for the nearest point of the whole curve, whichever sortie took it."""
    planned = flight.inspection.trajectory.sampled(GRID_S)
    nearest = [
        int(((planned.position_enu_m - place) ** 2).sum(axis=1).argmin())
        for place in flight.shots.position_enu_m
    ]
    return np.degrees(np.abs(wrap_rad(flight.shots.yaw_enu_rad - planned.yaw_enu_rad[nearest])))


def row(name: str, via: Via, dialect: Autopilot) -> str:
    inspection = plan(load_mission(ROOT / "missions" / f"{name}.toml")).flown_by(dialect)
    flight = simulate(inspection, via=via)
    assert flight.outcome.ok, flight.outcome
    away = beside_m(flight)
    rows = np.flatnonzero(flight.log.on_leg("inspection"))
    lasts_s = (flight.log.t_us[rows[-1]] - flight.log.t_us[rows[0]]) / 1e6
    counts = [] if via == "stream" else [len(m.items) for m in inspection_missions(inspection).missions]
    how = f"{' + '.join(map(str, counts))} items, AUTO" if counts else "streamed"
    figures = (
        f"{flight.sim_s:.0f} s",
        f"{lasts_s:.0f} s",
        f"{np.quantile(away, 0.95):.2f} m",
        f"{away.max():.2f} m",
        f"{np.quantile(gaze_off_deg(flight), 0.95):.1f}°",
        f"{flight.clearance_min_m:.2f} m",
        f"{100 * flight.coverage.walls:.1f} %",
        f"{len(flight.shots)}",
    )
    return f"{name:7}{how:22}" + "".join(f"{figure:>12}" for figure in figures)


def main() -> None:
    heads = ("flight", "inspection", "beside p95", "worst", "heading p95", "clearance", "seen", "shots")
    print(f"{'':29}" + "".join(f"{head:>12}" for head in heads))
    dialect: Autopilot = "ardupilot" if "ardupilot" in sys.argv[1:] else "px4"
    for name in [word for word in sys.argv[1:] if word not in PROFILES] or MISSIONS:
        for via in ("stream", "mission"):
            print(row(name, via, dialect), flush=True)


if __name__ == "__main__":
    main()
