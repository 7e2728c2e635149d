"""The vehicle alone, measured: real-time factor, compile time, tracking of PX4's circle. Prints one table.

PYTHONPATH=. python tests/bench/bench_vehicle.py
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

import numpy as np

from sitl.airframe import Receiver, load_airframe
from sitl.params import Params
from sitl.signals import Demand, GeoPoint, Setpoint, vector
from sitl.vehicle import Vehicle, VehicleConfig

NOTHING = (math.nan,) * 3
X500 = load_airframe("x500")
PX4 = {  # knowledge/real_autopilots.md: position; and velocity; and acceleration
    "no noise, no drag": ("2.91", "0.489", "0.071"),
    "no noise, light drag": ("3.04", "0.529", "0.183"),
    "SIH noise, light drag": ("3.03", "0.65-0.73", "0.59"),
}
# PX4's simulation in hardware: what sih.cpp, sensor_gps_sim and sensor_mag_sim add, white, at 250 Hz and 8 Hz, as
# densities of the two axes that bear on the horizontal position: accelerometer 0.5 and 1.7 m/s², gyro 0.14 and
# 0.07 rad/s; and by what EKF2's defaults judge it at its 100 Hz: EKF2_ACC_NOISE 0.35, EKF2_GYR_NOISE 0.015, biases 0.003
# and 0.001, the fix's own eph, epv and speed variance of 0.9 m, 1.78 m and 0.4 m/s.
SIH = dataclasses.replace(
    X500.senses,
    accel_noise_mps2_rthz=0.079,
    gyro_noise_radps_rthz=0.0070,
    mag_noise_gauss=0.023,
    baro_noise_m=0.14,
    baro_drift_m=0.1,
)
SIH_FIX = Receiver(0.2, 0.5, 0.0, 0.0, 1.0, 0.1, fix_type=3, satellites=10)
EKF2 = dataclasses.replace(
    SIH,
    accel_noise_mps2_rthz=0.035,
    gyro_noise_radps_rthz=0.0015,
    accel_walk_mps3_rthz=3e-4,
    gyro_walk_radps2_rthz=1e-4,
    mag_noise_gauss=0.05,
    baro_noise_m=3.5,
    baro_drift_m=0.0,
)
EKF2_FIX = Receiver(0.9, 1.78, 0.0, 0.0, 1.0, 0.4, fix_type=3, satellites=10)


def demand(p=NOTHING, v=NOTHING, a=NOTHING, armed=True) -> Demand:
    return Demand(armed, False, Setpoint(vector(p), vector(v), vector(a), 0.0, math.nan))


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
    sih = dataclasses.replace(X500, senses=SIH)
    cold, warm = start_up_s()
    print(f"start-up, processor time: {cold:.1f} s cold, {warm:.1f} s warm")
    print(f"real-time factor, wind and gusts: {real_time_factor(vehicle(**everything_on)):.0f}")
    stock = real_time_factor(vehicle(stock_filter=True, **everything_on))
    print(f"  filterpy's own arithmetic:      {stock:.0f}")
    print("circle of 10 m at 3 m/s, horizontal RMS, m: estimate (truth) [PX4]")
    for name, airframe, config in (
        ("no noise, no drag", without_drag(), {"noise": False}),
        ("no noise, light drag", X500, {"noise": False}),
        ("SIH noise, light drag", sih, {"gps": SIH_FIX, "supposed": (EKF2, EKF2_FIX)}),
        ("  another seed", sih, {"gps": SIH_FIX, "supposed": (EKF2, EKF2_FIX), "seed": 1}),
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


if __name__ == "__main__":
    if os.environ.get("BENCH_ONLY_START"):
        vehicle()
    else:
        main()
