"""The vehicle alone, measured: real-time factor, compile time, tracking of PX4's circle. Prints one table.

python tests/bench/bench_vehicle.py
"""

from __future__ import annotations

import dataclasses
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(0, str(Path(__file__).parents[1] / "sitl"))
import sih

from sitl.airframe import load_airframe
from sitl.params import Params
from sitl.signals import Demand, GeoPoint, Setpoint
from sitl.vehicle import Vehicle, VehicleConfig

NOTHING = (math.nan,) * 3
X500 = load_airframe("x500")
PX4 = {  # knowledge/real_autopilots.md: position; and velocity; and acceleration
    "no noise, no drag": ("2.91", "0.489", "0.071"),
    "no noise, light drag": ("3.04", "0.529", "0.183"),
    "SIH noise, light drag": ("3.03", "0.65-0.73", "0.59; at 20 Hz 0.33-0.52"),
}
SIH_SEEDS = 8


def demand(p=NOTHING, v=NOTHING, a=NOTHING, armed=True) -> Demand:
    return Demand(armed, False, Setpoint(p, v, a, 0.0, math.nan))


def vehicle(airframe=X500, **config) -> Vehicle:
    home = GeoPoint(19.4332, -99.1412, 2240.0)
    one = Vehicle(VehicleConfig(airframe, Params(airframe.params), home, **config))
    one.advance(3_000_000, demand(armed=False))
    one.advance(18_000_000, demand((10.0, 0.0, -10.0)))
    return one


def without_drag():
    body = dataclasses.replace(X500.body, drag_area_m2=np.zeros(3))
    rotors = dataclasses.replace(X500.rotors, drag_n_per_radps_mps=0.0)
    return dataclasses.replace(X500, body=body, rotors=rotors)


def circle_rms_m(one: Vehicle, kind: int) -> tuple[float, float]:
    """Horizontal RMS of the estimate and of the truth against a circle of 10 m at 3 m/s, 50 Hz, two laps."""
    start, errors = one.time_us, []
    while one.time_us < start + 63_000_000:
        th = 0.3 * (one.time_us - start) * 1e-6
        c, s = math.cos(th), math.sin(th)
        wanted = np.array((10.0 * c, 10.0 * s, -10.0))
        if th > 2.0 * math.pi:
            errors.append((one.estimate.position_ned_m - wanted, one.truth.position_ned_m - wanted))
        v, a = (-3.0 * s, 3.0 * c, 0.0), (-0.9 * c, -0.9 * s, 0.0)
        order = demand(wanted, v if kind > 0 else NOTHING, a if kind > 1 else NOTHING)
        one.advance(one.time_us + 20_000, order)
    rms = np.sqrt((np.array(errors)[:, :, :2] ** 2).sum(axis=2).mean(axis=0))
    return float(rms[0]), float(rms[1])


def real_time_factor(one: Vehicle, seconds: int = 60) -> float:
    """Of one core: simulated by processor time, so that a busy machine does not matter much."""
    order, factors = demand((10.0, 0.0, -10.0)), []
    for _ in range(5):
        begun = time.process_time()
        one.advance(one.time_us + seconds * 1_000_000, order)
        factors.append(seconds / (time.process_time() - begun))
    return statistics.median(factors)


def start_up_s() -> tuple[float, float]:
    """Processor time of a process that flies 18 s: with an empty numba cache, and with a full one."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache, "BENCH_ONLY_START": "1"}
        spent = []
        for _ in range(2):
            begun = sum(os.times()[2:4])
            subprocess.run([sys.executable, __file__], env=environment, check=True)
            spent.append(sum(os.times()[2:4]) - begun)
    return spent[0], spent[1]


def main() -> None:
    everything_on = {"wind_ned_mps": (5.0, 3.0, 0.0), "gusts": True}
    cold, warm = start_up_s()
    print(f"start-up, processor time: {cold:.1f} s cold, {warm:.1f} s warm")
    print(f"real-time factor, wind and gusts: {real_time_factor(vehicle(**everything_on)):.0f}")
    stock = real_time_factor(vehicle(stock_filter=True, **everything_on))
    print(f"  filterpy's own arithmetic:      {stock:.0f}")
    print("circle of 10 m at 3 m/s, horizontal RMS, m: estimate (truth) [PX4]")
    for name, airframe, config in (
        ("no noise, no drag", without_drag(), {"noise": False}),
        ("no noise, light drag", X500, {"noise": False}),
        ("standard GPS", X500, {"gps": "standard"}),
        ("RTK", X500, {}),
        ("RTK, 7inch", load_airframe("7inch"), {}),
        ("RTK, camera", load_airframe("camera"), {}),
    ):
        row = []
        for kind in range(3):
            estimate, truth = circle_rms_m(vehicle(airframe, **config), kind)
            px4 = f" [{PX4[name][kind]}]" if name in PX4 else ""
            row.append(f"{estimate:.3f} ({truth:.3f}){px4}")
        print(f"  {name:22}", "   ".join(row))
    with_sih_noise()


def with_sih_noise() -> None:
    """PX4's noise: how far one flight differs from another."""
    name = "SIH noise, light drag"
    for kind, px4 in enumerate(PX4[name]):
        rms = [circle_rms_m(vehicle(**sih.config(X500), seed=seed), kind) for seed in range(SIH_SEEDS)]
        mine = [estimate for estimate, _ in rms]
        truth = statistics.mean(truth for _, truth in rms)
        print(f"  {name} {'pva'[: kind + 1]:3}: {statistics.mean(mine):.3f}, from {min(mine):.3f} to {max(mine):.3f} "
              f"({truth:.3f}) [{px4}], {SIH_SEEDS} seeds")  # fmt: skip


if __name__ == "__main__":
    if os.environ.get("BENCH_ONLY_START"):
        vehicle()
    else:
        main()
