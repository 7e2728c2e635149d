import shutil
import subprocess
import sys
from pathlib import Path

import sitl.kernels

CALLER = """
from rooms.kernels import is_compiled, kernel
from rooms.callee import answer

@kernel
def ask():
    return answer()

if __name__ == "__main__":
    print(is_compiled(ask))
    print(ask())
    print(len(list(ask.stats.cache_hits)))
"""
CALLEE = """
from rooms.kernels import kernel

@kernel
def answer():
    return {}
"""


def test_a_change_in_another_rooms_callee_is_seen_and_the_same_code_is_not_compiled_again(tmp_path: Path):
    rooms = tmp_path / "rooms"
    rooms.mkdir()
    (rooms / "__init__.py").touch()
    shutil.copy(sitl.kernels.__file__, rooms / "kernels.py")
    (rooms / "caller.py").write_text(CALLER)

    def ask(answer: int) -> list[str]:
        (rooms / "callee.py").write_text(CALLEE.format(answer))
        run = subprocess.run(
            [sys.executable, "-m", "rooms.caller"], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return run.stdout.split()

    assert ask(1) == ["False", "1", "0"]
    assert ask(1) == ["True", "1", "1"]
    assert ask(2) == ["False", "2", "0"]


def test_a_vehicle_flies_without_filterpy_unless_the_stock_filter_is_asked_for():
    code = """
import sys
from sitl.airframe import load_airframe
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig
x500 = load_airframe("x500")
for stock in (False, True):
    vehicle = VehicleConfig(x500, Params(x500.params), GeoPoint(24.0, 33.0, 190.0), stock_filter=stock)
    Simulator(SimulatorConfig(vehicle)).step(2_000_000, b"")
    print(sorted({"filterpy", "scipy.stats"} & set(sys.modules)))
"""
    root = Path(sitl.kernels.__file__).parents[1]
    run = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert run.stdout.splitlines() == ["[]", "['filterpy', 'scipy.stats']"]
