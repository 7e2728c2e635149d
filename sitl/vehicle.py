"""The vehicle: body, senses, estimator and cascade on one clock, without MAVLink and without modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sitl.airframe import Airframe
from sitl.faults import Fault
from sitl.params import Params
from sitl.signals import (
    BaroSample,
    Demand,
    Estimate,
    FloatArray,
    GeoPoint,
    GpsSample,
    ImuSample,
    MagSample,
    TruthState,
)

__all__ = ["FRAME_US", "BatteryState", "Vehicle", "VehicleConfig", "VehicleState"]

FRAME_US = 10_000
"""The vehicle moves in frames of this length: 4 steps of physics and cascade, 2 IMU samples."""


@dataclass(frozen=True, slots=True)
class VehicleConfig:
    """Everything that decides a flight besides the demands.

    It stands at `home` (which is truth's NED origin) with its nose at `heading_ned_rad`. The EKF's origin lies
    `origin_offset_ned_m` away from the first good fix. `gusts` adds Dryden turbulence to the wind. Without
    `noise` the senses tell the truth. `stock_filter` flies filterpy's own arithmetic. `params` are taken as they
    are: start them from `Params(airframe.params)`.
    """

    airframe: Airframe
    params: Params
    home: GeoPoint
    heading_ned_rad: float = 0.0
    seed: int = 0
    gps: Literal["rtk", "standard"] = "rtk"
    wind_ned_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gusts: bool = False
    ground_down_m: float = 0.0
    origin_offset_ned_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    faults: tuple[Fault, ...] = ()
    noise: bool = True
    stock_filter: bool = False


@dataclass(frozen=True, slots=True)
class BatteryState:
    """The pack as its monitor sees it."""

    voltage_v: float
    current_a: float
    used_ah: float
    remaining: float


@dataclass(frozen=True, slots=True, eq=False)
class VehicleState:
    """A vehicle's whole state, as a value: the vehicle that gave it, or its twin by config, can take it back."""

    arrays: dict[str, FloatArray]


class Vehicle:
    """A quadrotor that flies itself to setpoints."""

    def __init__(self, config: VehicleConfig) -> None:
        self.config = config
        raise NotImplementedError

    @property
    def time_us(self) -> int:
        """Simulated time since the start."""
        raise NotImplementedError

    @property
    def params(self) -> Params:
        """The parameters that it obeys now; assign to change them in flight."""
        raise NotImplementedError

    @params.setter
    def params(self, params: Params) -> None:
        raise NotImplementedError

    def advance(self, until_us: int, demand: Demand) -> None:
        """Live until `until_us`, which is rounded down to whole frames, under one demand."""
        raise NotImplementedError

    @property
    def truth(self) -> TruthState:
        """What really is: for physics and for judges outside."""
        raise NotImplementedError

    @property
    def estimate(self) -> Estimate:
        """What it believes now."""
        raise NotImplementedError

    @property
    def origin(self) -> GeoPoint | None:
        """Where the EKF's NED frame is anchored; None before the first good fix."""
        raise NotImplementedError

    @property
    def imu(self) -> ImuSample:
        """The latest sample."""
        raise NotImplementedError

    @property
    def gps(self) -> GpsSample | None:
        """The fix that arrived last; None before the first."""
        raise NotImplementedError

    @property
    def baro(self) -> BaroSample:
        """The latest sample."""
        raise NotImplementedError

    @property
    def mag(self) -> MagSample:
        """The latest sample."""
        raise NotImplementedError

    @property
    def battery(self) -> BatteryState:
        """The pack as its monitor sees it."""
        raise NotImplementedError

    @property
    def on_ground(self) -> bool:
        """The land detector's verdict: from thrust, estimate and gyro, never from truth."""
        raise NotImplementedError

    @property
    def thrust(self) -> float:
        """Collective thrust that the cascade asks for, 0…1."""
        raise NotImplementedError

    @property
    def motors(self) -> FloatArray:
        """What each motor was last told, 0…1, in PX4's order."""
        raise NotImplementedError

    def snapshot(self) -> VehicleState:
        """The whole state, as a value."""
        raise NotImplementedError

    def restore(self, state: VehicleState) -> None:
        """Become again what `snapshot` saw."""
        raise NotImplementedError
