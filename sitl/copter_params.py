"""ArduCopter's parameters: names, defaults of 4.6.3's SITL quadrotor, and what the body's control makes of them."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from importlib import resources

from sitl.airframe import Airframe
from sitl.params import Params

__all__ = ["body_params", "copter_defaults", "yaw_gain"]

_SAME: Mapping[str, str] = {
    "MPC_XY_P": "PSC_POSXY_P",
    "MPC_Z_P": "PSC_POSZ_P",
    "MPC_XY_VEL_P_ACC": "PSC_VELXY_P",
    "MPC_XY_VEL_I_ACC": "PSC_VELXY_I",
    "MPC_XY_VEL_D_ACC": "PSC_VELXY_D",
    "MPC_VELD_LP": "PSC_VELXY_FLTD",
    "MC_ROLL_P": "ATC_ANG_RLL_P",
    "MC_PITCH_P": "ATC_ANG_PIT_P",
    "MC_YAW_P": "ATC_ANG_YAW_P",
}
"""The body's parameters, by PX4's names, and ArduPilot's of the same meaning and unit.

The rate loops of roll and pitch keep the airframe's own gains, which have other units in ArduPilot.
"""
_YAW_RATE: Mapping[str, str] = {
    "MC_YAWRATE_P": "ATC_RAT_YAW_P",
    "MC_YAWRATE_I": "ATC_RAT_YAW_I",
    "MC_YAWRATE_D": "ATC_RAT_YAW_D",
    "MC_YAWRATE_FF": "ATC_RAT_YAW_FF",
    "MC_YR_INT_LIM": "ATC_RAT_YAW_IMAX",
}
_SITL_YAW_RADPS2 = 13.2
"""What ArduPilot's whole yaw output does to its SITL's quadrotor, for which its gains are tuned.

Source: ArduPilot 4.6, SIM_Frame.cpp, SIM_Motor.cpp: four motors, each turned by half of the output; torque 0.05 · 0.35 m · T · c, with
T = 3.0 kg · g / 4 / 0.39 · t and the command c of thrust t by an expo of 0.65, at hover; inertia 3.0 kg / 2 · (0.175 m)².
"""
_UNFILTERED_HZ = 1000.0
_LEAST, _LEAST_TILT_DEG, _MOST_TILT_DEG = 1e-3, 10.0, 80.0
"""Whatever a ground station sets, nothing is divided by zero."""
_FREE_MPS = 30.0
"""ArduPilot limits what it shapes, not what its position loop asks for; nor does its land detector mind a speed over the ground."""


@functools.cache
def copter_defaults() -> Mapping[str, float]:
    """Name to default, in ArduPilot's order."""
    text = resources.files("sitl").joinpath("arducopter.toml").read_text(encoding="utf-8")
    rows = (line.split(" = ") for line in text.splitlines() if not line.startswith("#"))
    return {name: float(value) for name, value in rows}


def yaw_gain(airframe: Airframe) -> float:
    """By how much ArduPilot's gains of the yaw rate are greater for this body than for its SITL's: both turn alike."""
    rotors = airframe.rotors
    torque_nm = 4.0 * rotors.torque_per_thrust_m * rotors.thrust_n_per_radps2 * rotors.speed_max_radps**2
    return _SITL_YAW_RADPS2 * float(airframe.body.inertia_kgm2[2]) / torque_nm


def body_params(values: Mapping[str, float], airframe: Params, yaw: float) -> Params:
    """What the body's control obeys when ArduPilot's parameters are `values`; `yaw` is its `yaw_gain`."""
    return airframe.replace(
        **{ours: max(values[theirs], _LEAST) for ours, theirs in _SAME.items()},
        **{ours: yaw * max(values[theirs], 0.0) for ours, theirs in _YAW_RATE.items()},
        # A low-pass on the error or, as PX4 has it, on the torque: of a linear loop the same.
        MC_YAW_TQ_CUTOFF=max(values["ATC_RAT_YAW_FLTE"], 0.0) or _UNFILTERED_HZ,
        MPC_TILTMAX_AIR=min(max(0.01 * values["ANGLE_MAX"], _LEAST_TILT_DEG), _MOST_TILT_DEG),
        MPC_XY_VEL_MAX=_FREE_MPS,
        MPC_Z_VEL_MAX_UP=_FREE_MPS,
        MPC_Z_VEL_MAX_DN=_FREE_MPS,
        LNDMC_XY_VEL_MAX=_FREE_MPS,
        MAV_SYS_ID=int(values["SYSID_THISMAV"]),
    )
