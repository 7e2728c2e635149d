"""All that there is to tell of the vehicle at one moment."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from sitl.condition import Battery
from sitl.geo import geodetic_of_ned
from sitl.rotation import euler_rad
from sitl.signals import BaroSample, Estimate, FloatArray, GeoPoint, GpsSample, ImuSample, MagSample
from sitl.status import FlightStatus

__all__ = ["Instruments", "Report", "heading_deg", "whole"]


class Instruments(Protocol):
    """What can be read off the vehicle."""

    @property
    def origin(self) -> GeoPoint | None:
        """The estimator's anchor, if any."""

    @property
    def imu(self) -> ImuSample:
        """The latest sample."""

    @property
    def gps(self) -> GpsSample | None:
        """The latest fix, if any."""

    @property
    def baro(self) -> BaroSample:
        """The latest sample."""

    @property
    def mag(self) -> MagSample:
        """The latest sample."""

    @property
    def battery(self) -> Battery:
        """The pack."""

    @property
    def thrust(self) -> float:
        """What the motors are asked for together, 0…1."""

    @property
    def attitude_wanted(self) -> FloatArray:
        """What the cascade steers to, `q_ned_frd`."""

    @property
    def rate_wanted(self) -> FloatArray:
        """The body rates that the cascade steers to, about FRD axes."""

    @property
    def velocity_wanted(self) -> FloatArray:
        """The NED velocity that the cascade asks for, its correction of the position included."""

    @property
    def acceleration_wanted(self) -> FloatArray:
        """The NED acceleration that the cascade asks for."""

    @property
    def range_m(self) -> float:
        """What the range finder under the belly reads."""

    @property
    def vibration(self) -> tuple[float, float, float]:
        """PX4's coning, gyro and accelerometer metrics."""

    @property
    def motors(self) -> FloatArray:
        """What each motor is asked for, 0…1."""


@dataclass(slots=True, eq=False)
class Report:
    """What estimator, instruments and commander say. Read it at once: instruments do not stand still."""

    time_us: int
    estimate: Estimate
    instruments: Instruments
    ask_commander: Callable[[], FlightStatus]
    said: FlightStatus | None = None

    @property
    def flight(self) -> FlightStatus:
        """What the commander says, who is asked once."""
        if self.said is None:
            self.said = self.ask_commander()
        return self.said

    @property
    def origin(self) -> GeoPoint | None:
        """Where the estimate's frame is anchored, once that is known."""
        return self.instruments.origin

    @property
    def time_ms(self) -> int:
        """Since the start, as MAVLink's `time_boot_ms` has it."""
        return self.time_us // 1000 & 0xFFFFFFFF

    @property
    def place(self) -> tuple[float, float, float] | None:
        """Latitude and longitude in degrees and height above sea level, as estimated."""
        origin = self.origin
        if origin is None:
            return None
        north_m, east_m, down_m = self.estimate.position_ned_m.tolist()
        anchor = origin.lat_deg, origin.lon_deg, origin.alt_amsl_m
        place: tuple[float, float, float] = geodetic_of_ned(anchor, (north_m, east_m, down_m))
        return place

    @property
    def height_home_m(self) -> float:
        """Above home; above the origin while there is no home."""
        down_m = self.estimate.position_ned_m[2]
        home = self.flight.home
        return float((0.0 if home is None else home.position_ned_m[2]) - down_m)


def whole(value: float, span: tuple[int, int]) -> int:
    """The nearest integer that the field's span holds; zero for NaN."""
    if math.isnan(value):
        return 0
    low, high = span
    return round(min(max(value, low), high))


def heading_deg(q_ned_frd: FloatArray) -> float:
    """The nose's compass direction, 0…360."""
    return math.degrees(euler_rad(q_ned_frd)[2]) % 360.0
