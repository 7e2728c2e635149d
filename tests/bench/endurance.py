"""Memory of the bundled vehicle over a long simulated time, its links talking, faster than real time.

python tests/bench/endurance.py [--hours 24] [--links 2]

It takes off, flies OFFBOARD circles by setpoints at 20 Hz, lands and disarms every ten minutes, on a battery that never
empties. The offboard link sends at PX4's own rates, 400 messages a second; with --links 2 the ground station's too,
which takes half as long again.
"""

from __future__ import annotations

import argparse
import dataclasses
import gc
import math
import sys
import time
from pathlib import Path

from pymavlink.dialects.v20 import common as mavlink

sys.path.insert(0, str(Path(__file__).parents[2]))

from sitl.airframe import load_airframe
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

STEP_US = 50_000
HOUR_US = 3_600_000_000
LAP_US = 600_000_000
PORTRAIT_US = 30_000_000


def rss_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def setpoint(mav: mavlink.MAVLink, now_us: int) -> bytes:
    turn = now_us * 1e-6 * 0.3
    message = mavlink.MAVLink_set_position_target_local_ned_message(
        now_us // 1000 & 0xFFFFFFFF, 1, 1, 1, 0b110111111000,
        10.0 * math.cos(turn), 10.0 * math.sin(turn), -10.0, 0, 0, 0, 0, 0, 0, 0, 0,
    )  # fmt: skip
    return message.pack(mav)


def command(mav: mavlink.MAVLink, number: int, *params: float) -> bytes:
    filled = (*params, *(0.0,) * (7 - len(params)))
    return mavlink.MAVLink_command_long_message(1, 1, number, 0, *filled).pack(mav)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--links", type=int, choices=(1, 2), default=1)
    options = parser.parse_args()
    hours, silent = options.hours, (b"",) * (options.links - 1)
    airframe = load_airframe("x500")
    endless = dataclasses.replace(airframe.battery, capacity_ah=1e6)
    airframe = dataclasses.replace(airframe, battery=endless)
    home = GeoPoint(23.96028, 32.8675, 188.5)
    simulator = Simulator(SimulatorConfig(VehicleConfig(airframe, Params(airframe.params), home)))
    mav = mavlink.MAVLink(None, 245, 191)
    simulator.exchange(PORTRAIT_US, (b"", *silent))
    flights_n = 0
    end_us, lived_us, sent_n, rows = round(hours * HOUR_US), 0, 0, []
    begin_s = time.perf_counter()
    while lived_us < end_us:
        start_us = simulator.time_us
        while simulator.time_us - start_us < LAP_US:
            now_us = simulator.time_us + STEP_US
            age_us = now_us - start_us
            data = setpoint(mav, now_us)
            if age_us == 1_000_000:
                data += command(mav, mavlink.MAV_CMD_DO_SET_MODE, 1, 6)
                data += command(mav, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
            if age_us == LAP_US - 60_000_000:
                data += command(mav, mavlink.MAV_CMD_NAV_LAND)
            if age_us % 1_000_000 == 0:
                data += mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(mav)
            sent_n += sum(map(len, simulator.exchange(now_us, (data, *silent))))
            flights_n += sum(event.kind == "armed" for event in simulator.take_events())
        lived_us += simulator.time_us - start_us
        gc.collect()
        rows.append((lived_us / HOUR_US, rss_mb()))
        if lived_us % HOUR_US < LAP_US:
            spent_s = time.perf_counter() - begin_s
            print(
                f"{rows[-1][0]:5.1f} h   {rows[-1][1]:6.1f} MB   {flights_n:4d} flights   {spent_s:6.0f} s",
                flush=True,
            )
    wall_s = time.perf_counter() - begin_s
    first, last = rows[min(len(rows) - 1, len(rows) // 20)], rows[-1]
    print(f"simulated {lived_us / HOUR_US:.1f} h, {flights_n} flights, in {wall_s:.0f} s: {lived_us / 1e6 / wall_s:.0f} ×; "
          f"{options.links} of 2 links at PX4's own rates, {sent_n / 1e6:.0f} MB of MAVLink")  # fmt: skip
    print(f"resident at {first[0]:5.1f} h   {first[1]:.1f} MB")
    print(
        f"resident at {last[0]:5.1f} h   {last[1]:.1f} MB, at most {max(mb for _, mb in rows):.1f} MB  ≤ 250 MB"
    )
    print(f"growth per simulated hour {1024 * (last[1] - first[1]) / max(1e-9, last[0] - first[0]):.1f} kB")


if __name__ == "__main__":
    main()
