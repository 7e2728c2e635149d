"""The verbs as a user meets them: exit codes, one line for each error, whole files or none."""

from __future__ import annotations

import json
import math
import os
import shlex
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

ROOT = Path(__file__).parents[2]


def run(*args, cwd=ROOT, stdin=subprocess.DEVNULL):
    return subprocess.run(
        [sys.executable, "-m", "mavspiral.cli", *map(str, args)],
        capture_output=True,
        text=True,
        cwd=cwd,
        stdin=stdin,
        timeout=300,
    )


def changed(tmp_path, old, new, mission="kiosk"):
    text = (ROOT / "missions" / f"{mission}.toml").read_text()
    assert old in text
    text = text.replace(old, new).replace("maps/", f"{ROOT}/missions/maps/")
    path = tmp_path / f"{mission}.toml"
    path.write_text(text)
    return path


def test_plan_writes_its_files_and_one_json_object(tmp_path):
    answer = run("plan", "missions/kiosk.toml", "--out", tmp_path / "out", "--json")
    assert answer.returncode == 0, answer.stderr
    summary = json.loads(answer.stdout)
    for kind in ("plan", "waypoints", "csv", "photos", "kml", "geojson", "png", "json"):
        assert Path(summary["files"][kind]).stat().st_size > 100
    assert summary["coverage"]["walls"] == pytest.approx(1.0, abs=0.02)
    assert summary["speed_max_mps"] <= 5.0
    budget = summary["clearance_budget"]
    sigmas = [budget[f"{of}_sigma_m"] for of in ("map", "navigation", "tracking")]
    assert budget["total_m"] == pytest.approx(budget["vehicle_radius_m"] + 3 * math.hypot(*sigmas), abs=0.002)
    assert summary["clearance_required_m"] == budget["required_m"] == max(3.0, budget["total_m"])
    assert json.loads(Path(summary["files"]["json"]).read_text())["rings"] == summary["rings"]
    assert not [path for path in (tmp_path / "out").iterdir() if path.name.startswith(".")]


def test_simulate_passes_and_writes_the_flight(tmp_path):
    answer = run("simulate", "missions/kiosk.toml", "--out", tmp_path, "--json", "--seed", "5")
    assert answer.returncode == 0, answer.stdout + answer.stderr
    summary = json.loads(answer.stdout)
    assert summary["passed"] is True
    assert summary["failures"] == []
    for kind in ("tlog", "npz", "flight_png", "html", "simulate_json"):
        assert Path(summary["files"][kind]).stat().st_size > 100
    page = Path(summary["files"]["html"]).read_text()
    words = "the larger of 3.00 m asked for and 1.42 m = vehicle 0.40 m + 3·√(map 0.30² + navigation 0.05² + tracking 0.15²)"
    assert words in page


def test_an_accept_that_cannot_be_met_exits_1_and_says_what(tmp_path):
    path = changed(tmp_path, "tracking_p95_m = 0.3", "tracking_p95_m = 0.001")
    answer = run("simulate", path, "--out", tmp_path / "out")
    assert answer.returncode == 1
    assert "[accept] tracking_p95_m" in answer.stdout
    assert "wanted at most 0.001" in answer.stdout


def test_a_plan_that_fails_its_limits_exits_1_and_writes_nothing(tmp_path):
    path = changed(tmp_path, "ceiling_m = 60", "ceiling_m = 4")
    answer = run("plan", path, "--out", tmp_path / "out")
    assert answer.returncode == 1
    assert "ceiling_m" in answer.stderr
    assert not (tmp_path / "out").exists()


CRANE = """[[keepout]]
circle = [%s, 2.0]
height_m = [0, %d]
name = "crane"
[accept]"""


