"""`python -m sitl` as a user starts it, on ports that nobody else has."""

import signal
import socket
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
START_LIMIT_S = 240.0  # numba may have to compile first


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


def is_free(port):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def free_instance():
    """An instance that shares no port with any vehicle at work, nor with 14550, where clients listen."""
    for instance in range(20, 250):
        if all(is_free(base + instance) for base in (14540, 14550, 14580, 18570)):
            return instance
    raise RuntimeError("no free instance")


@pytest.fixture
def start_vehicle():
    started = []

    def start(*options, instance=None):
        instance = free_instance() if instance is None else instance
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

        threading.Thread(target=listen, daemon=True).start()
        started.append(vehicle)
        assert ready.wait(START_LIMIT_S), (vehicle.lines, process.poll())
        return vehicle

    yield start
    for vehicle in started:
        vehicle.process.send_signal(signal.SIGINT)
        assert vehicle.process.wait(10.0) == 0, vehicle.process.stderr.read()
