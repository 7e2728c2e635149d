"""MAVSDK 4 flies the vehicle over UDP, as a user's script would."""

import asyncio

import pytest

pytest.importorskip("mavsdk.asyncio")

from mavsdk.asyncio import Configuration, Mavsdk
from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.component_type import ComponentType
from mavsdk.plugins.offboard import PositionNedYaw, VelocityNedYaw


async def first(stream, holds, limit_s=20.0):
    """The first item of the stream for which it holds."""

    async def search():
        async for item in stream:
            if holds(item):
                return item
        raise AssertionError("the stream ended")

    return await asyncio.wait_for(search(), limit_s)


async def fly(vehicle):
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    try:
        await mavsdk.add_any_connection(f"udpin://127.0.0.1:{vehicle.offboard_port}")
        system = await mavsdk.first_autopilot(timeout_s=10.0)
        assert system is not None
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
    finally:
        mavsdk.destroy()


def test_health_arm_takeoff_offboard_and_land(start_vehicle):
    vehicle = start_vehicle("--speedup", "5")
    asyncio.run(asyncio.wait_for(fly(vehicle), 60.0))
    kinds = [line.split("] ")[-1] for line in vehicle.lines]
    assert "mode: OFFBOARD" in kinds
    assert "disarmed: HOLD" in kinds