@pytest.mark.parametrize(
    ("place", "height_m", "mode", "words"),
    [
        ("23.96058, 32.8675", 20, "paper", "clearance FAILS"),  # the paper's recipe looks at no obstacle
        ("23.960342, 32.8675", 200, "spiral", "no way between home"),
    ],
)
def test_with_json_a_plan_that_fails_is_one_object_that_names_the_obstacle_and_exits_1(
    tmp_path, place, height_m, mode, words
):
    path = changed(tmp_path, "[accept]", CRANE % (place, height_m))
    path.write_text(path.read_text().replace("[inspection]", f'[inspection]\nmode = "{mode}"'))
    answer = run("plan", path, "--out", tmp_path / "out", "--json")
    assert answer.returncode == 1
    summary = json.loads(answer.stdout)
    (failure,) = summary["failures"]
    assert summary["passed"] is False
    assert words in failure
    assert 'keepout "crane" at lat 23.960' in failure
    assert "lon 32.867" in failure
    assert f"{height_m}.0 m high" in failure
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("standoff_m", "stand_off_m", "did you mean standoff_m?"),
        ("maps/kiosk.geojson", "maps/nowhere.geojson", "no such map"),
        ("home = [23.96028, 32.8675]", "home = [23.9605, 32.8675]", "is inside something"),
        ("home = [23.96028, 32.8675]", "home = [23.960445, 32.8675]", "m from the building"),
        ("home = [23.96028, 32.8675]", "home = [32.8675, 23.96028]", "km from the building"),
        ("overlap = 0.25", "overlap = 0.25\nbottom_m = 0", "nearer to the ground"),
        ("overlap = 0.25", "overlap = 0.25\nbottom_m = 90", "above"),
        ("focal_length_mm = 8.8", "focal_length_mm = 999", "min_interval_s"),
        (
            "[accept]",
            "[[keepout]]\ncircle = [32.8, 23.9, 4.0]\nheight_m = [0, 9]\n[accept]",
            "latitude, longitude",
        ),
        (
            "[accept]",
            "[[keepout]]\ncircle = [23.9605, 32.8675, 20]\nheight_m = [0, 9]\n[accept]",
            "whole building",
        ),
        ("home_height_m = -1.5", "home_height_m = 8.0\nradius_m = 0.4", "level at its home"),
        ("speed_mps = 5.0", "speed_mps = 0.001", "at least 0.1"),
        ('gps = "rtk"', 'airframe = "zeppelin"', "must be one of '7inch', 'camera' or 'x500'"),
        ("home_height_m = -1.5", "home_height_m = -400", "must be at least -100"),
        ("home_height_m = -1.5", "home_height_m = 900", "home_height_m is above the map's ground"),
        ("standoff_m = 6.0", "standoff_m = 199", "standoff_m ≤ 18.2"),
        (
            "standoff_m = 6.0\noverlap = 0.25",
            "standoff_m = 199\n[quality]\ngsd_max_mm = 99",
            "Fix: standoff_m ≤ 120,",
        ),
        ("overlap = 0.25", "overlap = 0.25\nbottom_m = 61\ntop_m = 62", "Fix: bottom_m ≤"),
    ],
)
def test_bad_input_exits_2_with_one_line(tmp_path, old, new, words):
    answer = run("simulate", changed(tmp_path, old, new), "--out", tmp_path / "out")
    assert answer.returncode == 2, answer.stdout + answer.stderr
    (line,) = answer.stderr.strip().splitlines()
    assert words in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("plan", "mavspiral plan: missing argument 'MISSION'"),
        ("plan missions/kiosk.toml --bogus", "no such option: --bogus"),
        ("plan missions/kiosk.toml another", "another"),
        ("simulate missions/kiosk.toml --wind abc", "'--wind'"),
        ("simulate missions/kiosk.toml --wind 99", "30"),
        ("fly missions/kiosk.toml", "'--connect'"),
        ("plan missions/kiosk.toml --out ''", "names no folder"),
        ("nosuch", "mavspiral: no such command 'nosuch'"),
    ],
)
def test_a_wrong_command_line_exits_2_with_one_line(line, words):
    answer = run(*shlex.split(line))
    assert answer.returncode == 2
    (told,) = answer.stderr.strip().splitlines()
    assert words in told
    assert "--help" in told
    assert answer.stdout == ""


def test_a_bare_call_shows_the_verbs():
    answer = run()
    assert answer.returncode == 0
    assert all(verb in answer.stdout for verb in ("plan", "simulate", "fly"))


def test_an_autopilot_that_nobody_knows_exits_2_and_names_the_known_ones(tmp_path):
    answer = run("simulate", "missions/kiosk.toml", "--autopilot", "dji", "--out", tmp_path / "out")
    assert answer.returncode == 2, answer.stdout + answer.stderr
    (line,) = answer.stderr.strip().splitlines()
    assert "'dji'" in line
    assert "px4, ardupilot" in line


