"""Wherever a flight fails, it does not hit the building: `python tests/bench/bench_faults.py [MISSION …]`.

Every kind of fault, in both dialects, at a tenth, the half and nine tenths of the inspection (the podium: the half), and by
truth: the nearest that the vehicle came to anything solid until it was down, be it by its own failsafe. The vehicle's failsafes
are set for the flight (`fly --set-failsafes`). `!` is nearer than the mission's `clearance_m`, `!!` a touch. Under each row that has one, how the worst flight ended.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral import load_mission, plan
from mavspiral.closedloop import simulate
from mavspiral.flight.autopilots import Autopilot
from mavspiral.inspection import Inspection
from mavspiral.logbook.flown import Flight

ROOT = Path(__file__).parents[2]
DIALECTS: tuple[Autopilot, ...] = ("px4", "ardupilot")
SHARES = {"kiosk": (0.1, 0.5, 0.9), "podium": (0.5,)}
FAULTS = (
    "gps_loss@{}s", "gps_loss@{}s+20s", "gps_jump=5m@{}s", "gps_drift=0.2@{}s+30s", "multipath=2m@{}s", "motor=2:0.7@{}s",
    "motor=2:0.5@{}s", "wind_step=8@{}s", "battery=low@{}s", "battery=critical@{}s", "battery=emergency@{}s",
    "baro_step=3m@{}s", "baro_step=-3m@{}s", "mag_disturb=0.2@{}s+20s", "sensor_stuck=accel@{}s", "sensor_stuck=gyro@{}s",
    "sensor_stuck=baro@{}s", "sensor_stuck=mag@{}s", "sensor_stuck=gps@{}s", "link_loss@{}s+20s", "link_loss@{}s",
    "packet_loss=30%@{}s", "delay=200ms@{}s",
)  # fmt: skip


def moments_s(inspection: Inspection, shares: tuple[float, ...]) -> list[float]:
    """The simulated time at those shares of the inspection, as the calm flight has it."""
    log = simulate(inspection, set_failsafes=True).log
    times_s = log.t_us[log.on_leg("inspection")] * 1e-6
    return [float(np.quantile(times_s, share)) for share in shares]


def ending(flight: Flight) -> str:
    """How it ended: by us, then alone."""
    last = flight.log.events[-1].text if flight.log.events else ""
    return flight.outcome.reason if last == flight.outcome.reason else f"{flight.outcome.reason}; {last}"


def main() -> None:
    for name in sys.argv[1:] or tuple(SHARES):
        inspection = plan(load_mission(ROOT / "missions" / f"{name}.toml"))
        inspection.sorties()
        kept_m = inspection.mission.limits.clearance_m
        flown = {dialect: inspection.flown_by(dialect) for dialect in DIALECTS}
        shares = SHARES.get(name, (0.5,))
        times_s = {dialect: moments_s(flown[dialect], shares) for dialect in DIALECTS}
        print(f"{name}, clearance_m = {kept_m:g}: nearest to anything solid, by truth, m")
        heads = [f"{dialect} {share:.0%}" for dialect in DIALECTS for share in shares]
        print(f"{'':24}" + "".join(f"{head:>16}" for head in heads))
        for spec in FAULTS:
            cells, worst = [], None
            for dialect in DIALECTS:
                for at_s in times_s[dialect]:
                    flight = simulate(
                        flown[dialect], faults=(spec.format(f"{at_s:.0f}"),), set_failsafes=True
                    )
                    nearest_m = flight.clearance_min_m
                    touched = nearest_m <= inspection.mission.vehicle.radius_m
                    cells.append(
                        f"{nearest_m:.2f}{'!!' if touched else '! ' if nearest_m < kept_m else '  '}"
                    )
                    if worst is None or nearest_m < worst[0]:
                        worst = nearest_m, f"{dialect} at {at_s:.0f} s: {ending(flight)}"
            print(f"{spec.replace('@{}s', '@'):24}" + "".join(f"{cell:>16}" for cell in cells), flush=True)
            assert worst is not None
            if worst[0] < kept_m:
                print(f"    {worst[1]}", flush=True)


if __name__ == "__main__":
    main()
