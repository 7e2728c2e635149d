"""The `.plan`: QGroundControl's loader rules, and that its numbers are the trajectory's."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavwp

from mavspiral.errors import LimitError
from mavspiral.export.items import mission_items
from mavspiral.export.plan_file import fence_enu_m, plan_document
from mavspiral.export.thinning import thin
from mavspiral.export.waypoints import waypoints_text
from mavspiral.frames import wrap_rad, yaw_enu_to_ned

GOLDEN = Path(__file__).parents[2] / "golden"


def made(inspection, autopilot="px4", items_max=500):
    frame = inspection.site.heights.frame
    return mission_items(
        inspection.trajectory, frame, inspection.home_enu_m, autopilot=autopilot, items_max=items_max
    )


def document(inspection, autopilot="px4"):
    frame = inspection.site.heights.frame
    place = inspection.clearance.position_enu_m
    return plan_document(
        made(inspection, autopilot), frame, place, name=inspection.mission.name, fence_margin_m=4.0
    )


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_the_keys_that_the_loaders_demand(planned, autopilot):
    plan = json.loads(json.dumps(document(planned("kiosk"), autopilot), allow_nan=False))
    assert (plan["fileType"], plan["version"]) == ("Plan", 1)
    assert isinstance(plan["version"], int)
    mission = plan["mission"]
    assert mission["firmwareType"] == {"px4": 12, "ardupilot": 3}[autopilot]
    assert len(mission["plannedHomePosition"]) == 3
    for number, item in enumerate(mission["items"], start=1):
        assert item["type"] == "SimpleItem"
        assert len(item["params"]) == 7
        assert item["doJumpId"] == number
        assert isinstance(item["autoContinue"], bool)
        altitude = {"Altitude", "AltitudeMode", "AMSLAltAboveTerrain"} & item.keys()
        assert len(altitude) == (3 if item["command"] in (16, 22) else 0)
        # PX4 refuses DO_ and CONDITION_ items in a global frame.
        assert item["frame"] == (3 if item["command"] in (16, 22) else 2)
    assert mission["items"][0]["command"] == 22
    assert mission["items"][-1]["command"] == 20
    assert plan["geoFence"]["version"] == 2
    assert plan["rallyPoints"] == {"version": 2, "points": []}


def test_waypoints_are_places_and_headings_of_the_trajectory(planned):
    inspection = planned("kiosk")
    items = [item for item in made(inspection).items if item.command == 16]
    home = inspection.site.heights.frame.geo_point(inspection.home_enu_m)
    states = inspection.trajectory.sampled(0.1)
    for item in items:
        place = inspection.site.heights.frame.to_enu(
            item.params[4], item.params[5], home.alt_amsl_m + item.params[6]
        )
        away = np.sqrt(((states.position_enu_m - place) ** 2).sum(axis=1))
        nearest = int(np.argmin(away))
        assert away[nearest] < 0.01
        same_place = away < 0.02
        error = wrap_rad(math.radians(item.params[3]) - yaw_enu_to_ned(states.yaw_enu_rad[same_place]))
        assert np.abs(error).min() < 0.01


def test_legs_between_waypoints_stay_within_the_stated_errors(planned):
    trajectory = planned("kiosk").trajectory
    thinned = thin(trajectory, 400)
    dense = trajectory.sampled(0.05)
    leg = np.clip(np.searchsorted(thinned.t_s, dense.t_s, side="right") - 1, 0, len(thinned.t_s) - 2)
    a, b = thinned.position_enu_m[leg], thinned.position_enu_m[leg + 1]
    along = np.clip(
        ((dense.position_enu_m - a) * (b - a)).sum(1) / np.maximum(((b - a) ** 2).sum(1), 1e-12), 0, 1
    )
    off = np.sqrt(((dense.position_enu_m - a - along[:, None] * (b - a)) ** 2).sum(1))
    assert off.max() <= thinned.chord_error_m + 0.02
    assert thinned.chord_error_m <= 0.25
    assert math.degrees(thinned.heading_error_rad) <= 10.0 + 1e-9


def test_fewer_items_cost_accuracy_and_too_few_are_refused(planned):
    inspection = planned("kiosk")
    fine, coarse = made(inspection), made(inspection, items_max=40)
    assert len(coarse.items) <= 40 < len(fine.items)
    assert coarse.thinned.chord_error_m > fine.thinned.chord_error_m
    with pytest.raises(LimitError, match="max_items"):
        made(inspection, items_max=6)


def test_ardupilot_gets_a_condition_yaw_for_each_waypoint(planned):
    items = made(planned("kiosk"), "ardupilot").items
    waypoints = [i for i, item in enumerate(items) if item.command == 16]
    assert len(items) <= 500
    for i in waypoints:
        assert items[i + 1].command == 115
        assert 0.0 <= items[i + 1].params[0] < 360.0
        assert items[i + 1].params[2] in (-1, 1)


def test_the_fence_keeps_its_margin(planned):
    place = planned("kiosk").clearance.position_enu_m
    corners = fence_enu_m(place, 7.0)
    following = np.roll(corners, -1, axis=0)
    side = following - corners
    normal = np.column_stack([side[:, 1], -side[:, 0]]) / np.hypot(*side.T)[:, None]
    inward = -((place[None, ::20, :2] - corners[:, None]) * normal[:, None]).sum(axis=-1)
    assert inward.min() >= 7.0 - 1e-9
    assert inward.min() < 7.5


def test_pymavlink_reads_the_waypoints_file(planned, tmp_path):
    mission = made(planned("kiosk"))
    path = tmp_path / "kiosk.waypoints"
    path.write_text(waypoints_text(mission))
    loader = mavwp.MAVWPLoader()
    assert loader.load(str(path)) == len(mission.items) + 1
    home = loader.wp(0)
    assert (home.x, home.y) == pytest.approx((mission.home.lat_deg, mission.home.lon_deg), abs=1e-7)
    for number, item in enumerate(mission.items, start=1):
        read = loader.wp(number)
        assert (read.command, read.frame) == (item.command, item.frame)
        assert (read.x, read.y, read.z) == pytest.approx(item.params[4:], abs=1e-5)


def test_the_golden_plan(planned, renew_golden):
    """`pytest --renew-golden` writes it anew. Within 0.1 m and 0.1° it is the same plan on another machine."""
    path = GOLDEN / "kiosk.plan"
    ours = json.loads(json.dumps(document(planned("kiosk"))))
    if renew_golden:
        path.write_text(json.dumps(ours, indent=1) + "\n")
    golden = json.loads(path.read_text())
    my_items, their_items = ours["mission"].pop("items"), golden["mission"].pop("items")
    assert len(my_items) == len(their_items)
    for mine, theirs in zip(my_items, their_items, strict=True):
        my_params, their_params = mine.pop("params"), theirs.pop("params")
        assert my_params[:4] == pytest.approx(their_params[:4], abs=0.1)
        assert my_params[4:6] == pytest.approx(their_params[4:6], abs=1e-6)
        assert my_params[6] == pytest.approx(their_params[6], abs=0.1)
        assert mine.pop("Altitude", 0.0) == pytest.approx(theirs.pop("Altitude", 0.0), abs=0.1)
        assert mine == theirs
    (my_fence,), (their_fence,) = ours["geoFence"].pop("polygons"), golden["geoFence"].pop("polygons")
    assert np.allclose(my_fence["polygon"], their_fence["polygon"], atol=1e-6)
    my_notes, their_notes = ours.pop("mavspiral"), golden.pop("mavspiral")
    assert my_notes.pop("name") == their_notes.pop("name")
    assert my_notes == pytest.approx(their_notes, abs=0.1)
    assert ours == golden