def test_a_mission_that_the_vehicle_refuses_before_arming_says_why(tmp_path):
    """The bundled PX4 descends at 1.5 m/s at the most (MPC_Z_VEL_MAX_DN)."""
    path = changed(tmp_path, "descent_mps = 1.5", "descent_mps = 4.0", mission="torre")
    answer = run("simulate", path, "--out", tmp_path / "out", "--json")
    assert answer.returncode == 1, answer.stderr
    summary = json.loads(answer.stdout)
    assert any("MPC_Z_VEL_MAX_DN allows 1.50" in failure for failure in summary["failures"])
    assert summary["tracking"]["p95_m"] is None
    assert Path(summary["files"]["html"]).exists()


def test_a_flight_longer_than_the_battery_is_flown_in_sorties(tmp_path):
    path = changed(tmp_path, "endurance_s = 1500", "endurance_s = 300", mission="torre")
    answer = run("plan", path, "--out", tmp_path / "out", "--json")
    assert answer.returncode == 0, answer.stderr
    summary = json.loads(answer.stdout)
    assert summary["sorties"] >= 3
    plans = [kind for kind in summary["files"] if kind.startswith("plan")]
    assert 1 <= len(plans) == summary["missions"] < summary["sorties"], (
        "AUTO is too slow for those at the top"
    )
    assert any("endurance_s = 300" in warning and "no .plan" in warning for warning in summary["warnings"])


def test_a_battery_that_does_not_last_there_and_back_is_refused(tmp_path):
    answer = run("plan", changed(tmp_path, "endurance_s = 1500", "endurance_s = 30", mission="torre"))
    assert answer.returncode == 1
    assert "endurance_s = 30" in answer.stderr and "Fix:" in answer.stderr


def test_a_folder_that_cannot_be_written_is_told_before_the_flight(tmp_path):
    (tmp_path / "out").write_text("")
    url = ("--connect", "udpin://127.0.0.1:14998")
    answer = run("fly", "missions/kiosk.toml", *url, "--yes", "--out", tmp_path / "out")
    assert answer.returncode == 2
    assert "cannot be written" in answer.stderr
    assert "connect" not in answer.stdout


def test_a_file_in_the_way_of_the_folder(tmp_path):
    (tmp_path / "out").write_text("")
    answer = run("plan", "missions/kiosk.toml", "--out", tmp_path / "out")
    assert answer.returncode == 2
    assert "cannot be written" in answer.stderr


def test_fly_without_yes_and_without_a_terminal_does_not_fly(tmp_path):
    answer = run("fly", "missions/kiosk.toml", "--connect", "udpin://127.0.0.1:14999", "--out", tmp_path)
    assert answer.returncode == 2
    assert "--yes" in answer.stderr


def test_fly_to_nobody_exits_3_and_a_bad_or_taken_link_exits_2(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        answer = run(
            "fly", "missions/kiosk.toml", "--connect", f"udpin://127.0.0.1:{port}", "--yes", "--out", tmp_path
        )
        assert answer.returncode == 2
        assert f"{port} is taken" in answer.stderr
    answer = run(
        "fly", "missions/kiosk.toml", "--connect", f"udpin://127.0.0.1:{port}", "--yes", "--out", tmp_path
    )
    assert answer.returncode == 3
    assert "heartbeat" in answer.stdout + answer.stderr
    answer = run("fly", "missions/kiosk.toml", "--connect", "pigeon://roof", "--yes", "--out", tmp_path)
    assert answer.returncode == 2
    assert "pigeon" in answer.stderr


def test_an_upload_to_a_system_that_is_not_there_names_who_is():
    beat = mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3).pack(mavlink.MAVLink(None, 3, 1))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(("127.0.0.1", 0))
        port = vehicle.getsockname()[1]
        verb = subprocess.Popen(
            [sys.executable, "-m", "mavspiral.cli", "upload", "tests/golden/kiosk.plan", "--system", "7",
             "--connect", f"udpout://127.0.0.1:{port}"],
            stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT,
        )  # fmt: skip
        _, ours = vehicle.recvfrom(1000)
        vehicle.sendto(beat, ours)
        stdout, stderr = verb.communicate(timeout=120)
    assert verb.returncode == 3, stderr
    assert "no system 7 within 10 s, but 3. Fix: --system" in stdout + stderr


