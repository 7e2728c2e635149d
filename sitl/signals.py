"""The values that cross the vehicle's rooms. NED and FRD axes, SI units, integer microseconds, wxyz.

`q_ned_frd` and `R_ned_frd` take FRD vectors to NED. Local NED positions are relative to the simulation's
origin for truth (the place where the vehicle stands at time zero) and to the EKF's origin for estimates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sitl.kernels import Triple

__all__ = [
    "AttitudeSetpoint",
    "BaroSample",
    "Demand",
    "Estimate",
    "FloatArray",
    "GeoPoint",
    "GpsSample",
    "ImuSample",
    "MagSample",
    "Setpoint",
    "Sticks",
    "TruthState",
    "vector",
]

FloatArray = NDArray[np.float64]


def vector(values: ArrayLike, size: int = 3) -> FloatArray:
    """A read-only float64 copy of `values`, which must be `(size,)`."""
    array = np.array(values, dtype=np.float64)
    if array.shape != (size,):
        raise ValueError(f"wanted shape ({size},), got {array.shape}")
    array.setflags(write=False)
    return array


class GeoPoint(NamedTuple):
    """A place on the earth."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


class TruthState(NamedTuple):
    """What really is. Passed to `physics` only (and to whoever judges the flight from outside)."""

    time_us: int
    numbers: FloatArray
    """All of it, (17,), or (n, 17) of n moments: most who ask want little of it."""

    @property
    def position_ned_m(self) -> FloatArray:
        """Relative to the place where the vehicle stood at time zero."""
        return self.numbers[..., 0:3]

    @property
    def velocity_ned_mps(self) -> FloatArray:
        """Over ground."""
        return self.numbers[..., 3:6]

    @property
    def q_ned_frd(self) -> FloatArray:
        """The attitude, wxyz."""
        return self.numbers[..., 6:10]

    @property
    def rate_frd_radps(self) -> FloatArray:
        """About the body's axes."""
        return self.numbers[..., 10:13]

    @property
    def rotor_speed_radps(self) -> FloatArray:
        """Of each rotor, (4,), in PX4's order."""
        return self.numbers[..., 13:17]


@dataclass(frozen=True, slots=True, eq=False)
class ImuSample:
    """Mean specific force and mean angular rate over the interval that ends at `time_us`."""

    time_us: int
    specific_force_frd_mps2: FloatArray
    rate_frd_radps: FloatArray


class GpsSample(NamedTuple):
    """A fix. `time_us` is when it was true; it arrives later by the receiver's delay."""

    time_us: int
    position: GeoPoint
    velocity_ned_mps: FloatArray
    horizontal_sigma_m: float
    vertical_sigma_m: float
    speed_sigma_mps: float
    fix_type: int
    satellites: int


@dataclass(frozen=True, slots=True)
class BaroSample:
    """Static pressure, and the standard atmosphere's height for it."""

    time_us: int
    pressure_pa: float
    alt_amsl_m: float
    temperature_c: float


@dataclass(frozen=True, slots=True, eq=False)
class MagSample:
    """The field along the body axes."""

    time_us: int
    field_frd_gauss: FloatArray


class Estimate(NamedTuple):
    """What the vehicle believes. Variances are diagonal entries, in NED and in squared units."""

    time_us: int
    numbers: FloatArray
    """All of it, (31,) as the estimator's `report` orders it, or (n, 31): most who ask want little of it."""
    attitude_ok: bool
    position_ok: bool
    velocity_ok: bool
    height_ok: bool

    @property
    def position_ned_m(self) -> FloatArray:
        """Relative to the EKF's origin."""
        return self.numbers[..., 0:3]

    @property
    def velocity_ned_mps(self) -> FloatArray:
        """Over ground."""
        return self.numbers[..., 3:6]

    @property
    def q_ned_frd(self) -> FloatArray:
        """The attitude, wxyz."""
        return self.numbers[..., 6:10]

    @property
    def rate_frd_radps(self) -> FloatArray:
        """About the body's axes, without the gyro's bias."""
        return self.numbers[..., 10:13]

    @property
    def motion_ned(self) -> FloatArray:
        """Position and velocity, (6,)."""
        return self.numbers[..., 0:6]

    @property
    def acceleration_ned_mps2(self) -> FloatArray:
        """Of the body, without gravity."""
        return self.numbers[..., 13:16]

    @property
    def gyro_bias_frd_radps(self) -> FloatArray:
        """What the gyro shows at rest."""
        return self.numbers[..., 16:19]

    @property
    def accel_bias_frd_mps2(self) -> FloatArray:
        """What the accelerometer shows beyond the specific force."""
        return self.numbers[..., 19:22]

    @property
    def position_variance_m2(self) -> FloatArray:
        """The wander of the receiver's frame included."""
        return self.numbers[..., 22:25]

    @property
    def velocity_variance_m2ps2(self) -> FloatArray:
        """Along NED axes."""
        return self.numbers[..., 25:28]

    @property
    def attitude_variance_rad2(self) -> FloatArray:
        """Of turns about NED axes."""
        return self.numbers[..., 28:31]


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeSetpoint:
    """An attitude and collective thrust (0…1); body rates alone where `q_ned_frd` is None.

    With an attitude only the last of the rates counts: the yaw rate about down, fed forward.
    """

    q_ned_frd: FloatArray | None
    rate_frd_radps: FloatArray
    thrust: float


class Setpoint(NamedTuple):
    """What the position cascade shall do. NaN marks an axis that is not commanded, as PX4 has it.

    An `attitude` goes before all else: position and velocity are not controlled then.
    """

    position_ned_m: Triple
    velocity_ned_mps: Triple
    acceleration_ned_mps2: Triple
    yaw_ned_rad: float
    yaw_rate_ned_radps: float
    attitude: AttitudeSetpoint | None = None


class Sticks(NamedTuple):
    """How far a pilot deflects each stick, -1…1."""

    forward: float
    right: float
    up: float
    clockwise: float


class Demand(NamedTuple):
    """What the commander asks of the cascade. Disarmed: motors stand still. `idle`: armed, spinning low."""

    armed: bool
    idle: bool
    setpoint: Setpoint
