"""The doors of the house: who may import whom, where sockets and clocks live, where truth may go."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Each line may import the lines below it, never a neighbour on its own line.
MAVSPIRAL = """
__main__
cli
deliver terminal console arguments
closedloop live
logbook handover uploads
show planner
filling
inspection
proof
pieces
tour
brief
export flight
survey
mission
mission_errors
motion
curve
shape
frames files
arrays errors headway
"""
SITL = """
__main__ pytest_plugin
simulator compiling arguments
craft
vehicle
trouble loop
link autopilot estimator physics
copter_types
copter_params
faults params
airframe
status
condition orders
signals geo plans clock
rotation
kernels
"""


def lines(text: str) -> dict[str, int]:
    rows = text.strip().splitlines()
    return {room: len(rows) - number for number, row in enumerate(rows) for room in row.split()}


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def imports(path: Path) -> set[str]:
    """Every module that the file imports, also inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found.add(str(node.module))
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def room(path: Path) -> str:
    return path.relative_to(ROOT).with_suffix("").parts[1]


@pytest.mark.parametrize(("package", "table"), [("mavspiral", MAVSPIRAL), ("sitl", SITL)])
def test_rooms_import_lower_lines_only(package, table):
    level = lines(table)
    for path in modules(package):
        own = room(path)
        if own == "__init__":
            continue
        assert own in level, f"{path} is in no line of the house"
        for name in imports(path):
            parts = name.split(".")
            if parts[0] != package or len(parts) < 2 or parts[1] not in level or parts[1] == own:
                continue
            assert level[parts[1]] < level[own], f"{path} imports {name}, which is not below it"


def test_the_vehicle_does_not_know_the_planner_and_only_the_closed_loop_knows_the_vehicle():
    for path in modules("sitl"):
        # It flies missions for others' tests; `sitl` itself never imports it.
        if room(path) == "pytest_plugin":
            continue
        assert not any(name.split(".")[0] == "mavspiral" for name in imports(path)), path
    for path in modules("mavspiral"):
        if path.name != "closedloop.py":
            assert not any(name.split(".")[0] == "sitl" for name in imports(path)), path


def test_pymavlink_stays_at_the_rim():
    allowed = {
        ROOT / "mavspiral/flight/link.py",
        ROOT / "mavspiral/flight/decoding.py",
        ROOT / "mavspiral/flight/framing.py",
        ROOT / "mavspiral/flight/packing.py",
        ROOT / "mavspiral/flight/log_readers.py",
    }
    for path in [*modules("mavspiral"), *modules("sitl")]:
        if path in allowed or path.is_relative_to(ROOT / "sitl/link"):
            continue
        assert not any(name.split(".")[0] == "pymavlink" for name in imports(path)), path


def test_packages_of_extras_are_imported_by_need_alone():
    extras = {"rasterio", "pyproj", "trimesh", "laspy", "lazrs"}
    for path in [*modules("mavspiral"), *modules("sitl")]:
        assert not {name.split(".")[0] for name in imports(path)} & extras, path


def test_sockets_and_wall_clocks_stay_at_the_rim():
    rim = {
        ROOT / "mavspiral/flight/realtime.py",
        ROOT / "mavspiral/flight/transports.py",
        ROOT / "mavspiral/closedloop.py",
        ROOT / "mavspiral/live.py",
        ROOT / "mavspiral/planner.py",
        ROOT / "sitl/link/endpoint.py",
        ROOT / "sitl/link/realtime.py",
    }
    for path in [*modules("mavspiral"), *modules("sitl")]:
        names = {name.split(".")[0] for name in imports(path)}
        if path not in rim:
            assert not names & {"socket", "select", "selectors", "asyncio", "time", "datetime"}, path
    measuring_only = (
        ast.parse((ROOT / "mavspiral/closedloop.py").read_text()),
        ast.parse((ROOT / "mavspiral/planner.py").read_text()),
    )
    for tree in measuring_only:
        clocks = {
            n.attr
            for n in ast.walk(tree)
            if isinstance(n, ast.Attribute) and isinstance(n.value, ast.Name) and n.value.id == "time"
        }
        assert clocks <= {"perf_counter"}, "the planner and the closed loop only measure how long they took"


def test_truth_does_not_leak_into_the_brain():
    for brain in ("autopilot", "estimator", "link"):
        for path in modules(f"sitl/{brain}"):
            names = {n.id for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Name)}
            assert "TruthState" not in names, path


def test_the_top_level_is_as_agreed():
    known = {
        "pyproject.toml",
        "mavspiral",
        "sitl",
        "missions",
        "tests",
        "README.md",
        "LICENSE",
        "out",
        "dist",
        "build",
    }
    assert {p.name for p in ROOT.iterdir() if not p.name.startswith(".")} <= known
