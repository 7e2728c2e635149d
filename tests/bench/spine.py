"""The spine's numbers in one table: `python tests/bench/spine.py`. Medians of warm runs; the machine is noisy.

planning without coverage · closed loop with MAVLink bytes both ways · tracking by truth · --help · first simulate
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
MISSIONS = ("torre", "asilo", "kiosk")
RUNS = 5


def shell_s(*command: str, **environment: str) -> float:
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, *command],
        cwd=ROOT,
        check=True,
        capture_output=True,
        env={**os.environ, **environment},
    )
    return time.perf_counter() - begin


def planning(name: str) -> tuple[float, str]:
    from mavspiral import load_mission, plan

    mission = load_mission(ROOT / "missions" / f"{name}.toml")
    plan(mission)
    laps = [plan(mission).planning_ms for _ in range(3 * RUNS)]
    stages = [stage for stage in laps[0] if stage not in ("total", "coverage")]
    split = ", ".join(f"{stage} {statistics.median(lap[stage] for lap in laps):.0f}" for stage in stages)
    return statistics.median(sum(lap[stage] for stage in stages) for lap in laps), split


def closed_loop(name: str, autopilot: str) -> float:
    """Simulated by processor time, MAVLink bytes both ways: the median of warm flights."""
    from mavspiral import load_mission, plan, simulate

    inspection = plan(load_mission(ROOT / "missions" / f"{name}.toml"))
    with mock.patch("mavspiral.closedloop.time.perf_counter", time.process_time):
        simulate(inspection, autopilot=autopilot)
        return statistics.median(simulate(inspection, autopilot=autopilot).rtf for _ in range(RUNS))


def flights(name: str) -> tuple[float, float]:
    from mavspiral import load_mission, plan, simulate

    inspection = plan(load_mission(ROOT / "missions" / f"{name}.toml"))
    flown = [simulate(inspection, seed=seed) for seed in range(RUNS)]
    p95 = max(flight.tracking_p95_m for flight in flown)
    return p95, min(flight.clearance_min_m for flight in flown)


def standard_gps(name: str) -> float:
    from mavspiral import load_mission, simulate

    mission = load_mission(ROOT / "missions" / f"{name}.toml")
    vehicle = mission.vehicle.model_copy(update={"gps": "standard"})
    return simulate(mission.model_copy(update={"vehicle": vehicle})).tracking_p95_m


def main() -> None:
    print(f"{'':44}{'measured':>12}  asked")
    for name in MISSIONS:
        total_ms, split = planning(name)
        asked = "≤ 150 ms" if name == "torre" else ""
        print(f"planning {name + ', coverage aside':35}{total_ms:>9.0f} ms  {asked:10} {split}")
    for name in (*MISSIONS, "podium"):
        for autopilot in ("px4", "ardupilot"):
            rtf = closed_loop(name, autopilot)
            print(f"closed loop {f'{name}, {autopilot}, of one core':32}{rtf:>10.0f} ×  ≥ 200 ×")
    for name in MISSIONS:
        p95_m, clearance_m = flights(name)
        asked = "≤ 0.3 m" if name == "torre" else ""
        print(f"tracking {name + f', RTK, worst p95 of {RUNS} seeds':35}{p95_m:>10.3f} m  {asked}")
        print(f"clearance {name + f', least of {RUNS} seeds':34}{clearance_m:>10.2f} m")
    print(f"{'tracking torre, standard GPS, p95':44}{standard_gps('torre'):>10.3f} m  reported")
    help_s = statistics.median(shell_s("-m", "mavspiral.cli", "--help") for _ in range(RUNS))
    print(f"{'mavspiral --help':44}{help_s:>10.2f} s  ≤ 0.4 s")
    with tempfile.TemporaryDirectory() as empty:
        command = ("-m", "mavspiral.cli", "simulate", "missions/torre.toml", "--out", f"{empty}/out")
        cold_s = shell_s(*command, NUMBA_CACHE_DIR=f"{empty}/numba")
        warm_s = shell_s(*command, NUMBA_CACHE_DIR=f"{empty}/numba")
    print(f"{'first simulate of the torre, numba compiling':44}{cold_s:>10.1f} s  ≤ 60 s")
    print(f"{'the same again':44}{warm_s:>10.1f} s")


if __name__ == "__main__":
    main()
