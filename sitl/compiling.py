"""The vehicle's kernels, compiled ahead of their use by two processes of their own.

Where the cache lacks them numba compiles for a long time, on one core, and keeps more memory than a vehicle needs.
The two halves know nothing of each other: what moves the vehicle, and what its estimator does. The kernel that joins them
comes at the end of the longer one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from sitl.airframe import RECEIVERS, load_airframe
from sitl.autopilot.memory import NOTHING
from sitl.autopilot.pursuit import LIMITS_N, PURSUIT_N, pursue_on, turn_on
from sitl.autopilot.shaping import shape_yaw
from sitl.clock import FRAME_S, FRAME_US
from sitl.estimator.belief import BELIEF_N, believe
from sitl.estimator.ekf import ALIGN_FRAMES, Ekf
from sitl.estimator.fusion import fuse_frame
from sitl.estimator.strapdown import HAS_BARO, HAS_FIX, HAS_MAG, HORIZON_FRAMES, new_nav
from sitl.kernels import is_compiled
from sitl.loop import live
from sitl.params import Params
from sitl.signals import Demand, GeoPoint, vector
from sitl.vehicle import Vehicle, VehicleConfig

__all__ = ["compiled_beside", "work"]

_AIRFRAME = "x500"


@contextmanager
def compiled_beside() -> Iterator[bool]:
    """The block runs while the vehicle's kernels compile; at its end they are in the cache. It is told whether they do.

    A process that fails only leaves its work to the caller. It ends when the block raises, or when our own process
    ends, whatever ends it.
    """
    with ExitStack() as leaving:
        workers = []
        ready = is_compiled(live) and is_compiled(believe) and is_compiled(shape_yaw)
        if _is_python(sys.executable) and not ready:
            workers = [leaving.enter_context(_worker(half)) for half in _HALVES]
        yield bool(workers)
        for worker in workers:
            worker.wait()


@contextmanager
def _worker(half: str) -> Iterator[subprocess.Popen]:
    """A process that compiles that half for as long as its standard input is open; it imports what we would."""
    code = f"import sys; sys.path[:] = {sys.path!r}; from sitl import compiling; compiling.work({half!r})"
    worker = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield worker
    finally:
        worker.kill()
        worker.communicate()


def _is_python(executable: str | None) -> bool:
    """Whether that is an interpreter, and no program which has one inside."""
    return Path(executable or "").name.lower().startswith("python")


def _move() -> None:
    """A frame of a vehicle that stands, and of a target at rest."""
    airframe = load_airframe(_AIRFRAME)
    vehicle = Vehicle(VehicleConfig(airframe, Params(airframe.params), GeoPoint(0.0, 0.0, 0.0)))
    vehicle.advance(FRAME_US, Demand(armed=False, idle=False, setpoint=NOTHING))
    rest, limits = np.zeros(PURSUIT_N), vector(np.ones(LIMITS_N), LIMITS_N)
    pursue_on(rest, limits, False, True, False, FRAME_S)
    turn_on(rest, limits, FRAME_S)
    shape_yaw(0.0, 0.0, 0.0, (1.0, 1.0, 1.0), FRAME_S)


def _believe() -> None:
    """An estimator that aligns itself, fuses every sense, and is asked."""
    airframe = load_airframe(_AIRFRAME)
    ekf = Ekf(
        new_nav(),
        airframe.senses,
        Params(airframe.params),
        receiver=RECEIVERS["rtk"],
        field_ned_gauss=(0.2, 0.0, 0.4),
        origin_offset_ned_m=(0.0, 0.0, 0.0),
        stock=False,
    )
    ekf.nav["imu"][..., 2], ekf.nav["mag"], ekf.nav["has"] = (
        -9.8,
        (0.2, 0.0, 0.4),
        HAS_FIX | HAS_BARO | HAS_MAG,
    )
    for frame in range(HORIZON_FRAMES + 1, HORIZON_FRAMES + ALIGN_FRAMES + 1):
        ekf.nav["frame"] = frame
        ekf.step()
    fuse_frame(*ekf.records, frame + 1, HAS_FIX | HAS_BARO | HAS_MAG)
    believe(ekf.nav, ekf.book, ekf.sheet, ekf.filter.P, np.empty(BELIEF_N))


_HALVES = {"move": _move, "believe": _believe}


def _end_with_the_parent() -> None:
    os.read(0, 1)  # nobody writes: it returns when the pipe is closed
    os._exit(1)


def work(half: str) -> None:
    """Compile that half: what a process of `compiled_beside` does."""
    threading.Thread(target=_end_with_the_parent, daemon=True).start()
    _HALVES[half]()
