"""The `.plan`: QGroundControl's loader rules, and that its numbers are the trajectory's."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavwp

from mavspiral.export.check import check_document
from mavspiral.export.waypoints import waypoints_text
from mavspiral.handover import inspection_documents, inspection_missions

GOLDEN = Path(__file__).parents[2] / "golden"


def for_autopilot(inspection, autopilot):
    vehicle = inspection.mission.vehicle.model_copy(update={"autopilot": autopilot})
    return replace(inspection, mission=inspection.mission.model_copy(update={"vehicle": vehicle}))


def made(inspection, autopilot="px4"):
    (items,) = inspection_missions(for_autopilot(inspection, autopilot)).missions
    return items


def document(inspection, autopilot="px4"):
    inspection = for_autopilot(inspection, autopilot)
    (plan,) = inspection_documents(inspection, inspection_missions(inspection))
    return plan


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
        assert len(altitude) == (3 if item["command"] in (16, 22, 195) else 0)
        # PX4 refuses DO_ items without a place in a global frame.
        assert item["frame"] == (3 if item["command"] in (16, 22, 195) else 2)
    assert mission["items"][0]["command"] == 22
    assert mission["items"][-1]["command"] == 20
    assert plan["geoFence"]["version"] == 2
    assert len(plan["rallyPoints"]["points"]) == 1
    verdict = check_document(plan)
    assert (verdict.autopilot, verdict.errors, verdict.warnings) == (autopilot, (), ())


@pytest.mark.parametrize("name", ["kiosk", "asilo"])
def test_the_rally_point_stands_above_home_clear_of_everything_and_of_what_lies_under_a_return(planned, name):
    inspection = planned(name)
    ((lat, lon, above_home_m),) = document(inspection)["rallyPoints"]["points"]
    home = inspection.home_enu_m
    frame, heights = inspection.site.heights.frame, inspection.site.heights
    rally = frame.to_enu(np.array([lat]), np.array([lon]), frame.geo_point(home).alt_amsl_m + above_home_m)
    assert np.allclose(rally[0, :2], home[:2], atol=0.05)
    east, north, up_m = rally[0]
    # Against every cell as a column of its height, by hand.
    tall = np.argwhere(heights.height_agl_m > 0.0)
    middle = np.asarray(heights.origin_enu_m) + (tall[:, ::-1] + 0.5) * heights.cell_m
    aside_m = np.maximum(np.hypot(*(middle - [east, north]).T) - heights.cell_m, 0.0)
    above_m = np.maximum(up_m - heights.height_agl_m[tall[:, 0], tall[:, 1]], 0.0)
    assert np.hypot(aside_m, above_m).min() >= inspection.clearance_required_m
    assert up_m - heights.height_agl_m.max() >= inspection.clearance_required_m - 1e-3
    assert up_m <= inspection.mission.limits.ceiling_m


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
        assert [p or 0.0 for p in my_params[:4]] == pytest.approx(
            [p or 0.0 for p in their_params[:4]], abs=0.1
        )
        assert my_params[4:6] == pytest.approx(their_params[4:6], abs=1e-6)
        assert my_params[6] == pytest.approx(their_params[6], abs=0.1)
        assert mine.pop("Altitude", 0.0) == pytest.approx(theirs.pop("Altitude", 0.0), abs=0.1)
        assert mine == theirs
    (my_fence,), (their_fence,) = ours["geoFence"].pop("polygons"), golden["geoFence"].pop("polygons")
    assert np.allclose(my_fence["polygon"], their_fence["polygon"], atol=1e-6)
    (my_rally,), (their_rally,) = ours["rallyPoints"].pop("points"), golden["rallyPoints"].pop("points")
    assert my_rally == pytest.approx(their_rally, abs=1e-6)
    my_notes, their_notes = ours.pop("mavspiral"), golden.pop("mavspiral")
    for key in ("chord_error_m", "heading_error_deg", "clearance_m"):
        assert my_notes.pop(key) == pytest.approx(their_notes.pop(key), abs=0.1)
    my_times, their_times = my_notes.pop("item_t_s"), their_notes.pop("item_t_s")
    assert [t or 0.0 for t in my_times] == pytest.approx([t or 0.0 for t in their_times], abs=0.1)
    assert my_notes == their_notes
    assert ours == golden
