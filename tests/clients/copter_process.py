"""`python -m sitl --autopilot ardupilot` as a user starts it, on TCP ports that nobody else has."""

import contextlib
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from sitl.pytest_plugin.ports import free_ports

ROOT = Path(__file__).parents[2]
START_LIMIT_S = 240.0  # numba may have to compile first


@contextlib.contextmanager
def copter(*options):
    """A running vehicle: its ports are open, and it boots when somebody comes. Gives its first port and its system."""
    ports = random.choice(list(free_ports("ardupilot")))  # another test run looks for some at the same time
    chosen = ("--autopilot", "ardupilot", "--instance", str(ports.instance))
    process = subprocess.Popen(
        [sys.executable, "-m", "sitl", *chosen, *options],
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
        yield ports.companion, ports.instance + 1
    finally:
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20.0)
        assert process.returncode == 0, (out, err)
