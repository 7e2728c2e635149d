"""`python -m sitl --autopilot ardupilot` as a user starts it, on TCP ports that nobody else has."""

import contextlib
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
START_LIMIT_S = 240.0  # numba may have to compile first


def is_free(port, kind):
    with socket.socket(socket.AF_INET, kind) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def free_instance():
    for instance in range(40, 250):
        ports = [port + 10 * instance for port in (5760, 5762, 5763)]
        tcp = all(is_free(port, socket.SOCK_STREAM) for port in ports)
        if tcp and is_free(14550 + 10 * instance, socket.SOCK_DGRAM):
            return instance
    raise RuntimeError("no free instance")


@contextlib.contextmanager
def copter(*options):
    """A running vehicle: its ports are open, and it boots when somebody comes. Gives its first port and its system."""
    instance = free_instance()
    process = subprocess.Popen(
        [sys.executable, "-m", "sitl", "--autopilot", "ardupilot", "--instance", str(instance), *options],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        deadline = time.monotonic() + START_LIMIT_S
        line = process.stdout.readline()
        assert "TCP" in line, (line, process.stderr.read())
        assert time.monotonic() < deadline
        yield 5760 + 10 * instance, instance + 1
    finally:
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20.0)
        assert process.returncode == 0, (out, err)
