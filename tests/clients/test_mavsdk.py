"""MAVSDK 4 flies the vehicle over UDP, as a user's script would."""

import asyncio

import pytest

pytest.importorskip("mavsdk.asyncio")

from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.plugins.offboard import PositionNedYaw, VelocityNedYaw
from mavsdk_session import async_insisted, async_system_of, first
from patience import LIMIT_S


async def fly(vehicle):
    async with async_system_of(vehicle) as system:
        telemetry, action = TelemetryAsync(system), ActionAsync(system)
        offboard, param = OffboardAsync(system), ParamAsync(system)

        assert await first(telemetry.subscribe_health_all_ok(), bool)
        await async_insisted(action.set_takeoff_altitude, 6.0)
        assert await async_insisted(action.get_takeoff_altitude) == pytest.approx(6.0)
        assert await async_insisted(param.get_param_int, "NAV_RCL_ACT") == 2
        await async_insisted(param.set_param_float, "COM_DISARM_PRFLT", -1.0)  # it waits for us, however late

        await async_insisted(action.arm)
        await async_insisted(action.takeoff)
        await first(telemetry.subscribe_position_velocity_ned(), lambda p: p.position.down_m < -5.5)
        await asyncio.sleep(0.5)

        await offboard.set_position_ned(PositionNedYaw(5.0, 3.0, -8.0, 90.0))
        await async_insisted(offboard.start)
        reached = await first(
            telemetry.subscribe_position_velocity_ned(),
            lambda p: (
                abs(p.position.north_m - 5.0) + abs(p.position.east_m - 3.0) + abs(p.position.down_m + 8.0)
                < 0.6
            ),
        )
        assert reached is not None
        await offboard.set_position_velocity_ned(
            PositionNedYaw(5.0, 3.0, -8.0, 0.0), VelocityNedYaw(0.0, 0.0, 0.0, 0.0)
        )
        await asyncio.sleep(0.2)
        assert await offboard.is_active()
        await async_insisted(offboard.stop)

        await async_insisted(action.land)
        await first(telemetry.subscribe_armed(), lambda armed: not armed)


def test_health_arm_takeoff_offboard_and_land(start_vehicle):
    vehicle = start_vehicle("--speedup", "5")
    asyncio.run(asyncio.wait_for(fly(vehicle), 4.0 * LIMIT_S))
    vehicle.says("disarmed: HOLD")
    kinds = [line.split("] ")[-1] for line in vehicle.lines]
    assert "mode: OFFBOARD" in kinds
    assert "disarmed: HOLD" in kinds
