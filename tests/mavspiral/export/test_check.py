"""`check`: QGroundControl's loader rules, what autopilots take, and files that nobody should have to open."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_plans import (
    CAMERA,
    GOOD,
    SPECS,
    STRUCTURE,
    SURVEY,
    TAKEOFF,
    TRANSECTS,
    WAYPOINT,
    changed,
    plan_of,
    simple,
)

from mavspiral.errors import InputError
from mavspiral.export.check import check_document, check_file
from mavspiral.export.check.dialects import COMMANDS, DIALECTS

ROOT = Path(__file__).parents[3]
FIRMWARE = {"px4": 12, "ardupilot": 3}


def test_what_the_ground_station_writes_is_taken():
    verdict = check_document(GOOD)
    assert verdict.summary() == {"ok": True, "autopilot": "px4", "items": 3, "errors": [], "warnings": []}


def test_our_golden_plan_is_taken():
    assert check_file(ROOT / "tests/golden/kiosk.plan").summary()["errors"] == []


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        (changed(fileType="Mission"), "fileType: 'Mission' is not \"Plan\""),
        (changed(fileType=...), "the file: fileType is missing"),
        (changed(version=2), "version: 2 is not 1"),
        (changed(version=True), "the file: version is true, wanted a number"),
        (changed(geoFence=...), "the file: geoFence is missing"),
        (changed(rallyPoints={}), "rallyPoints: version is missing"),
        (changed(mission__firmwareType="px4"), "mission: firmwareType is 'px4', wanted a number"),
        (changed(mission__items={}), "mission: items is an object, wanted an array"),
        (changed(mission__items=[]), "mission.items: is empty"),
        (changed(mission__plannedHomePosition=[47.4, 8.5]), "mission.plannedHomePosition: is not"),
        (changed(mission__items__1=7), "item 2: is 7, wanted an object"),
        (changed(mission__items__1__type="X"), "item 2: type is 'X'"),
        (changed(mission__items__1__params=[0] * 6), "item 2: params has 6 entries, wanted 7"),
        (changed(mission__items__1__params=["a"] * 7), "item 2: an entry of params is neither"),
        (changed(mission__items__1__autoContinue=1), "item 2: autoContinue is 1, wanted true or false"),
        (changed(mission__items__1__Altitude=20), "item 2: Altitude without AltitudeMode"),
        (changed(mission__items__1__command=16.5), "item 2: command is 16.5"),
        (plan_of(TAKEOFF, STRUCTURE | {"version": 2}), "version is 2, the loader takes 3"),
        (plan_of(TAKEOFF, SURVEY | {"complexItemType": "spiral"}), "QGroundControl knows no such pattern"),
        (plan_of(TAKEOFF, {"type": "ComplexItem", "complexItemType": ["survey"]}), "no such pattern"),
        (plan_of(TAKEOFF, WAYPOINT, rally=[[47.4, 8.5]]), "rally point 1: is not"),
        (
            plan_of(WAYPOINT, fence={"version": 2, "polygons": [{"version": 1}], "circles": []}),
            "fence polygon 1: inclusion is missing",
        ),
    ],
)
def test_what_the_loader_refuses(plan, words):
    assert any(words in line for line in check_document(plan).errors), check_document(plan)


@pytest.mark.parametrize(
    ("autopilot", "item", "words"),
    [
        ("px4", simple(82), "PX4 does not take NAV_SPLINE_WAYPOINT"),
        ("px4", simple(115, 90, frame=2), "PX4 does not take CONDITION_YAW"),
        ("px4", simple(178, 1, 5, -1), "PX4 takes DO_CHANGE_SPEED in frame 2 (MISSION) only, not in 3"),
        ("px4", simple(16, frame=2), "NAV_WAYPOINT in a global frame only"),
        ("px4", simple(16, 0, 0, 0, None, 47.4, 8.55, 20, frame=10), "does not know frame 10"),
        ("px4", simple(22), "PX4 refuses a take-off that is not the first"),
        ("px4", simple(177, 9, 1, frame=2), "DO_JUMP to 9, which no item's doJumpId is"),
        ("ardupilot", simple(214, 500, frame=2), "ArduCopter does not take DO_SET_CAM_TRIGG_INTERVAL"),
        ("ardupilot", simple(82, 0, 0, 0, None), "refuses null among the first four parameters"),
        ("ardupilot", simple(16, 0, 0, 0, 0, 97.0, 8.5, 20), "latitude 97"),
    ],
)
def test_what_the_autopilot_refuses(autopilot, item, words):
    verdict = check_document(plan_of(TAKEOFF, item, firmware=FIRMWARE[autopilot]))
    assert any(words in line for line in verdict.errors), verdict
    assert all(line.startswith("item 2: ") for line in verdict.errors)


CIRCLE = {"version": 1, "inclusion": True, "circle": {"center": [47.4, 8.55], "radius": 2000.0}}
SQUARE = [[47.39, 8.54], [47.39, 8.56], [47.41, 8.56], [47.41, 8.54]]


@pytest.mark.parametrize(
    ("plan", "autopilot", "words"),
    [
        (
            plan_of(TAKEOFF, WAYPOINT, fence={"version": 2, "polygons": [], "circles": [CIRCLE] * 65}),
            "px4",
            "geoFence: 65 corners and circles; PX4 holds 64",
        ),
        (
            plan_of(
                TAKEOFF,
                WAYPOINT,
                fence={
                    "version": 2,
                    "polygons": [{"version": 1, "inclusion": True, "polygon": SQUARE}] * 17,
                    "circles": [],
                },
            ),
            "px4",
            "geoFence: 68 corners and circles; PX4 holds 64",
        ),
        (
            plan_of(TAKEOFF, WAYPOINT, rally=[[47.4, 8.55, 30.0]] * 33),
            "px4",
            "rallyPoints: 33 points; PX4 holds 32",
        ),
        (
            plan_of(TAKEOFF, simple(16, 0, 0, 0, None, 47.4001, 8.5501, None)),
            None,
            "NAV_WAYPOINT without a height",
        ),
        (plan_of(simple(178, 1, 5, -1, frame=2)), None, "mission.items: no item has a place to fly to"),
    ],
)
def test_what_there_is_too_much_of_or_too_little(plan, autopilot, words):
    (error,) = check_document(plan, autopilot).errors
    assert words in error


@pytest.mark.parametrize(
    ("plan", "autopilot", "words"),
    [
        (
            plan_of(TAKEOFF, WAYPOINT, simple(178, 1, 0, -1, frame=2)),
            "px4",
            "item 3: DO_CHANGE_SPEED without",
        ),
        (plan_of(WAYPOINT), "px4", "item 1: the mission begins without a take-off"),
        (
            plan_of(TAKEOFF, simple(16, 0, 0, 0, None, 47.4001, 8.5501, -5)),
            "px4",
            "item 2: 5 m below home",
        ),
        (
            plan_of(simple(22, 0, 0, 0, None, 47.4, 8.5635, 20), WAYPOINT),
            "px4",
            "m from home, more than MIS_DIST_1WP = 900 m",
        ),
        (
            plan_of(TAKEOFF, simple(16, 1.5, 0, 0, None), firmware=3),
            "ardupilot",
            "item 2: ArduCopter waits whole seconds only",
        ),
    ],
)
def test_what_the_autopilot_does_otherwise_than_it_reads_is_warned_of(plan, autopilot, words):
    verdict = check_document(plan, autopilot)
    (warning,) = verdict.warnings
    assert verdict.ok and words in warning


def test_the_items_within_a_survey_are_judged_and_counted():
    verdict = check_document(plan_of(TAKEOFF, SURVEY))
    assert verdict.ok
    assert verdict.items == 3
    bad = copy.deepcopy(SURVEY)
    bad["TransectStyleComplexItem"]["Items"][1]["frame"] = 3
    assert (
        "item 2 ('survey').2: PX4 takes DO_SET_CAM_TRIGG_DIST"
        in check_document(plan_of(TAKEOFF, bad)).errors[0]
    )


def test_a_structure_scan_counts_what_the_ground_station_makes_of_it():
    verdict = check_document(plan_of(TAKEOFF, STRUCTURE))
    assert verdict.ok
    assert verdict.items == 1 + (4 + 3) * 3 + 4
    assert "only QGroundControl can fly it" in verdict.warnings[0]
    many = check_document(plan_of(TAKEOFF, STRUCTURE | {"Layers": 100}))
    assert any("705 items: most boards hold 500" in line for line in many.warnings)


@pytest.mark.parametrize("kind", ["survey", "structure"])
@pytest.mark.parametrize(
    ("camera", "words"),
    [
        (CAMERA, None),
        (CAMERA | SPECS, None),
        ({key: value for key, value in CAMERA.items() if key != "DistanceMode"}, "DistanceMode is missing"),
        (CAMERA | {"CameraName": "Sony ILCE-QX1"}, "SensorWidth is missing"),
        (CAMERA | SPECS | {"Landscape": 1}, "Landscape is 1, wanted true or false"),
        (CAMERA | {"AdjustedFootprintSide": None}, "AdjustedFootprintSide is null, wanted a number"),
        (CAMERA | {"version": 3}, "CameraCalc: version is 3, the loader takes 2"),
    ],
)
def test_the_camera_of_a_pattern_is_judged_as_the_loader_does(kind, camera, words):
    item = (
        SURVEY | {"TransectStyleComplexItem": TRANSECTS | {"CameraCalc": camera}}
        if kind == "survey"
        else STRUCTURE | {"CameraCalc": camera}
    )
    errors = check_document(plan_of(TAKEOFF, item)).errors
    assert (errors == ()) if words is None else any(words in line for line in errors), errors


def test_an_old_camera_is_made_anew_and_not_judged():
    verdict = check_document(
        plan_of(TAKEOFF, STRUCTURE | {"CameraCalc": {"DistanceToSurfaceRelative": True}})
    )
    assert verdict.ok and any("CameraCalc: version is 0" in line for line in verdict.warnings)


def test_a_waypoint_outside_its_own_fence():
    corners = [[47.399, 8.549], [47.399, 8.551], [47.401, 8.551], [47.401, 8.549]]
    polygon = {"version": 1, "inclusion": True, "polygon": corners}
    circle = {"version": 1, "inclusion": False, "circle": {"center": [47.4003, 8.5501], "radius": 10.0}}
    out = simple(16, 0, 0, 0, None, 47.402, 8.55, 20)
    fence = {"version": 2, "polygons": [polygon], "circles": [circle]}
    assert check_document(plan_of(TAKEOFF, WAYPOINT, fence=fence)).ok
    (error,) = check_document(plan_of(TAKEOFF, out, fence=fence)).errors
    assert error == "item 2: lies outside the plan's own inclusion fence"
    circle["circle"]["radius"] = 30.0
    (error,) = check_document(plan_of(TAKEOFF, WAYPOINT, fence=fence)).errors
    assert error == "item 1, item 2: lies inside the plan's own exclusion fence"


def test_the_same_fault_in_many_items_is_one_line():
    verdict = check_document(plan_of(TAKEOFF, *[simple(82)] * 20_000))
    assert len(verdict.errors) == 2
    assert verdict.errors[0].startswith("item 2, item 3, item 4 and 19997 more: PX4 does not take")
    assert "20001 items; PX4 holds 10000 at most" in verdict.errors[1]


def test_a_plan_for_another_autopilot_is_refused_as_upload_refuses_it():
    verdict = check_document(changed(mission__items__1__params=[0, 0, 0, 90, 47.4, 8.55, 20]), "ardupilot")
    (error,) = verdict.errors
    assert "made for PX4, not ArduCopter" in error and '[vehicle] autopilot = "ardupilot"' in error
    (warning,) = verdict.warnings
    assert "drops the heading" in warning
    assert check_document(changed(mission__firmwareType=4)).autopilot is None


def _square(south, west, north, east, inclusion=True):
    corners = [[south, west], [south, east], [north, east], [north, west]]
    return {"version": 1, "inclusion": inclusion, "polygon": corners}


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_of_several_areas_to_stay_in_all_must_hold(autopilot):
    both = [_square(47.399, 8.549, 47.401, 8.551), _square(47.3995, 8.5495, 47.40005, 8.5505)]
    fence = {"version": 2, "polygons": both, "circles": []}
    plan = plan_of(TAKEOFF, WAYPOINT, fence=fence, firmware=FIRMWARE[autopilot])
    verdict = check_document(plan)
    assert verdict.errors == ("item 1, item 2: lies outside the plan's own inclusion fence",)
    assert any("2 areas to stay in" in line and "all of them at once" in line for line in verdict.warnings)


def test_px4_holds_no_area_that_home_breaks():
    """As its upload says: "Geofence invalid, doesn't contain Home position". What remains is held."""
    whole, elsewhere = _square(47.399, 8.549, 47.401, 8.551), _square(47.40005, 8.5500, 47.401, 8.551)
    around_home = _square(47.3999, 8.5499, 47.40005, 8.55005, inclusion=False)
    fence = {"version": 2, "polygons": [whole, elsewhere, around_home], "circles": []}
    verdict = check_document(plan_of(TAKEOFF, WAYPOINT, fence=fence))
    assert verdict.ok
    assert [line for line in verdict.warnings if "does not hold" in line] == [
        "fence polygon 2: PX4 does not hold this area: the planned home lies outside it",
        "fence polygon 3: PX4 does not hold this area: the planned home lies inside it",
    ]


def test_the_tables_are_what_the_bundled_vehicle_takes():
    """The vehicle's rules were written apart from ours, from the same autopilot."""
    from sitl.link import plan_items

    assert (
        DIALECTS["px4"].placeless == plan_items._PLACELESS & COMMANDS.keys() == plan_items._PLACELESS - {-1}
    )
    fences = set(plan_items._FENCES_AND_RALLY)
    assert DIALECTS["px4"].placed == set(plan_items._KEPT) - fences
    assert DIALECTS["px4"].fence_max == plan_items.CAPACITY[1]
    assert DIALECTS["px4"].rally_max == plan_items.CAPACITY[2]
    from pymavlink.dialects.v20 import common

    for number, name in COMMANDS.items():
        if number in common.enums["MAV_CMD"]:
            assert common.enums["MAV_CMD"][number].name == f"MAV_CMD_{name}"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no JSON"),
        (json.dumps(GOOD).encode()[:-40], "no JSON"),
        (b'{"version": NaN}', "NaN is no JSON number; write null"),
        (b'{"version": 1e999}', "the number 1e999 is too large"),
        (b'{"version": ' + b"9" * 5000 + b"}", "is too large"),
        (b"[" * 100_000, "no plan (nested too deep)"),
        (b"[]", "no plan (a JSON list, wanted an object)"),
        (b"QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t47.4\t8.5\t500\t1\n", "a mission of text lines (QGC WPL)"),
        (b"\xff\xfe\x00", "no JSON but bytes that are no UTF-8. Fix: give a .plan"),
        (b" " * (8 * 2**20 + 1), "larger than 8 MiB"),
    ],
)
def test_a_file_that_cannot_be_read_is_one_line(tmp_path, content, words):
    path = tmp_path / "x.plan"
    path.write_bytes(content)
    with pytest.raises(InputError) as error:
        check_file(path)
    assert words in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_a_plan_that_is_not_there_is_one_line_with_a_fix(tmp_path):
    with pytest.raises(InputError, match=r"none\.plan: cannot be read \(No such file or directory\)\. Fix: "):
        check_file(tmp_path / "none.plan")


