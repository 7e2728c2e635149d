"""PX4's parameters, as far as this vehicle obeys them: its names, the defaults of v1.17.0's SIH quadrotor."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Final

__all__ = ["DEFAULTS", "Params"]

DEFAULTS: Final[Mapping[str, float | int]] = {
    "BAT_CRIT_THR": 0.07,
    "BAT_EMERGEN_THR": 0.05,
    "BAT_LOW_THR": 0.15,
    "COM_DISARM_LAND": 2.0,
    "COM_DISARM_PRFLT": 10.0,
    "COM_DL_LOSS_T": 10,
    "COM_FAIL_ACT_T": 5.0,
    "COM_LOW_BAT_ACT": 3,
    "COM_OBL_RC_ACT": 0,
    "COM_OF_LOSS_T": 1.0,
    "COM_POS_FS_EPH": 5.0,
    "COM_RCL_EXCEPT": 0,
    "COM_SPOOLUP_TIME": 1.0,
    "COM_VEL_FS_EVH": 1.0,
    "EKF2_BARO_GATE": 5.0,
    "EKF2_GPS_P_GATE": 5.0,
    "EKF2_GPS_V_GATE": 5.0,
    "EKF2_MAG_GATE": 3.0,
    "IMU_DGYRO_CUTOFF": 20.0,
    "IMU_GYRO_CUTOFF": 40.0,
    "LNDMC_ROT_MAX": 20.0,
    "LNDMC_TRIG_TIME": 1.0,
    "LNDMC_XY_VEL_MAX": 1.5,
    "LNDMC_Z_VEL_MAX": 0.25,
    "MAV_SYS_ID": 1,
    "MC_PITCHRATE_D": 0.003,
    "MC_PITCHRATE_FF": 0.0,
    "MC_PITCHRATE_I": 0.2,
    "MC_PITCHRATE_MAX": 220.0,
    "MC_PITCHRATE_P": 0.15,
    "MC_PITCH_P": 4.0,
    "MC_PR_INT_LIM": 0.3,
    "MC_ROLLRATE_D": 0.003,
    "MC_ROLLRATE_FF": 0.0,
    "MC_ROLLRATE_I": 0.2,
    "MC_ROLLRATE_MAX": 220.0,
    "MC_ROLLRATE_P": 0.15,
    "MC_ROLL_P": 4.0,
    "MC_RR_INT_LIM": 0.3,
    "MC_YAWRATE_D": 0.0,
    "MC_YAWRATE_FF": 0.0,
    "MC_YAWRATE_I": 0.1,
    "MC_YAWRATE_MAX": 200.0,
    "MC_YAWRATE_P": 0.2,
    "MC_YAW_P": 2.8,
    "MC_YAW_TQ_CUTOFF": 2.0,
    "MC_YAW_WEIGHT": 0.4,
    "MC_YR_INT_LIM": 0.3,
    "MIS_DIST_1WP": 900.0,
    "MIS_MNT_YAW_CTL": 0,
    "MIS_TAKEOFF_ALT": 2.5,
    "MIS_TKO_LAND_REQ": 0,
    "MIS_YAW_ERR": 12.0,
    "MIS_YAW_TMT": -1.0,
    "MPC_ACC_HOR": 3.0,
    "MPC_JERK_AUTO": 4.0,
    "MPC_LAND_ALT1": 10.0,
    "MPC_LAND_ALT2": 5.0,
    "MPC_LAND_SPEED": 0.7,
    "MPC_THR_HOVER": 0.5,
    "MPC_THR_MAX": 1.0,
    "MPC_THR_MIN": 0.12,
    "MPC_THR_XY_MARG": 0.3,
    "MPC_TILTMAX_AIR": 45.0,
    "MPC_TKO_RAMP_T": 3.0,
    "MPC_TKO_SPEED": 1.5,
    "MPC_VELD_LP": 5.0,
    "MPC_XY_CRUISE": 5.0,
    "MPC_XY_ERR_MAX": 2.0,
    "MPC_XY_P": 0.95,
    "MPC_XY_TRAJ_P": 0.5,
    "MPC_XY_VEL_D_ACC": 0.2,
    "MPC_XY_VEL_I_ACC": 0.4,
    "MPC_XY_VEL_MAX": 12.0,
    "MPC_XY_VEL_P_ACC": 1.8,
    "MPC_YAWRAUTO_ACC": 20.0,
    "MPC_YAWRAUTO_MAX": 60.0,
    "MPC_YAW_MODE": 0,
    "MPC_Z_P": 1.0,
    "MPC_Z_VEL_D_ACC": 0.0,
    "MPC_Z_VEL_I_ACC": 2.0,
    "MPC_Z_VEL_MAX_DN": 1.5,
    "MPC_Z_VEL_MAX_UP": 3.0,
    "MPC_Z_VEL_P_ACC": 4.0,
    "MPC_Z_V_AUTO_DN": 1.5,
    "MPC_Z_V_AUTO_UP": 3.0,
    "NAV_ACC_RAD": 2.0,
    "NAV_DLL_ACT": 0,
    "NAV_MC_ALT_RAD": 0.8,
    "NAV_RCL_ACT": 2,
    "RTL_CONE_ANG": 45,
    "RTL_DESCEND_ALT": 10.0,
    "RTL_LAND_DELAY": 0.0,
    "RTL_MIN_DIST": 10.0,
    "RTL_RETURN_ALT": 30.0,
    "SYS_FAILURE_EN": 0,
    "THR_MDL_FAC": 0.0,
}
"""Name to default. A float here is a REAL32 on the link, an int an INT32.

PX4's list of 878 lacks MIS_DIST_1WP and MIS_TKO_LAND_REQ, since it tells what has been looked up (`param_find`) and looks
these two up with the first mission that it checks (FeasibilityChecker.cpp); by name it answers at any time. Here they are told at once.
"""


class Params(Mapping[str, float | int]):
    """Parameters by PX4's names: a value that never changes; `replace` gives another.

    Raises:
        KeyError: a name that is not in `DEFAULTS`; the closest ones are named.
        TypeError: a value that is no number, or a fraction where PX4 has an INT32.
    """

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[str, float | int] | None = None) -> None:
        self._values = dict(DEFAULTS)
        for name, value in (values or {}).items():
            self._values[name] = _checked(name, value)

    def replace(self, **values: float) -> Params:
        """These parameters with some of them changed."""
        return Params({**self._values, **values})

    def __getitem__(self, name: str) -> float | int:  # noqa: D105
        try:
            return self._values[name]
        except KeyError:
            raise KeyError(_unknown(name)) from None

    def __iter__(self) -> Iterator[str]:  # noqa: D105
        return iter(self._values)

    def __len__(self) -> int:  # noqa: D105
        return len(self._values)


def _checked(name: str, value: float) -> float | int:
    if name not in DEFAULTS:
        raise KeyError(_unknown(name))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{name} is a number, got {value!r}")
    if isinstance(DEFAULTS[name], float):
        return float(value)
    if value != int(value):
        raise TypeError(f"{name} is an INT32, got {value!r}")
    return int(value)


def _unknown(name: str) -> str:
    close = difflib.get_close_matches(name, DEFAULTS, n=3)
    return f"no parameter {name!r}" + (f"; close: {', '.join(close)}" if close else "")
