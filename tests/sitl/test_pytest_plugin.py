"""The pytest plugin, as a foreign project in an environment of its own meets it."""

from __future__ import annotations

import re
import shutil
import site
import subprocess
import sys
import sysconfig
import time
import tomllib
import venv
from pathlib import Path

import pytest

from sitl.link.endpoint import is_free
from sitl.pytest_plugin.ports import free_ports, ports_of
from sitl.pytest_plugin.process import SitlOptions, start_vehicle

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
        timeout=500,
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
        ("faults='gps_loss@5s'", "wanted a list of them. Fix: faults=['gps_loss@5s']"),
        ("dialect='betaflight'", "the vehicle speaks px4, ardupilot"),
    ):
        (tmp_path / "test_wrong.py").write_text(tests.format(wrong))
        done = run(environment, tmp_path)
        assert "1 error" in done.stdout
        assert said in done.stdout, done.stdout
        assert "During handling" not in done.stdout
    (tmp_path / "test_wrong.py").write_text(tests.format(""))
    done = run(environment, tmp_path, "--sitl-dialect=ardupilot", "--sitl-camera")
    assert "--camera is a PX4's component" in done.stdout, done.stdout


def test_a_wrong_wish_of_a_closed_loop_is_said_in_one_line_and_without_our_own_frames(environment, tmp_path):
    shutil.copytree(
        ROOT / "tests/foreign", tmp_path, ignore=shutil.ignore_patterns("test_*"), dirs_exist_ok=True
    )
    test = "def test_{}(closed_loop):\n    closed_loop({})\n"
    wrong = (
        ("'hut.toml', seed=-3", "'-3': wanted an integer from 0"),
        ("'hut.toml', airframe='zeppelin'", "no airframe 'zeppelin'"),
        ("'hut.toml', faults=['rain@5s']", "unknown 'rain'"),
        ("'hut.toml', faults='gps_loss@5s'", "wanted a list of them"),
        ("'hut.toml', wind_mps=float('nan')", "argument --wind: 'nan'"),
        ("'hut.toml', speedup=3", "closed_loop(speedup): it takes dialect, seed"),
        ("'nowhere.toml'", "no such mission file"),
    )
    lines = [test.format(number, call) for number, (call, _) in enumerate(wrong)]
    (tmp_path / "test_wrong.py").write_text("\n".join(lines))
    done = run(environment, tmp_path)
    assert f"{len(wrong)} failed" in done.stdout, done.stdout
    for _, said in wrong:
        assert said in done.stdout, done.stdout
    assert "pytest_plugin" not in done.stdout and "closedloop.py" not in done.stdout, done.stdout


ARDUCOPTER = """
import pytest
from pymavlink import mavutil

CONTROL = mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM


def test_it_arms_in_guided_at_once(sitl_vehicle):
    assert sitl_vehicle.mavutil_url == f"tcp:127.0.0.1:{sitl_vehicle.port}"
    link = mavutil.mavlink_connection(sitl_vehicle.mavutil_url, dialect="ardupilotmega")
    assert link.wait_heartbeat(timeout=90).autopilot == mavutil.mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    assert link.target_system == sitl_vehicle.system_id
    link.set_mode("GUIDED")
    link.mav.command_long_send(link.target_system, 1, CONTROL, 0, 1, 0, 0, 0, 0, 0, 0)
    while (ack := link.recv_match(type="COMMAND_ACK", blocking=True, timeout=90)).command != CONTROL:
        pass
    assert ack.result == 0
    link.close()


def test_mavsdk_finds_it_and_so_does_a_ground_station(sitl_vehicle):
    from mavsdk import Configuration, Mavsdk
    from mavsdk.component_type import ComponentType

    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    mavsdk.add_any_connection(sitl_vehicle.url)
    assert mavsdk.first_autopilot(90.0).get_system_id() == sitl_vehicle.system_id
    mavsdk.destroy()
    link = mavutil.mavlink_connection(sitl_vehicle.gcs_mavutil_url)
    assert link.wait_heartbeat(timeout=90).get_srcSystem() == sitl_vehicle.system_id


@pytest.mark.sitl(dialect="px4", camera=True)
def test_the_marker_goes_first(sitl_vehicle):
    link = mavutil.mavlink_connection(sitl_vehicle.mavutil_url)
    kinds = {link.recv_match(type="HEARTBEAT", blocking=True, timeout=90).type for _ in range(20)}
    assert kinds == {mavutil.mavlink.MAV_TYPE_QUADROTOR, mavutil.mavlink.MAV_TYPE_CAMERA}


def test_a_mission_is_flown_in_it(closed_loop):
    flight = closed_loop("hut.toml")
    assert flight.summary()["autopilot"] == "ardupilot"
    assert flight.passed, flight.failures
"""


