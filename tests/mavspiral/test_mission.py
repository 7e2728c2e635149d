"""The mission file: every bad value is one line that names key, value, limit and fix."""

from __future__ import annotations

from importlib import resources
from typing import get_args

import pytest

from mavspiral.errors import InputError
from mavspiral.mission import Vehicle, load_mission

GOOD = """
schema = 1
name = "t"
[building]
map = "map.geojson"
[camera]
focal_length_mm = 8.8
sensor_mm = [13.2, 8.8]
[inspection]
standoff_m = 12.0
"""

BAD = [
    (
        "focal_length_mm = 8.8",
        'focal_length_mm = 8.8\nfirst_photo = "my first, DSC1.JPG"',
        ['[camera] first_photo: "my first, DSC1.JPG"', "number at the end", "Fix", "DJI_0001.JPG"],
    ),
    ("focal_length_mm = 8.8", 'focal_length_mm = 8.8\nfirst_photo = "DSC.JP2"', ["number at the end"]),
    ("standoff_m = 12.0", "standoff_m = -3", ["[inspection] standoff_m = -3", "greater than 0", "Fix"]),
    ("standoff_m = 12.0", "standoff_m = nan", ["standoff_m = nan", "finite"]),
    ("standoff_m = 12.0", 'standoff_m = "12"', ['standoff_m = "12"', "must be a number"]),
    ("standoff_m = 12.0", "standoff_m = 3.0", ["standoff_m = 3", "clearance_m = 4"]),
    ("standoff_m = 12.0", "stand_off_m = 12.0", ["stand_off_m: unknown key", "did you mean standoff_m?"]),
    (
        "standoff_m = 12.0",
        'standoff_m = 12.0\n[vehicle]\nairframe = "nope"',
        ['[vehicle] airframe = "nope"', "'7inch', 'camera' or 'x500'", 'Fix: e.g. airframe = "x500"'],
    ),
    ("standoff_m = 12.0", "", ["standoff_m is missing", "standoff_m = 12.0"]),
    ("standoff_m = 12.0", "standoff_m = 12.0\noverlap = 25", ["overlap = 25", "smaller than 0.95"]),
    ("standoff_m = 12.0", "standoff_m = 12.0\nbottom_m = 9\ntop_m = 5", ["bottom_m = 9", "top_m = 5"]),
    ("standoff_m = 12.0", "standoff_m = 12.0\nroof = 1", ["roof = 1", "true or false"]),
    ("[camera]", 'units = "cm"\n[camera]', ['units = "cm"', "'m', 'mm' or 'ft'"]),
    ("[camera]", 'up = "x"\n[camera]', ['up = "x"', "'z' or 'y'"]),
    ("[camera]", "heading_deg = 400\n[camera]", ["heading_deg = 400", "at most 360"]),
    ("schema = 1", "schema = 2", ["schema = 2", "must be one of 1"]),
    ("schema = 1", "", ["schema is missing"]),
    ('name = "t"', 'name = "../t"', ['name = "../t"']),
    ("[13.2, 8.8]", "[13.2]", ["[camera] sensor_mm", "too few"]),
    (
        "[inspection]",
        '[vehicle]\nautopilot = "dji"\n[inspection]',
        ['autopilot = "dji"', "'px4' or 'ardupilot'"],
    ),
    ("[inspection]", "[vehicle]\nhome = [-99.1, 19.4]\n[inspection]", ["home", "-99.1", "at least -90"]),
    ("[inspection]", "[accept]\ncoverage = 98\n[inspection]", ["[accept] coverage = 98", "at most 1"]),
    ("[inspection]", "[[keepout]]\nheight_m = [0, 8]\n[inspection]", ["keepout", "circle", "polygon"]),
    ("[inspection]", "[[keepout]]\ncircle = [1, 2, 3]\nheight_m = [9, 8]\n[inspection]", ["must rise"]),
    ("schema = 1", "schema = ", ["not TOML", "line 2"]),
]


def write(tmp_path, text):
    path = tmp_path / "mission.toml"
    path.write_text(text)
    return path


def test_defaults_and_map_path(tmp_path):
    mission = load_mission(write(tmp_path, GOOD))
    assert mission.map_path == tmp_path / "map.geojson"
    assert mission.dtm_path is None
    assert mission.limits.clearance_m == 4.0
    assert mission.vehicle.autopilot == "px4"
    assert mission.notices == ()


@pytest.mark.parametrize(("old", "new", "words"), BAD)
def test_bad_input_is_one_clear_line(tmp_path, old, new, words):
    with pytest.raises(InputError) as caught:
        load_mission(write(tmp_path, GOOD.replace(old, new)))
    line = str(caught.value)
    assert "\n" not in line
    assert "mission.toml" in line
    for word in words:
        assert word in line, line
    assert caught.value.exit_code == 2


def test_a_link_to_a_mission_finds_its_maps(tmp_path):
    """Beside the link, as any file that it names; else beside the mission that it points to."""
    real, linked = tmp_path / "real", tmp_path / "linked"
    real.mkdir(), linked.mkdir()
    (real / "t.toml").write_text(GOOD)
    (real / "map.geojson").write_text("{}")
    (linked / "t.toml").symlink_to(real / "t.toml")
    assert load_mission(linked / "t.toml").map_path == real / "map.geojson"
    (linked / "map.geojson").write_text("{}")
    assert load_mission(linked / "t.toml").map_path == linked / "map.geojson"
    (real / "map.geojson").unlink(), (linked / "map.geojson").unlink()
    assert load_mission(linked / "t.toml").map_path == linked / "map.geojson"


def test_the_airframes_of_a_mission_are_the_bundled_vehicle_s():
    known = {file.name.removesuffix(".toml") for file in (resources.files("sitl") / "airframes").iterdir()}
    assert known == set(get_args(Vehicle.model_fields["airframe"].annotation))


def test_a_missing_file_and_a_folder(tmp_path):
    for path in (tmp_path / "nothing.toml", tmp_path):
        with pytest.raises(InputError, match="Fix"):
            load_mission(path)


def test_what_is_asked_and_not_done_is_said(tmp_path):
    mission = load_mission(write(tmp_path, GOOD.replace("standoff_m", "roof = true\nstandoff_m")))
    assert any("roof" in notice for notice in mission.notices)


def test_a_cell_size_beside_an_npz_map_is_said_to_mean_nothing(tmp_path):
    text = GOOD.replace('map = "map.geojson"', 'map = "map.npz"\ncell_m = 0.5')
    (notice,) = load_mission(write(tmp_path, text)).notices
    assert "cell_m = 0.5 means nothing to a .npz map" in notice
    assert load_mission(write(tmp_path, text.replace("cell_m = 0.5", ""))).notices == ()
