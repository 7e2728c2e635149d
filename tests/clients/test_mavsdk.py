"""MAVSDK 4 flies the vehicle over UDP, as a user's script would."""

import asyncio

import pytest

pytest.importorskip("mavsdk.asyncio")

from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.plugins.offboard import PositionNedYaw, VelocityNedYaw
from mavsdk_session import async_system_of, first


async def fly(vehicle):
    async with async_system_of(vehicle) as system:
        telemetry, action = TelemetryAsync(system), ActionAsync(system)
        offboard, param = OffboardAsync(system), ParamAsync(system)

        assert await first(telemetry.subscribe_health_all_ok(), bool)
        await action.set_takeoff_altitude(6.0)
        assert await action.get_takeoff_altitude() == pytest.approx(6.0)
        assert await param.get_param_int("NAV_RCL_ACT") == 2

        await action.arm()
        await action.takeoff()
        await first(telemetry.subscribe_position_velocity_ned(), lambda p: p.position.down_m < -5.5)
        await asyncio.sleep(0.5)

        await offboard.set_position_ned(PositionNedYaw(5.0, 3.0, -8.0, 90.0))
        await offboard.start()
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
        await offboard.stop()

        await action.land()
        await first(telemetry.subscribe_armed(), lambda armed: not armed, 30.0)


def test_health_arm_takeoff_offboard_and_land(start_vehicle):
    vehicle = start_vehicle("--speedup", "5")
    asyncio.run(asyncio.wait_for(fly(vehicle), 60.0))
    kinds = [line.split("] ")[-1] for line in vehicle.lines]
    assert "mode: OFFBOARD" in kinds
    assert "disarmed: HOLD" in kinds
