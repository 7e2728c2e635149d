import os
import subprocess
import sys
from pathlib import Path

import pytest

from sitl import compiling

ROOT = Path(compiling.__file__).parents[1]
FLIGHT = """
from numba.core import event
from sitl.airframe import load_airframe
from sitl.compiling import compiled_beside
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

class Compilations(event.Listener):
    names = []

    def on_start(self, event):
        self.names.append(event.data["dispatcher"].__name__)

    def on_end(self, event):
        pass

event.register("numba:compile", Compilations())
with compiled_beside():
    pass
x500 = load_airframe("x500")
simulator = Simulator(SimulatorConfig(VehicleConfig(x500, Params(x500.params), GeoPoint(24.0, 33.0, 190.0))))
simulator.step(3_000_000, b"")
assert simulator.report.flight.ready
print(Compilations.names)
"""


def test_with_an_empty_cache_a_vehicle_gets_ready_without_compiling_anything_itself(tmp_path):
    run = subprocess.run(
        [sys.executable, "-c", FLIGHT],
        cwd=ROOT,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout == "[]\n"


@pytest.fixture
def empty_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))


def test_a_worker_ends_when_the_block_raises(empty_cache):
    with pytest.raises(KeyboardInterrupt), compiling._worker("move") as worker:
        assert worker.poll() is None
        raise KeyboardInterrupt
    assert worker.returncode is not None


def test_a_worker_ends_when_nobody_holds_its_standard_input_any_more(empty_cache):
    with compiling._worker("move") as worker:
        worker.stdin.close()
        assert worker.wait(timeout=300) == 1
        worker.stdin = None  # `communicate` would flush it


def test_no_process_is_started_where_the_cache_is_full_or_the_program_is_no_interpreter(monkeypatch):
    def started(half):
        raise AssertionError(half)

    monkeypatch.setattr(compiling, "_worker", started)
    monkeypatch.setattr(compiling, "is_compiled", lambda _: False)
    with pytest.raises(AssertionError, match="move"), compiling.compiled_beside():
        pass
    monkeypatch.setattr(compiling.sys, "executable", "/opt/qgis/bin/qgis")
    with compiling.compiled_beside():
        pass
    monkeypatch.undo()
    monkeypatch.setattr(compiling, "_worker", started)
    monkeypatch.setattr(compiling, "is_compiled", lambda _: True)
    with compiling.compiled_beside():
        pass
