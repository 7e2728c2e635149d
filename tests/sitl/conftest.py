"""A vehicle, and what one says to it."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from sitl.airframe import Airframe, load_airframe
from sitl.params import Params
from sitl.signals import Demand, GeoPoint, Setpoint
from sitl.vehicle import Vehicle, VehicleConfig

sys.path.insert(0, str(Path(__file__).parent))

NAN = math.nan
NOTHING = (NAN, NAN, NAN)


@pytest.fixture(scope="session")
def x500() -> Airframe:
    return load_airframe("x500")


@pytest.fixture(scope="session")
def demand() -> Callable[..., Demand]:
    def make(p=NOTHING, v=NOTHING, a=NOTHING, yaw=NAN, yaw_rate=NAN, armed=True, idle=False) -> Demand:
        return Demand(armed, idle, Setpoint(p, v, a, yaw, yaw_rate))

    return make


@pytest.fixture(scope="session")
def vehicle(x500: Airframe) -> Callable[..., Vehicle]:
    """A vehicle over Mexico City, its config by keyword."""

    def make(airframe: Airframe = x500, params: dict[str, float] | None = None, **config) -> Vehicle:
        home = GeoPoint(19.4332, -99.1412, 2240.0)
        chosen = Params(airframe.params).replace(**(params or {}))
        return Vehicle(VehicleConfig(airframe, chosen, home, **config))

    return make


@pytest.fixture(scope="session")
def flying(vehicle, demand) -> Callable[..., Vehicle]:
    """One that hovers 10 m above its home, 13 s after the start."""

    def make(**config) -> Vehicle:
        one = vehicle(**config)
        one.advance(3_000_000, demand(armed=False))
        one.advance(13_000_000, demand((0.0, 0.0, -10.0), yaw=0.0))
        return one

    return make