@pytest.mark.parametrize("number", ["0", "256", "two"])
def test_a_system_that_cannot_be_exits_2(number):
    answer = run(
        "fly", "missions/kiosk.toml", "--connect", "udpin://127.0.0.1:9", "--system", number, "--yes"
    )
    assert answer.returncode == 2 and "--system" in answer.stderr and "Fix:" in answer.stderr


@pytest.mark.parametrize("place", ["nan,nan", "91,0", "1,inf", "roof"])
def test_a_place_to_align_at_that_is_none_exits_2_before_anything_is_planned(tmp_path, place):
    answer = run(
        "fly", "missions/kiosk.toml", "--connect", "udpin://127.0.0.1:9", "--align", place, "--yes",
        "--out", tmp_path,
    )  # fmt: skip
    assert answer.returncode == 2, answer.stdout + answer.stderr
    (line,) = answer.stderr.strip().splitlines()
    assert "--align" in line and place in line and "Fix:" in line
    assert answer.stdout == ""


def test_a_console_that_knows_no_unicode_still_gets_the_table(tmp_path):
    answer = subprocess.run(
        [sys.executable, "-m", "mavspiral.cli", "plan", "missions/kiosk.toml", "--out", str(tmp_path)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        timeout=300,
    )
    assert answer.returncode == 0, answer.stderr
    assert "m/s?" in answer.stdout


def test_ctrl_c_says_so_and_exits_130(tmp_path):
    fifo = tmp_path / "mission.toml"
    os.mkfifo(fifo)  # a file that nobody writes: the verb waits for it
    verb = subprocess.Popen(
        [sys.executable, "-m", "mavspiral.cli", "plan", str(fifo), "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    with fifo.open("w"):  # opens when the verb does
        verb.send_signal(signal.SIGINT)
        out, said = verb.communicate(timeout=300)
    assert (verb.returncode, out, said) == (130, "", "mavspiral: stopped\n")


def test_ctrl_c_while_it_still_loads_says_so_too():
    stop_at_typer = (
        "import os, runpy, signal, sys\n"
        "class Stops:\n"
        "    def find_spec(name, path=None, target=None):\n"
        "        if name == 'typer':\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Stops)\n"
        "sys.argv = ['mavspiral', '--help']\n"
        "runpy.run_module('mavspiral', run_name='__main__')\n"
    )
    answer = subprocess.run([sys.executable, "-c", stop_at_typer], capture_output=True, text=True, cwd=ROOT)
    assert (answer.returncode, answer.stdout, answer.stderr) == (130, "", "mavspiral: stopped\n")


def test_a_lens_that_shows_more_than_the_building_is_told_by_its_name(tmp_path):
    answer = run("plan", changed(tmp_path, "focal_length_mm = 8.8", "focal_length_mm = 0.1"))
    assert answer.returncode == 2
    assert "focal_length_mm" in answer.stderr and "bottom_m =" not in answer.stderr


def test_a_shutter_too_slow_for_any_pace_is_refused_before_anything_is_worked_out(tmp_path):
    path = changed(tmp_path, "exposure_s = 0.00025", "exposure_s = 1.0")
    answer = run("plan", path)
    assert answer.returncode == 2 and len(answer.stderr.strip().splitlines()) == 1
    assert "exposure_s = 1" in answer.stderr and "Fix:" in answer.stderr


def test_a_plan_that_sees_no_wall_is_refused(tmp_path):
    answer = run("plan", changed(tmp_path, "[limits]", "[quality]\nviews_min = 99\n[limits]"))
    assert answer.returncode == 1 and len(answer.stderr.strip().splitlines()) == 1
    assert (
        "no wall is seen" in answer.stderr and "views_min = 99" in answer.stderr and "Fix:" in answer.stderr
    )


def test_a_stand_off_from_which_every_picture_is_too_coarse_is_refused(tmp_path):
    answer = run("plan", changed(tmp_path, "focal_length_mm = 8.8", "focal_length_mm = 2.0"))
    assert answer.returncode == 2 and len(answer.stderr.strip().splitlines()) == 1
    assert "a pixel on the wall is 7.2 mm" in answer.stderr and "Fix: standoff_m ≤ 4.1" in answer.stderr
