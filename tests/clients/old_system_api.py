"""A user's script from before MAVSDK 4: `from mavsdk import System`, with the server that the package brings.

python old_system_api.py PORT
"""

import asyncio
import sys

from mavsdk import System
from mavsdk.offboard import PositionNedYaw, VelocityNedYaw


async def first(stream, holds, limit_s=90.0):
    async def search():
        async for item in stream:
            if holds(item):
                return item
        raise AssertionError("the stream ended")

    return await asyncio.wait_for(search(), limit_s)


async def run(port):
    drone = System()
    await drone.connect(system_address=f"udpin://0.0.0.0:{port}")
    await first(drone.core.connection_state(), lambda state: state.is_connected)
    print("connected")

    await first(drone.telemetry.health(), lambda h: h.is_global_position_ok and h.is_home_position_ok)
    print("healthy")

    home = await first(drone.telemetry.home(), lambda _: True)
    await drone.action.set_takeoff_altitude(6.0)
    await drone.action.arm()
    await drone.action.takeoff()
    await first(drone.telemetry.position(), lambda p: p.relative_altitude_m > 5.5)
    print("taken off")

    await drone.action.goto_location(
        home.latitude_deg + 1e-4, home.longitude_deg, home.absolute_altitude_m + 8.0, 0.0
    )
    await first(
        drone.telemetry.position(),
        lambda p: abs(p.latitude_deg - home.latitude_deg - 1e-4) < 5e-6 and p.relative_altitude_m > 7.5,
    )
    print("there")

    await drone.offboard.set_position_ned(PositionNedYaw(3.0, 4.0, -6.0, 90.0))
    await drone.offboard.start()
    await first(
        drone.telemetry.position_velocity_ned(),
        lambda p: (
            abs(p.position.north_m - 3.0) + abs(p.position.east_m - 4.0) + abs(p.position.down_m + 6.0) < 0.8
        ),
    )
    await drone.offboard.set_velocity_ned(VelocityNedYaw(0.0, 0.0, 0.0, 90.0))
    await drone.offboard.stop()
    print("offboard")

    await drone.action.land()
    await first(drone.telemetry.armed(), lambda armed: not armed)
    print("landed")


if __name__ == "__main__":
    asyncio.run(run(int(sys.argv[1])))
