"""What faults do to the body, the air and the senses: written into the world between two frames."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sitl.airframe import Airframe
from sitl.faults import (
    BaroStep,
    BatteryLevel,
    Fault,
    GpsDrift,
    GpsJump,
    GpsLoss,
    GpsMultipath,
    MagDisturbance,
    MotorLoss,
    SensorStuck,
    WindStep,
)
from sitl.physics.sensors import STUCK_BITS

__all__ = ["afflict", "discharge"]


def afflict(
    world: np.ndarray, airframe: Airframe, wind_ned_mps: Sequence[float], active: Sequence[Fault]
) -> bool:
    """Make a sound `world` what the active faults make of it; whether fixes are received.

    The wind that rises comes along the wind that blows, or from the west in a calm. Faults add up.
    """
    plant, sensed = world["plant"][0], world["sensed"][0]
    wind = np.array(wind_ned_mps, dtype=np.float64)
    mean_mps = math.hypot(wind[0], wind[1])
    downwind = wind / mean_mps if mean_mps > 0.0 else np.array([0.0, 1.0, 0.0])
    plant["thrust_n_per_radps2"] = airframe.rotors.thrust_n_per_radps2
    for name in ("fix_offset_m", "fix_drift_mps", "multipath_sigma_m", "baro_offset_m", "stuck"):
        sensed[name] = 0
    sensed["disturbance_ned_gauss"] = 0.0
    received = True
    for fault in active:
        match fault:
            case MotorLoss():
                plant["thrust_n_per_radps2"][fault.motor - 1] *= fault.thrust_left
            case GpsLoss():
                received = False
            case GpsJump():
                sensed["fix_offset_m"] += fault.distance_m
            case GpsDrift():
                sensed["fix_drift_mps"] += fault.speed_mps
            case GpsMultipath():
                sensed["multipath_sigma_m"] = math.hypot(sensed["multipath_sigma_m"], fault.sigma_m)
            case BaroStep():
                sensed["baro_offset_m"] += fault.step_m
            case MagDisturbance():
                sensed["disturbance_ned_gauss"][1] += fault.field_gauss
            case SensorStuck():
                sensed["stuck"] |= STUCK_BITS[fault.sensor]
            case WindStep():
                wind += fault.speed_mps * downwind
    if not any(isinstance(fault, GpsDrift) for fault in active):
        sensed["fix_drift_m"] = 0.0
    world["air"]["mean_wind_ned_mps"] = wind
    return received


def discharge(world: np.ndarray, beginning: Sequence[Fault]) -> None:
    """Take out of the pack what the faults that begin now want it to lack."""
    pack = world["pack"][0]
    for fault in beginning:
        if isinstance(fault, BatteryLevel):
            pack["used_ah"] = (1.0 - fault.remaining) * pack["capacity_ah"]
