"""MAVSDK 4's asyncio API: our own exported plan is imported, uploaded, flown in AUTO and watched."""

import asyncio
import json
import math

import pytest

pytest.importorskip("mavsdk.asyncio")

from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.mission_raw import MissionRawAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.plugins.telemetry import FlightMode
from mavsdk_session import async_insisted, async_system_of, first
from patience import LIMIT_S

from mavspiral.handover import inspection_documents, inspection_missions
from mavspiral.mission import load_mission
from mavspiral.planner import plan


def kiosk_plan():
    inspection = plan(load_mission("missions/kiosk.toml"))
    (document,) = inspection_documents(inspection, inspection_missions(inspection))
    return json.dumps(document, allow_nan=False)


async def fly(vehicle):
    async with async_system_of(vehicle) as system:
        telemetry, action, mission = TelemetryAsync(system), ActionAsync(system), MissionRawAsync(system)
        await first(telemetry.subscribe_health_all_ok(), bool)

        imported = await mission.import_qgroundcontrol_mission_from_string(kiosk_plan())
        await async_insisted(mission.upload_mission, imported.mission_items)
        await async_insisted(mission.upload_geofence, imported.geofence_items)
        back = await async_insisted(mission.download_mission)
        assert len(back) == len(imported.mission_items)
        for ours, theirs in zip(imported.mission_items, back, strict=True):
            assert (ours.command, ours.x, ours.y) == (theirs.command, theirs.x, theirs.y)
            turn = math.remainder(ours.param4 - theirs.param4, 360.0)
            assert math.isnan(turn) or abs(turn) < 1e-3

        await async_insisted(ParamAsync(system).set_param_float, "COM_DISARM_PRFLT", -1.0)  # it waits for us
        await async_insisted(action.arm)
        await async_insisted(mission.start_mission)
        await first(telemetry.subscribe_flight_mode(), lambda mode: mode is FlightMode.MISSION)
        progress = await first(mission.subscribe_mission_progress(), lambda p: p.current >= p.total // 2)
        assert progress.total == len(back)
        await first(telemetry.subscribe_armed(), lambda armed: not armed)


def test_the_kiosks_plan_is_imported_uploaded_and_flown(start_vehicle):
    vehicle = start_vehicle("--speedup", "10")
    asyncio.run(asyncio.wait_for(fly(vehicle), 4.0 * LIMIT_S))
    modes = [line.split("mode: ")[-1] for line in vehicle.lines if "mode: " in line]
    assert modes[:2] == ["MISSION", "RETURN"]
