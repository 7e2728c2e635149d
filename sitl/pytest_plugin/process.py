"""A vehicle in a process of its own, on ports that nobody else has."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sitl.link.endpoint import GCS_PORTS, OFFBOARD_PORTS, is_free

__all__ = ["SitlOptions", "SitlVehicle", "start_vehicle"]

DIALECTS = ("px4",)
HOME = (23.96028, 32.8675, 188.5, 40.0)
START_LIMIT_S = 240.0  # numba may have to compile first
_STOP_LIMIT_S = 10.0
# PX4's ports lie 10, 30 and 40 apart: within a block of ten and blocks of fifty no two vehicles share one.
_INSTANCES = tuple(block + i for block in (20, 70, 120, 170, 220) for i in range(10))
_WORKERS_APART = 7


@dataclass(frozen=True, slots=True)
class SitlOptions:
    """What the vehicle shall be like; `home` is latitude, longitude, metres above the sea, heading in degrees."""

    dialect: str = "px4"
    seed: int = 0
    wind_mps: float = 0.0
    gusts: bool = False
    faults: tuple[str, ...] = ()
    airframe: str | None = None
    speedup: float = 1.0
    camera: bool = False
    home: tuple[float, float, float, float] = HOME

    def arguments(self) -> list[str]:
        """The same as options of `python -m sitl`."""
        words = ["--autopilot", self.dialect, "--seed", str(self.seed), f"--wind={self.wind_mps}"]
        words += ["--speedup", str(self.speedup), "--home=" + ",".join(map(repr, self.home))]
        words += ["--airframe", self.airframe] if self.airframe else []
        words += ["--gust"] if self.gusts else []
        words += ["--camera"] if self.camera else []
        return words + [word for spec in self.faults for word in ("--fault", spec)]


@dataclass(frozen=True, slots=True, eq=False)
class SitlVehicle:
    """A running vehicle that is ready to arm, and where to find it.

    `url` is for MAVSDK, `mavutil_url` for pymavlink; both listen on `port`, where the vehicle sends to. `gcs_*`
    are its second link's, as a ground station has it. `lines` is what it has printed so far.
    """

    options: SitlOptions
    instance: int
    process: subprocess.Popen[str]
    lines: list[str]
    tlog: Path

    @property
    def dialect(self) -> str:
        """Whose behaviour it shows."""
        return self.options.dialect

    @property
    def seed(self) -> int:
        """Of its senses' noise."""
        return self.options.seed

    @property
    def home(self) -> tuple[float, float, float, float]:
        """Where it stood at first: latitude, longitude, metres above the sea, heading in degrees."""
        return self.options.home

    @property
    def system_id(self) -> int:
        """Its MAVLink system."""
        return self.instance + 1

    @property
    def port(self) -> int:
        """Where a companion listens."""
        return OFFBOARD_PORTS[1] + self.instance

    @property
    def gcs_port(self) -> int:
        """Where a ground station listens."""
        return GCS_PORTS[1] + self.instance

    @property
    def url(self) -> str:
        """The companion's link as MAVSDK spells it."""
        return f"udpin://127.0.0.1:{self.port}"

    @property
    def mavutil_url(self) -> str:
        """The companion's link as pymavlink spells it."""
        return f"udpin:127.0.0.1:{self.port}"

    @property
    def gcs_url(self) -> str:
        """The ground station's link as MAVSDK spells it."""
        return f"udpin://127.0.0.1:{self.gcs_port}"

    @property
    def gcs_mavutil_url(self) -> str:
        """The ground station's link as pymavlink spells it."""
        return f"udpin:127.0.0.1:{self.gcs_port}"

    def stop(self) -> None:
        """End it, politely first."""
        if self.process.poll() is None:
            self.process.terminate()
        try:
            self.process.wait(_STOP_LIMIT_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def start_vehicle(options: SitlOptions, tlog: Path) -> SitlVehicle:
    """A vehicle that has just become ready to arm.

    Raises:
        ValueError: a dialect that the vehicle does not speak.
        RuntimeError: it did not start; its own words are in the message.
    """
    if options.dialect not in DIALECTS:
        raise ValueError(f"dialect {options.dialect!r}: the vehicle speaks {', '.join(DIALECTS)}")
    for instance in _free_instances():
        vehicle, ready = _launch(options, instance, tlog)
        if not ready.wait(START_LIMIT_S):
            vehicle.stop()
            raise RuntimeError(f"not ready within {START_LIMIT_S:.0f} s: {vehicle.lines}")
        if vehicle.process.poll() is None:
            return vehicle
        said = "".join(vehicle.lines[-1:])
        if "is taken" not in said:
            raise RuntimeError(said or f"it ended with exit code {vehicle.process.returncode}")
    raise RuntimeError("no free ports for another vehicle")


def _free_instances() -> Iterator[int]:
    """Instances whose ports are free, each xdist worker beginning elsewhere."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    first = _WORKERS_APART * int(worker) if worker.isdecimal() else 0
    for i in range(len(_INSTANCES)):
        instance = _INSTANCES[(first + i) % len(_INSTANCES)]
        if all(is_free(port + instance) for port in (*OFFBOARD_PORTS, *GCS_PORTS)):
            yield instance


def _launch(options: SitlOptions, instance: int, tlog: Path) -> tuple[SitlVehicle, threading.Event]:
    """The vehicle, and an event that is set when it is ready or has ended."""
    package = str(Path(__file__).parents[2])
    path = os.pathsep.join(filter(None, (package, os.environ.get("PYTHONPATH"))))
    process = subprocess.Popen(
        # -P: a folder of the user's that is called sitl is not ours.
        [
            sys.executable,
            "-P",
            "-m",
            "sitl",
            f"--instance={instance}",
            f"--tlog={tlog}",
            *options.arguments(),
        ],
        env={**os.environ, "PYTHONPATH": path},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    vehicle, ready = SitlVehicle(options, instance, process, [], tlog), threading.Event()

    def listen() -> None:
        assert process.stdout is not None
        for line in process.stdout:
            vehicle.lines.append(line.rstrip())
            if "ready to arm" in line:
                ready.set()
        process.stdout.close()
        process.wait()
        ready.set()

    threading.Thread(target=listen, daemon=True).start()
    return vehicle, ready
