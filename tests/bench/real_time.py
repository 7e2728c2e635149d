"""One vehicle at real time with MAVSDK attached: its real-time factor, its share of a core, its memory. One table.

python tests/bench/real_time.py [--minutes 10]

The vehicle hovers in a process of its own and MAVSDK listens to what PX4 sends unasked. Its clock is read off its
messages and compared with this machine's.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(0, str(Path(__file__).parents[1] / "clients"))
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.mavlink_direct import MavlinkDirect
from mavsdk.plugins.telemetry import Telemetry
from vehicle_process import launch, stop

TICKS_HZ = os.sysconf("SC_CLK_TCK")


def cpu_s(pid: int) -> float:
    """Processor time that the process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_HZ


def rss_mb(pid: int) -> float:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * 4096 / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    minutes = parser.parse_args().minutes
    vehicle = launch()
    pid = vehicle.process.pid
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    mavsdk.add_any_connection(f"udpin://127.0.0.1:{vehicle.offboard_port}")
    system = mavsdk.first_autopilot(10.0)
    telemetry, action = Telemetry(system), Action(system)
    clock: list[tuple[float, float]] = []

    def tick(message, _) -> None:
        stamp = float(message.fields_json.partition('"time_boot_ms":')[2].split(",")[0].rstrip("}"))
        clock.append((time.monotonic(), 1e-3 * stamp))

    direct = MavlinkDirect(system)
    direct.subscribe_message("SYSTEM_TIME", tick)
    deadline = time.monotonic() + 60.0
    while not telemetry.health_all_ok() and time.monotonic() < deadline:
        time.sleep(0.1)
    action.arm()
    action.takeoff()
    time.sleep(10.0)
    clock.clear()
    begun_s, begun_cpu_s, loads = time.monotonic(), cpu_s(pid), []
    while time.monotonic() - begun_s < 60.0 * minutes:
        time.sleep(5.0)
        loads.append(os.getloadavg()[0])
    wall_s, used_s = time.monotonic() - begun_s, cpu_s(pid) - begun_cpu_s
    rows = sorted(clock)
    factor = (rows[-1][1] - rows[0][1]) / (rows[-1][0] - rows[0][0])
    print(f"real-time factor      {factor:.4f} over {wall_s:.0f} s                 1.000 ± 0.002")
    print(f"share of a core       {100 * used_s / wall_s:.1f} %                            ≤ 15 %")
    print(f"resident memory       {rss_mb(pid):.0f} MB                            ≤ 250 MB")
    print(f"others on the machine load {statistics.mean(loads):.1f} on {os.cpu_count()} cores")
    print(f"still flying          {telemetry.in_air()}, at {telemetry.position().relative_altitude_m:.2f} m")
    stop(vehicle)


if __name__ == "__main__":
    main()
