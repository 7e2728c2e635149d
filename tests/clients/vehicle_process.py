"""`python -m sitl` as a user starts it, on ports that nobody else has."""

import random
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

from patience import LIMIT_S, eventually

from sitl.pytest_plugin.ports import free_ports

ROOT = Path(__file__).parents[2]
START_LIMIT_S = 400.0  # numba may have to compile first


@dataclass
class Vehicle:
    """A running vehicle: its process, its instance, and the lines that it has printed."""

    process: subprocess.Popen
    instance: int
    lines: list

    @property
    def system(self):
        return self.instance + 1

    @property
    def offboard_port(self):
        return 14540 + self.instance

    @property
    def gcs_port(self):
        return 14550 + self.instance

    def says(self, words, limit_s=LIMIT_S):
        """Wait for a line with these words: a reader of its own brings them, sooner or later."""
        return eventually(lambda: next((line for line in self.lines if words in line), None), limit_s)


def free_instance():
    """An instance whose ports nobody has; any of them, since another test run looks for one at the same time."""
    return random.choice(list(free_ports("px4"))).instance


def launch(*options):
    """`python -m sitl`, ready to arm. Where somebody was quicker to take its ports, it gets others."""
    while True:
        vehicle, ready = _started(options, free_instance())
        if not ready.wait(START_LIMIT_S):
            vehicle.process.kill()
            raise AssertionError(vehicle.lines)
        if vehicle.process.poll() is None:
            return vehicle
        said = vehicle.process.stderr.read()
        assert "is taken" in said, (said, vehicle.lines)


def _started(options, instance):
    """The vehicle, and an event that is set when it is ready or has ended."""
    process = subprocess.Popen(
        [sys.executable, "-m", "sitl", "--instance", str(instance), *options],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    vehicle = Vehicle(process, instance, [])
    ready = threading.Event()

    def listen():
        for line in process.stdout:
            vehicle.lines.append(line.rstrip())
            if "ready to arm" in line:
                ready.set()
        process.wait()
        ready.set()  # it has ended: no use in waiting

    threading.Thread(target=listen, daemon=True).start()
    return vehicle, ready


def stop(vehicle):
    vehicle.process.send_signal(signal.SIGINT)
    assert vehicle.process.wait(LIMIT_S) == 0, vehicle.process.stderr.read()
