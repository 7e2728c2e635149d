"""Every mission of the gallery as files for both autopilots, read by three that had no part in them: MAVSDK, pymavlink, our checker."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.mission_raw import MissionRaw
from pymavlink import mavwp
from pymavlink.dialects.v20 import common

from mavspiral.export.check import check_document
from mavspiral.export.waypoints import waypoints_text
from mavspiral.handover import inspection_documents, inspection_missions
from mavspiral.mission import Mission

MISSIONS = sorted(path.stem for path in (Path(__file__).parents[3] / "missions").glob("*.toml"))
PLACED = (16, 22, 195)


@pytest.fixture(scope="module")
def mission_raw():
    """MAVSDK's plugin by autopilot, each on a system of which it has one heartbeat: the importer asks it nothing else."""
    plugins, sdks = {}, []
    for autopilot, number in (("px4", 12), ("ardupilot", 3)):
        sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
        sdk.add_any_connection("raw://")
        mav = common.MAVLink(None, srcSystem=98, srcComponent=1)
        sdk.pass_received_raw_bytes(mav.heartbeat_encode(2, number, 81, 0, 3).pack(mav))
        system = sdk.first_autopilot(10.0)
        assert system is not None, "MAVSDK did not take the heartbeat"
        plugins[autopilot] = MissionRaw(system)
        sdks.append(sdk)
    yield plugins
    for sdk in sdks:
        sdk.destroy()


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
@pytest.mark.parametrize("name", MISSIONS)
def test_they_find_in_it_what_was_put_there(planned, mission_raw, tmp_path, name, autopilot):
    inspection = planned(name).flown_by(autopilot)
    vehicle = inspection.mission.vehicle
    handover = inspection_missions(inspection)
    assert handover.refusals == () and handover.missions
    documents = inspection_documents(inspection, handover)
    for number, (mission, document) in enumerate(zip(handover.missions, documents, strict=True), start=1):
        assert len(mission.items) <= vehicle.max_items
        text = json.dumps(document, allow_nan=False)
        verdict = check_document(json.loads(text))
        assert (verdict.autopilot, verdict.errors) == (autopilot, ())
        assert all("items: " in line for line in verdict.warnings)  # how many boards hold
        notes = json.loads(text)["mavspiral"]
        assert notes["sortie"] == [number, len(documents)]
        again = Mission.model_validate_json(json.dumps(notes["mission"]))
        assert again.model_copy(update={"path": inspection.mission.path}) == inspection.mission

        theirs = mission_raw[autopilot].import_qgroundcontrol_mission_from_string(text)
        home_n = 1 if autopilot == "ardupilot" else 0  # its list begins with home
        assert len(theirs.mission_items) == home_n + len(mission.items)
        for item, read in zip(mission.items, theirs.mission_items[home_n:], strict=True):
            assert (read.command, read.frame) == (item.command, item.frame)
            for want, got in zip(
                item.params[:4], (read.param1, read.param2, read.param3, read.param4), strict=True
            ):
                assert math.isnan(got) if math.isnan(want) else got == pytest.approx(want, abs=1e-4)
            if item.command in PLACED:
                assert (read.x, read.y) == pytest.approx([p * 1e7 for p in item.params[4:6]], abs=1.0)
                assert read.z == pytest.approx(item.params[6], abs=1e-3)
        assert len(theirs.geofence_items) == sum(
            len(shape["polygon"]) for shape in document["geoFence"]["polygons"]
        )
        assert len(theirs.rally_items) == 1

        path = tmp_path / f"{number}.waypoints"
        path.write_text(waypoints_text(mission))
        loader = mavwp.MAVWPLoader()
        assert loader.load(str(path)) == 1 + len(mission.items)
        for row, item in enumerate(mission.items, start=1):
            read = loader.wp(row)
            assert (read.command, read.frame) == (item.command, item.frame)
            wanted = [0.0 if math.isnan(value) else value for value in item.params]
            got = [read.param1, read.param2, read.param3, read.param4, read.x, read.y, read.z]
            assert got == pytest.approx(wanted, abs=1e-5)