def test_the_same_project_flies_an_arducopter(environment, tmp_path):
    project = tmp_path / "foreign"
    shutil.copytree(ROOT / "tests/foreign", project, ignore=shutil.ignore_patterns("__pycache__", "test_*"))
    (project / "test_arducopter.py").write_text(ARDUCOPTER)
    done = run(environment, project, *("--sitl-dialect", "ardupilot", "--sitl-speedup", "20"))
    assert "4 passed" in done.stdout, done.stdout + done.stderr


DIES = """
def test_it_dies(sitl_vehicle):
    sitl_vehicle.process.kill()
    assert sitl_vehicle.process.wait() == 0
"""


WAITS = """
import time
def test_it_waits(sitl_vehicle):
    open("instance", "w").write(f"{sitl_vehicle.instance}\\n")
    time.sleep(600.0)
"""


def test_killed_tests_leave_no_vehicle_behind(environment, tmp_path):
    (tmp_path / "test_waits.py").write_text(WAITS)
    tests = subprocess.Popen([environment, "-m", "pytest", "-p", "no:cacheprovider"], cwd=tmp_path)
    told, deadline = tmp_path / "instance", time.monotonic() + 400.0
    while not (told.exists() and told.read_text().endswith("\n")):
        assert tests.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    tests.kill()
    tests.wait()
    port = 14580 + int(told.read_text())
    while not is_free(port):
        assert time.monotonic() < deadline, "it flies on"
        time.sleep(0.05)


def test_that_the_vehicle_had_died_is_said(environment, tmp_path):
    (tmp_path / "test_dies.py").write_text(DIES)
    done = run(environment, tmp_path)
    assert "process: it had ended by itself, with exit code -9" in done.stdout, done.stdout


def test_the_plugin_costs_nothing_to_load(environment):
    code = (
        "import sys, sitl.pytest_plugin\n"
        "print(sorted({'numpy', 'numba', 'pymavlink', 'scipy', 'matplotlib', 'mavspiral'} & set(sys.modules)))"
    )
    done = subprocess.run([environment, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_no_two_instances_of_either_dialect_share_a_port():
    free = [ports for dialect in ("px4", "ardupilot") for ports in free_ports(dialect)]
    assert len(free) > 100
    udp, tcp = [{port for ports in free for port in getattr(ports, kind)} for kind in ("udp", "tcp")]
    assert len(udp) == sum(len(ports.udp) for ports in free)
    assert len(tcp) == sum(len(ports.tcp) for ports in free)
    assert not {14540, 14550, 14580, 18570} & udp
    assert not {5760, 5762, 5763} & tcp


def test_where_a_client_finds_each_dialect():
    px4, ardupilot = ports_of("px4", 20), ports_of("ardupilot", 40)
    assert (px4.url, px4.mavutil_url) == ("udpin://127.0.0.1:14560", "udpin:127.0.0.1:14560")
    assert (ardupilot.url, ardupilot.mavutil_url) == ("tcpout://127.0.0.1:6160", "tcp:127.0.0.1:6160")
    assert (px4.gcs, ardupilot.gcs) == (14570, 14950)


def test_options_become_the_vehicles_own():
    options = SitlOptions(seed=3, wind_mps=-2.5, gusts=True, faults=("gps_loss@1s",), airframe="x500")
    from sitl.arguments import parser_of_options

    parsed = parser_of_options("").parse_args(options.arguments())
    assert (parsed.seed, parsed.gust, parsed.airframe, len(parsed.fault)) == (3, True, "x500", 1)
    assert parsed.wind[1] == pytest.approx(-2.5)
    assert not parsed.camera
    assert parser_of_options("").parse_args(SitlOptions(camera=True).arguments()).camera
    assert parsed.home[0].lat_deg == options.home[0]


def test_a_vehicle_that_never_gets_ready_says_what_it_waits_for(tmp_path):
    options = SitlOptions(faults=("gps_loss@0.1s",), speedup=20.0)
    with pytest.raises(
        RuntimeError, match=r"not ready to arm: it waits for a GPS fix \(faults: gps_loss@0.1s\)"
    ):
        start_vehicle(options, tmp_path / "vehicle.tlog")
