"""MAVSDK's own importer reads the `.plan` that we write, and finds in it what we put there."""

from __future__ import annotations

import json
import math

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.mission_raw import MissionRaw
from pymavlink.dialects.v20 import common

from mavspiral.handover import inspection_documents, inspection_missions
from mavspiral.mission import load_mission
from mavspiral.planner import plan


@pytest.fixture(scope="module")
def mission_raw():
    """MAVSDK's plugin on a system of which it has one heartbeat: the importer wants a system, and asks it nothing."""
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    sdk.add_any_connection("raw://")
    mav = common.MAVLink(None, srcSystem=97, srcComponent=1)
    sdk.pass_received_raw_bytes(mav.heartbeat_encode(2, 12, 81, 0, 3).pack(mav))
    system = sdk.first_autopilot(10.0)
    assert system is not None, "MAVSDK did not take the heartbeat"
    yield MissionRaw(system)
    sdk.destroy()


@pytest.mark.parametrize("name", ["torre", "asilo", "kiosk"])
def test_mavsdk_reads_every_item(mission_raw, name):
    mission = load_mission(f"missions/{name}.toml")
    inspection = plan(mission)
    fit = inspection_missions(inspection)
    (ours,), (document,) = fit.missions, inspection_documents(inspection, fit)
    theirs = mission_raw.import_qgroundcontrol_mission_from_string(json.dumps(document, allow_nan=False))
    assert len(theirs.mission_items) == len(ours.items) <= mission.vehicle.max_items
    for item, read in zip(ours.items, theirs.mission_items, strict=True):
        assert (read.command, read.frame, read.autocontinue) == (item.command, item.frame, 1)
        for want, got in zip(
            item.params[:4], (read.param1, read.param2, read.param3, read.param4), strict=True
        ):
            assert math.isnan(got) if math.isnan(want) else got == pytest.approx(want, abs=1e-4)
        if item.command in (16, 22, 195):
            assert read.x == pytest.approx(item.params[4] * 1e7, abs=1.0)
            assert read.y == pytest.approx(item.params[5] * 1e7, abs=1.0)
            assert read.z == pytest.approx(item.params[6], abs=1e-3)
    assert len(theirs.geofence_items) == 16
    assert len(theirs.rally_items) == 1
