"""A vehicle in a process of its own, on ports that nobody else has."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

from sitl.link.endpoint import PortTakenError, listening
from sitl.pytest_plugin.ports import DIALECTS, Dialect, Ports, free_ports

__all__ = ["SitlOptions", "SitlVehicle", "start_vehicle"]

HOME = (23.96028, 32.8675, 188.5, 40.0)
START_LIMIT_S = 600.0  # numba may have to compile first, in every worker at once, on a busy machine
_STOP_LIMIT_S = 10.0
_VEHICLE = """
import os, signal, sys, threading
def end_with_the_tests():
    os.read(0, 1)  # nobody writes: it returns when the pipe is closed, however the tests ended
    os.kill(os.getpid(), signal.SIGTERM)
threading.Thread(target=end_with_the_tests, daemon=True).start()
from sitl.__main__ import main
sys.exit(main())
"""
"""`python -m sitl`, for as long as who started it lives: killed tests leave no vehicle behind that flies for ever."""


@dataclass(frozen=True, slots=True)
class SitlOptions:
    """What the vehicle shall be like; `home` is latitude, longitude, metres above the sea, heading in degrees.

    Without a dialect or an airframe a vehicle is a PX4 x500, and a mission flies with its own.

    Raises:
        ValueError: a dialect that the vehicle does not speak, or a fault that is not in a list.
    """

    dialect: Dialect | None = None
    seed: int = 0
    wind_mps: float = 0.0
    gusts: bool = False
    faults: tuple[str, ...] = ()
    airframe: str | None = None
    speedup: float = 1.0
    camera: bool = False
    home: tuple[float, float, float, float] = HOME

    def __post_init__(self) -> None:
        """Judge what the command line and markers say."""
        if self.dialect not in (None, *DIALECTS):
            raise ValueError(f"dialect {self.dialect!r}: the vehicle speaks {', '.join(DIALECTS)}")
        if isinstance(self.faults, str):
            raise ValueError(f"faults {self.faults!r}: wanted a list of them. Fix: faults=[{self.faults!r}]")

    def arguments(self) -> list[str]:
        """The same as options of `python -m sitl`."""
        words = [
            "--autopilot",
            self.dialect or DIALECTS[0],
            "--seed",
            str(self.seed),
            f"--wind={self.wind_mps}",
        ]
        words += ["--speedup", str(self.speedup), "--home=" + ",".join(map(repr, self.home))]
        words += ["--airframe", self.airframe] if self.airframe else []
        words += ["--gust"] if self.gusts else []
        words += ["--camera"] if self.camera else []
        return words + [word for spec in self.faults for word in ("--fault", spec)]

    def complaint(self) -> str | None:
        """What `python -m sitl` would say is wrong with them."""
        from sitl.airframe import load_airframe
        from sitl.arguments import parser_of_options

        try:
            with contextlib.redirect_stderr(io.StringIO()) as said:
                load_airframe(parser_of_options("").parse_args(self.arguments()).airframe)
        except SystemExit:
            return said.getvalue().strip()
        except (ValueError, KeyError, TypeError) as error:
            return str(error.args[0] if error.args else error)
        return None


@dataclass(frozen=True, slots=True, eq=False)
class SitlVehicle:
    """A running vehicle that is ready to arm, and where to find it.

    `url` is for MAVSDK, `mavutil_url` for pymavlink: UDP ports to listen on where it sends to, or an ArduPilot's TCP
    port to connect to. `gcs_*` are its second link's, UDP in both dialects, as a ground station has it. `lines` is
    what it has printed so far.
    """

    options: SitlOptions
    ports: Ports
    process: subprocess.Popen[str]
    lines: list[str]
    tlog: Path

    @property
    def dialect(self) -> Dialect:
        """Whose behaviour it shows."""
        return self.options.dialect or DIALECTS[0]

    @property
    def seed(self) -> int:
        """Of its senses' noise."""
        return self.options.seed

    @property
    def home(self) -> tuple[float, float, float, float]:
        """Where it stood at first: latitude, longitude, metres above the sea, heading in degrees."""
        return self.options.home

    @property
    def instance(self) -> int:
        """Which of the vehicles on this machine."""
        return self.ports.instance

    @property
    def system_id(self) -> int:
        """Its MAVLink system."""
        return self.ports.instance + 1

    @property
    def port(self) -> int:
        """Where a companion listens, or an ArduPilot's companion connects to."""
        return self.ports.companion

    @property
    def gcs_port(self) -> int:
        """Where a ground station listens."""
        return self.ports.gcs

    @property
    def url(self) -> str:
        """The companion's link as MAVSDK spells it."""
        return self.ports.url

    @property
    def mavutil_url(self) -> str:
        """The companion's link as pymavlink spells it."""
        return self.ports.mavutil_url

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
        if self.process.stdin is not None:
            self.process.stdin.close()


def start_vehicle(options: SitlOptions, tlog: Path) -> SitlVehicle:
    """A vehicle that has just become ready to arm.

    Raises:
        RuntimeError: it did not start; its own words are in the message.
    """
    for ports in free_ports(options.dialect or DIALECTS[0]):
        try:
            with listening(ports.gcs):  # an ArduPilot boots when somebody listens
                vehicle, ready = _launch(options, ports, tlog)
                came = ready.wait(START_LIMIT_S)
        except PortTakenError:
            continue
        if not came:
            vehicle.stop()
            raise RuntimeError(f"not ready within {START_LIMIT_S:.0f} s: {vehicle.lines}")
        waits = next((line for line in vehicle.lines if "not ready to arm" in line), None)
        if waits is not None:
            vehicle.stop()
            faults = ", ".join(options.faults)
            raise RuntimeError(waits.strip() + (f" (faults: {faults})" if faults else ""))
        if vehicle.process.poll() is None:
            return vehicle
        said = "".join(vehicle.lines[-1:])
        if "is taken" not in said:
            raise RuntimeError(said or f"it ended with exit code {vehicle.process.returncode}")
    raise RuntimeError("no free ports for another vehicle")


def _launch(options: SitlOptions, ports: Ports, tlog: Path) -> tuple[SitlVehicle, threading.Event]:
    """The vehicle, and an event that is set when it is ready or has ended."""
    package = str(Path(__file__).parents[2])
    path = os.pathsep.join(filter(None, (package, os.environ.get("PYTHONPATH"))))
    process = subprocess.Popen(
        # -P: a folder of the user's that is called sitl is not ours.
        [
            sys.executable,
            "-P",
            "-c",
            _VEHICLE,
            f"--instance={ports.instance}",
            f"--tlog={tlog}",
            *options.arguments(),
        ],
        env={**os.environ, "PYTHONPATH": path},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    vehicle, ready = SitlVehicle(options, ports, process, [], tlog), threading.Event()

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
