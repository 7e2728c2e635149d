"""The values that cross the vehicle's rooms. NED and FRD axes, SI units, integer microseconds, wxyz.

`q_ned_frd` and `R_ned_frd` take FRD vectors to NED. Local NED positions are relative to the simulation's
origin for truth (the place where the vehicle stands at time zero) and to the EKF's origin for estimates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    "TruthState",
    "setpoint_to",
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


@dataclass(frozen=True, slots=True)
class GeoPoint:
    """A place on the earth."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


class TruthState(NamedTuple):
    """What really is. Passed to `physics` only (and to whoever judges the flight from outside)."""

    time_us: int
    position_ned_m: FloatArray
    velocity_ned_mps: FloatArray
    q_ned_frd: FloatArray
    rate_frd_radps: FloatArray
    rotor_speed_radps: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ImuSample:
    """Mean specific force and mean angular rate over the interval that ends at `time_us`."""

    time_us: int
    specific_force_frd_mps2: FloatArray
    rate_frd_radps: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class GpsSample:
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
    position_ned_m: FloatArray
    velocity_ned_mps: FloatArray
    q_ned_frd: FloatArray
    rate_frd_radps: FloatArray
    acceleration_ned_mps2: FloatArray
    gyro_bias_frd_radps: FloatArray
    accel_bias_frd_mps2: FloatArray
    position_variance_m2: FloatArray
    velocity_variance_m2ps2: FloatArray
    attitude_variance_rad2: FloatArray
    attitude_ok: bool
    position_ok: bool
    velocity_ok: bool
    height_ok: bool


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeSetpoint:
    """An attitude and collective thrust (0…1); body rates alone where `q_ned_frd` is None.

    With an attitude only the last of the rates counts: the yaw rate about down, fed forward.
    """

    q_ned_frd: FloatArray | None
    rate_frd_radps: FloatArray
    thrust: float


@dataclass(frozen=True, slots=True, eq=False)
class Setpoint:
    """What the position cascade shall do. NaN marks an axis that is not commanded, as PX4 has it.

    An `attitude` goes before all else: position and velocity are not controlled then.
    """

    position_ned_m: FloatArray
    velocity_ned_mps: FloatArray
    acceleration_ned_mps2: FloatArray
    yaw_ned_rad: float
    yaw_rate_ned_radps: float
    attitude: AttitudeSetpoint | None = None


def setpoint_to(
    position_ned_m: Sequence[float],
    velocity_ned_mps: Sequence[float],
    acceleration_ned_mps2: Sequence[float],
    yaw_ned_rad: float,
    yaw_rate_ned_radps: float,
) -> Setpoint:
    """A setpoint of these numbers, three of each: all in one array, which is what costs."""
    axes = vector((*position_ned_m, *velocity_ned_mps, *acceleration_ned_mps2), 9)
    return Setpoint(axes[0:3], axes[3:6], axes[6:9], yaw_ned_rad, yaw_rate_ned_radps)


@dataclass(frozen=True, slots=True, eq=False)
class Demand:
    """What the commander asks of the cascade. Disarmed: motors stand still. `idle`: armed, spinning low."""

    armed: bool
    idle: bool
    setpoint: Setpoint