def json_values():
    numbers = st.integers(-(10**19), 10**19) | st.floats(allow_nan=False, allow_infinity=False)
    leaves = st.none() | st.booleans() | numbers | st.text(max_size=8)
    return st.recursive(
        leaves,
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
        max_leaves=8,
    )


def paths(value, way=()):
    yield way
    entries = (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    )
    for key, inner in entries:
        yield from paths(inner, (*way, key))


RICH = plan_of(
    TAKEOFF | {"Altitude": 5, "AltitudeMode": 1, "AMSLAltAboveTerrain": None, "doJumpId": 1},
    simple(177, 1, 2, frame=2),
    SURVEY,
    STRUCTURE,
    fence={
        "version": 2,
        "polygons": [{"version": 1, "inclusion": True, "polygon": [[0, 0], [0, 1], [1, 1]]}],
        "circles": [{"version": 1, "inclusion": False, "circle": {"center": [1, 1], "radius": 3}}],
    },
    rally=[[1, 1, 5]],
)
PLACES = [way for way in paths(RICH) if way]


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(PLACES), json_values()), min_size=1, max_size=3),
    st.sampled_from(["px4", "ardupilot", None]),
)
def test_whatever_stands_anywhere_in_a_plan_gets_a_verdict(changes, autopilot):
    plan = copy.deepcopy(RICH)
    for way, value in changes:
        holder = plan
        try:
            for step in way[:-1]:
                holder = holder[step]
            holder[way[-1]] = value
        except (KeyError, IndexError, TypeError):
            continue
    summary = check_document(plan, autopilot).summary()
    assert all(len(line.splitlines()) == 1 for line in summary["errors"] + summary["warnings"])
    assert len(json.dumps(summary, allow_nan=False)) < 50_000


@pytest.mark.parametrize(("content", "code"), [(GOOD, 0), (plan_of(simple(82)), 1), ("{", 2)])
def test_the_verb_and_its_exit_codes(tmp_path, content, code):
    path = tmp_path / "x.plan"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    answer = subprocess.run(
        [sys.executable, "-m", "mavspiral.cli", "check", str(path), "--json"],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=300,
    )
    assert answer.returncode == code
    if code == 2:
        assert len(answer.stderr.splitlines()) == 1
        assert not answer.stdout
    else:
        assert list(json.loads(answer.stdout)) == ["ok", "autopilot", "items", "errors", "warnings"]
