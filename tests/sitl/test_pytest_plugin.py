"""The pytest plugin, as a foreign project in an environment of its own meets it."""

from __future__ import annotations

import re
import shutil
import site
import subprocess
import sys
import sysconfig
import tomllib
import venv
from pathlib import Path

import pytest

from sitl.pytest_plugin.process import SitlOptions, _free_instances

ROOT = Path(__file__).parents[2]

FAILS = """
def test_it_fails(sitl_vehicle, closed_loop):
    closed_loop("hut.toml")
    assert sitl_vehicle.seed == -1
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """A fresh virtual environment with this project and what it needs: the Python to run."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    scripts = "Scripts" if sys.platform == "win32" else "bin"
    python = folder / scripts / Path(sys.executable).name
    ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
    packages = Path(
        subprocess.run([python, "-c", ask], capture_output=True, text=True, check=True).stdout.strip()
    )
    # pip would need a network: what it would install is linked, and the entry points are pyproject's own.
    for package in ("mavspiral", "sitl"):
        (packages / package).symlink_to(ROOT / package)
    (packages / "rest.pth").write_text("\n".join({sysconfig.get_path("purelib"), *site.getsitepackages()}))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    about = packages / f"mavspiral-{project['version']}.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: mavspiral\nVersion: {project['version']}\n"
    )
    entries = project["entry-points"]["pytest11"]
    lines = ["[pytest11]", *(f"{name} = {value}" for name, value in entries.items())]
    (about / "entry_points.txt").write_text("\n".join(lines))
    return python


def run(python, folder, *options):
    return subprocess.run(
        [python, "-m", "pytest", "-p", "no:cacheprovider", *options],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
    )


def test_a_foreign_project_flies_side_by_side_and_a_failed_test_leaves_log_and_figure(environment, tmp_path):
    project = tmp_path / "foreign"
    shutil.copytree(ROOT / "tests/foreign", project, ignore=shutil.ignore_patterns("__pycache__"))
    (project / "test_fails.py").write_text(FAILS)
    done = run(environment, project, "-n", "2", "--sitl-speedup", "8", "--sitl-keep", "kept")
    assert "1 failed, 2 passed" in done.stdout, done.stdout + done.stderr
    assert "test_it_fails" in done.stdout.split("sitl kept")[0]
    kept = dict(re.findall(r"^(tlog|figure): (.+)$", done.stdout.split("sitl kept")[1], re.M))
    assert set(kept) == {"tlog", "figure"}
    folder = project / "kept"
    assert {p.relative_to(folder).parts[0] for p in folder.rglob("*")} == {"test_fails.py-test_it_fails"}
    names = {path.name for path in folder.rglob("*") if path.stat().st_size > 1000}
    assert {"vehicle.tlog", "vehicle.png", "hut.tlog", "hut.flight.png"} <= names
    for path in kept.values():
        assert Path(path).is_relative_to(folder)


def test_a_wrong_wish_is_said_in_one_line(environment, tmp_path):
    tests = "import pytest\n@pytest.mark.sitl({})\ndef test_it(sitl_vehicle): pass\n"
    for wrong, said in (
        ("sped=3", "it takes dialect, seed"),
        ("airframe='zeppelin'", "zeppelin"),
        ("faults=('rain@5s',)", "unknown 'rain'"),
        ("dialect='betaflight'", "the vehicle speaks px4"),
    ):
        (tmp_path / "test_wrong.py").write_text(tests.format(wrong))
        done = run(environment, tmp_path)
        assert "1 error" in done.stdout
        assert said in done.stdout, done.stdout


def test_the_plugin_costs_nothing_to_load(environment):
    code = (
        "import sys, sitl.pytest_plugin\n"
        "print(sorted({'numpy', 'numba', 'pymavlink', 'scipy', 'matplotlib', 'mavspiral'} & set(sys.modules)))"
    )
    done = subprocess.run([environment, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_no_two_instances_share_a_port():
    listens = [{14540 + n, 14550 + n, 14580 + n, 18570 + n} for n in _free_instances()]
    assert len(listens) > 10
    assert all(len(ports) == 4 for ports in listens)
    assert sum(map(len, listens)) == len(set().union(*listens))


def test_options_become_the_vehicles_own():
    options = SitlOptions(seed=3, wind_mps=-2.5, gusts=True, faults=("gps_loss@1s",), airframe="x500")
    from sitl.__main__ import _options

    parsed = _options().parse_args(options.arguments())
    assert (parsed.seed, parsed.gust, parsed.airframe, len(parsed.fault)) == (3, True, "x500", 1)
    assert parsed.wind[1] == pytest.approx(-2.5)
    assert parsed.home[0].lat_deg == options.home[0]
