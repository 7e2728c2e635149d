"""Plans of others, as QGroundControl writes them today and wrote them once: what `check` says, and what `upload` would send."""

from __future__ import annotations

import re

import pytest
from sample_plans import (
    GOOD,
    HOME,
    RETURN,
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
from mavspiral.export.check import check_document
from mavspiral.flight.mission_messages import MissionKind
from mavspiral.uploads import mission_lists

FIELD = [[47.4, 8.55], [47.401, 8.55], [47.401, 8.552], [47.4, 8.552]]
CAMERA = {
    "AdjustedFootprintFrontal": 25,
    "AdjustedFootprintSide": 25,
    "CameraName": "Sony ILCE-QX1",
    "DistanceMode": 1,
    "DistanceToSurface": 50,
    "FixedOrientation": False,
    "FocalLength": 16,
    "FrontalOverlap": 70,
    "ImageDensity": 1.2,
    "ImageHeight": 3632,
    "ImageWidth": 5456,
    "Landscape": True,
    "MinTriggerInterval": 0,
    "SensorHeight": 15.4,
    "SensorWidth": 23.2,
    "SideOverlap": 70,
    "ValueSetIsDistance": True,
    "version": 2,
}
TRIGGERED = TRANSECTS | {
    "CameraCalc": CAMERA,
    "VisualTransectPoints": FIELD[:2],
    "Items": [WAYPOINT, simple(206, 25, 0, 1, frame=2), WAYPOINT, simple(206, 0, 0, 1, frame=2)],
}


def complex_item(kind, version, **more):
    return {"type": "ComplexItem", "complexItemType": kind, "version": version} | more


SURVEY_5 = SURVEY | {"polygon": FIELD, "entryLocation": 0, "TransectStyleComplexItem": TRIGGERED}
CORRIDOR = complex_item(
    "CorridorScan", 2, CorridorWidth=50, EntryPoint=0, polyline=FIELD[:2], TransectStyleComplexItem=TRIGGERED
)
SURVEY_2 = complex_item(
    "survey", 2, polygon=FIELD, grid={"altitude": 50, "spacing": 30}, cameraTriggerDistance=20
)
SURVEY_3 = complex_item("survey", 3, angle=0, polygon=FIELD, TransectStyleComplexItem=TRIGGERED)
GUIDES_STRUCTURE = complex_item("StructureScan", 2, Altitude=50, Layers=1, StructureHeight=25, polygon=FIELD)
LANDING = complex_item("fwLandingPattern", 2, landCoordinate=[47.4, 8.55, 0], loiterRadius=75)
OLD_MISSION = {"MAV_AUTOPILOT": 3, "complexItems": [], "items": [], "version": "1.0"}
HIGH = simple(16, 0, 0, 0, None, 47.4001, 8.5501, 20) | {
    "Altitude": 65.6,
    "AltitudeMode": 1,
    "AMSLAltAboveTerrain": None,
}


@pytest.mark.parametrize(
    ("plan", "items", "errors", "warnings"),
    [
        (plan_of(TAKEOFF, SURVEY_5, RETURN), 6, [], []),
        (plan_of(TAKEOFF, CORRIDOR, RETURN), 6, [], ["MAVSDK imports surveys of version 5 and no other"]),
        (plan_of(TAKEOFF, SURVEY_2), 1, [], ["a survey of version 2: QGroundControl makes it anew"]),
        (plan_of(TAKEOFF, SURVEY_3), 1, [], ["a survey of version 3: QGroundControl makes it anew"]),
        (plan_of(TAKEOFF, STRUCTURE), 26, [], ["only QGroundControl can fly it, not MAVSDK"]),
        (plan_of(TAKEOFF, GUIDES_STRUCTURE), 1, ["version is 2, the loader takes 3"], []),
        (plan_of(TAKEOFF, WAYPOINT, LANDING), 2, [], ["a landing pattern of fixed wings, not judged"]),
        (OLD_MISSION, 0, ["a mission of an old QGroundControl (.mission), not a plan. Fix: save it"], []),
        ({"fileType": "Mission", "version": 2, "items": []}, 0, ["a mission of an old QGroundControl"], []),
        (changed(mission__hoverSpeed="16.4 ft/s"), 3, ["hoverSpeed: is '16.4 ft/s', wanted a number"], []),
        (
            plan_of(TAKEOFF, HIGH, RETURN),
            3,
            [],
            ["Altitude is 65.6, the height in params 20: readers differ on which of them counts"],
        ),
        (plan_of(TAKEOFF, HIGH | {"AltitudeMode": 3}, RETURN), 3, [], []),  # above terrain: two heights
        (
            plan_of(TAKEOFF, simple(16, 0, 0, 0, None, 8.55, 47.4, 20)),
            2,
            [],
            ["at 8.55, 47.4, 5659 km from the planned home"],
        ),
        (plan_of(TAKEOFF, simple(16, 0, 0, 0, None, 0, 0, 20)), 2, [], ["at 0, 0, 5335 km from"]),
        (plan_of(TAKEOFF, simple(16, 0, 0, 0, 0, 0, 0, 20), firmware=3), 2, [], []),  # where it is then
        (plan_of(TAKEOFF, simple(16, 0, 0, 0, None, None, None, 20)), 2, [], []),
        (GOOD | {"version": "1"}, 3, ["version is '1', wanted a number"], []),
        (GOOD | {"version": 1.0}, 3, [], ["not written as the whole number 1: MAVSDK refuses it"]),
        (GOOD | {"geoFence": {}}, 3, [], ["is empty: MAVSDK wants version, polygons and circles"]),
        (plan_of(TAKEOFF, WAYPOINT, firmware=0), 2, [], ["neither PX4 (12) nor ArduPilot (3)"]),
    ],
)
def test_what_is_said_of_it_and_nothing_else(plan, items, errors, warnings):
    verdict = check_document(plan)
    assert verdict.items == items
    for words, lines in ((errors, verdict.errors), (warnings, verdict.warnings)):
        assert len(words) == len(lines), lines
        for word, line in zip(words, lines, strict=True):
            assert word in line


@pytest.mark.parametrize("pattern", [SURVEY_2, SURVEY_3, STRUCTURE, LANDING])
def test_what_the_ground_station_alone_can_make_items_of_is_not_left_out_of_an_upload_in_silence(pattern):
    with pytest.raises(
        InputError, match=r"^item 2: a pattern that keeps no items .* Fix: upload the plan with"
    ):
        mission_lists(plan_of(TAKEOFF, pattern, RETURN))


@pytest.mark.parametrize(
    ("item", "words"),
    [
        (simple(16, 0, 0, 0, None, 300, 8.5, 20), "300 among params"),
        (simple(2000, 0, 0, 0, 0, 3e9, frame=2), r"3e\+09 among params"),
        (simple(16, 1e300, 0, 0, None), r"1e\+300 among params"),
        (simple(16, 0, 0, 0, None, 47.4, 8.55, -1e300), r"-1e\+300 among params"),
    ],
)
def test_what_mavlink_cannot_carry_is_told_before_it_is_packed(item, words):
    line = rf"item 2: {words} is more than MAVLink carries there"
    assert any(re.search(line, error) for error in check_document(plan_of(TAKEOFF, item)).errors)
    with pytest.raises(InputError, match=line):
        mission_lists(plan_of(TAKEOFF, item))


def test_a_fence_or_rally_point_that_mavlink_cannot_carry_is_told():
    circle = {"version": 1, "inclusion": True, "circle": {"center": [47.4, 8.55], "radius": 1e300}}
    fence = {"version": 2, "polygons": [], "circles": [circle]}
    plan = plan_of(TAKEOFF, fence=fence, rally=[[47.4, 8.55, 1e300]])
    assert len(check_document(plan).errors) == 2


def test_a_fraction_that_is_lost_on_the_way_is_warned_of():
    (warning,) = check_document(plan_of(TAKEOFF, simple(205, -20, 0, 0, 0, 4.5, 0, 2, frame=2))).warnings
    assert warning == "item 2: MAVLink carries the fifth and sixth parameter in frame 2 as whole numbers"


@pytest.mark.parametrize("pattern", [SURVEY_5, CORRIDOR])
def test_patterns_that_carry_their_items_are_uploaded_whole(pattern):
    lists = mission_lists(plan_of(TAKEOFF, pattern, RETURN))
    assert [item.command for item in lists[MissionKind.MISSION]] == [22, 16, 206, 16, 206, 20]
    ardupilot = mission_lists(plan_of(TAKEOFF, pattern, RETURN, firmware=3))[MissionKind.MISSION]
    assert [item.command for item in ardupilot] == [16, 22, 16, 206, 16, 206, 20]
    assert ardupilot[0].z == HOME[2]
