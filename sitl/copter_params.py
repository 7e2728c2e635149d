"""ArduCopter's parameters: names, defaults of 4.6.3's SITL quadrotor, and what the body's control makes of them."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from importlib import resources

from sitl.params import Params

__all__ = ["body_params", "copter_defaults"]

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

The rate loops keep the airframe's own gains, which have other units in ArduPilot.
"""
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


def body_params(values: Mapping[str, float], airframe: Params) -> Params:
    """What the body's control obeys when ArduPilot's parameters are `values`."""
    return airframe.replace(
        **{ours: max(values[theirs], _LEAST) for ours, theirs in _SAME.items()},
        MPC_TILTMAX_AIR=min(max(0.01 * values["ANGLE_MAX"], _LEAST_TILT_DEG), _MOST_TILT_DEG),
        MPC_XY_VEL_MAX=_FREE_MPS,
        MPC_Z_VEL_MAX_UP=_FREE_MPS,
        MPC_Z_VEL_MAX_DN=_FREE_MPS,
        LNDMC_XY_VEL_MAX=_FREE_MPS,
        MAV_SYS_ID=int(values["SYSID_THISMAV"]),
    )
