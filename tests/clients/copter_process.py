"""`python -m sitl --autopilot ardupilot` as a user starts it, on TCP ports that nobody else has."""

import contextlib
import random
import signal
import subprocess
import sys
from pathlib import Path

from patience import LIMIT_S

from sitl.pytest_plugin.ports import free_ports

ROOT = Path(__file__).parents[2]


def _started(options):
    """A vehicle whose ports are open, and those ports. Where somebody was quicker to take them, it gets others."""
    while True:
        ports = random.choice(list(free_ports("ardupilot")))
        chosen = ("--autopilot", "ardupilot", "--instance", str(ports.instance))
        process = subprocess.Popen(
            [sys.executable, "-m", "sitl", *chosen, *options],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        if any("TCP" in line for line in process.stdout):  # it may compile first, and says so
            return process, ports
        said = process.communicate()[1]
        assert "is taken" in said, said


@contextlib.contextmanager
def copter(*options):
    """A running vehicle: its ports are open, and it boots when somebody comes. Gives its first port and its system."""
    process, ports = _started(options)
    try:
        yield ports.companion, ports.instance + 1
    finally:
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=LIMIT_S)
        assert process.returncode == 0, (out, err)
