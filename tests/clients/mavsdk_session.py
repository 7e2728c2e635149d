"""MAVSDK 4 on a vehicle's offboard link, as its users begin: found, used and let go."""

import asyncio
import contextlib

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk import asyncio as mavsdk_asyncio
from mavsdk.exceptions import MavsdkError
from patience import LIMIT_S

TRIES_N = 5
LATE = {"TIMEOUT", "TRANSFER_CANCELLED", "BUSY"}
"""How MAVSDK calls an answer that was lost, or came later than half a second, three times running."""


def url(vehicle):
    return f"udpin://127.0.0.1:{vehicle.offboard_port}"


@contextlib.contextmanager
def system_of(vehicle):
    """The system that MAVSDK's blocking API finds."""
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    try:
        sdk.add_any_connection(url(vehicle))
        system = sdk.first_autopilot(LIMIT_S)
        assert system is not None
        yield system
    finally:
        sdk.destroy()


@contextlib.asynccontextmanager
async def async_system_of(vehicle):
    """The system that MAVSDK's asyncio API finds."""
    ground_station = mavsdk_asyncio.Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    sdk = mavsdk_asyncio.Mavsdk(ground_station)
    try:
        await sdk.add_any_connection(url(vehicle))
        system = await sdk.first_autopilot(timeout_s=LIMIT_S)
        assert system is not None
        yield system
    finally:
        sdk.destroy()


def insisted(ask, *parameters):
    """What it answers; asked again where no answer came, as a pilot does. A refusal is an answer."""
    for _ in range(TRIES_N - 1):
        try:
            return ask(*parameters)
        except MavsdkError as error:
            if error.result.name not in LATE:
                raise
    return ask(*parameters)


async def async_insisted(ask, *parameters):
    """The same of MAVSDK's asyncio API."""
    for _ in range(TRIES_N - 1):
        try:
            return await ask(*parameters)
        except MavsdkError as error:
            if error.result.name not in LATE:
                raise
    return await ask(*parameters)


async def first(stream, holds, limit_s=LIMIT_S):
    """The first item of the stream for which it holds."""

    async def search():
        async for item in stream:
            if holds(item):
                return item
        raise AssertionError("the stream ended")

    return await asyncio.wait_for(search(), limit_s)
