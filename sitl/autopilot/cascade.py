"""The cascade: setpoint to motors through position, velocity, attitude, rate and mixer, at 400 Hz."""

from __future__ import annotations

import math
from collections.abc import Iterable
from struct import Struct

import numpy as np

from sitl.airframe import Airframe
from sitl.autopilot.attitude import attitude_for, control_attitude
from sitl.autopilot.mixer import mix, mix_columns, signal_for
from sitl.autopilot.position import control_position
from sitl.autopilot.rate import control_rate, low_pass
from sitl.autopilot.velocity import control_velocity
from sitl.geo import GRAVITY_MPS2
from sitl.kernels import kernel
from sitl.params import Params
from sitl.rotation import to_yaw
from sitl.signals import AttitudeSetpoint, Demand, FloatArray

__all__ = [
    "CASCADE_S",
    "DEMAND",
    "GAINS",
    "MIND",
    "control",
    "detect_ground",
    "new_mind",
    "set_demand",
    "set_gains",
]

CASCADE_S = 0.0025
_GYRO_HZ = 200.0

DEMAND = np.dtype(
    [
        ("armed", "i8"),
        ("idle", "i8"),
        ("position_ned_m", "f8", 3),
        ("velocity_ned_mps", "f8", 3),
        ("acceleration_ned_mps2", "f8", 3),
        ("yaw_ned_rad", "f8"),
        ("yaw_rate_ned_radps", "f8"),
        ("by", "i8"),
        ("q_ned_frd", "f8", 4),
        ("rate_frd_radps", "f8", 3),
        ("thrust", "f8"),
    ]
)
_DEMAND_NUMBERS = Struct("=2q11dq8d")
"""A DEMAND's numbers in their order: written in one call, which costs a third of what numpy's assignment does."""
_BY_POSITION, _BY_ATTITUDE, _BY_RATE = 0, 1, 2
_LEVEL = (1.0, 0.0, 0.0, 0.0)
_STILL = (0.0, 0.0, 0.0)
_NO_ATTITUDE = _BY_POSITION, *_LEVEL, *_STILL, 0.0

GAINS = np.dtype(
    [
        ("position_p", "f8", 3),
        ("speed_max_mps", "f8"),
        ("climb_max_mps", "f8"),
        ("descent_max_mps", "f8"),
        ("velocity_p", "f8", 3),
        ("velocity_i", "f8", 3),
        ("velocity_d", "f8", 3),
        ("velocity_slope_alpha", "f8"),
        ("thrust_hover", "f8"),
        ("thrust_min", "f8"),
        ("thrust_max", "f8"),
        ("thrust_margin", "f8"),
        ("steepest_mps2", "f8"),  # across, at the greatest tilt
        ("attitude_p", "f8", 3),
        ("yaw_weight", "f8"),
        ("rate_max_radps", "f8", 3),
        ("rate_p", "f8", 3),
        ("rate_i", "f8", 3),
        ("rate_d", "f8", 3),
        ("rate_ff", "f8", 3),
        ("rate_integral_max", "f8", 3),
        ("rate_slope_alpha", "f8"),
        ("gyro", "f8", 5),
        ("yaw_torque_alpha", "f8"),
        ("thrust_model", "f8"),
        ("signal_idle", "f8"),
        ("mix", "f8", (4, 4)),
        ("land_climb_mps", "f8"),
        ("land_speed_mps", "f8"),
        ("land_rate_radps", "f8"),
        ("land_time_s", "f8"),
    ]
)

MIND = np.dtype(
    [
        ("correction_ned_mps", "f8", 3),
        ("velocity_wanted_ned_mps", "f8", 3),
        ("velocity_error", "f8", 3),
        ("velocity_integral", "f8", 3),
        ("velocity_before", "f8", 3),
        ("velocity_slope", "f8", 3),
        ("acceleration_wanted_ned_mps2", "f8", 3),
        ("thrust_ned", "f8", 3),
        ("q_wanted_ned_frd", "f8", 4),
        ("rate_wanted_frd_radps", "f8", 3),
        ("rate_frd_radps", "f8", 3),
        ("rate_slope", "f8", 3),
        ("rate_integral", "f8", 3),
        ("gyro_delay", "f8", (3, 2)),
        ("torque", "f8", 3),
        ("yaw_torque", "f8"),
        ("thrust", "f8"),
        ("saturated", "i8", 3),
        ("motors", "f8", 4),  # thrust, 0…1
        ("signals", "f8", 4),  # what the speed controllers get, 0…1
        ("still_s", "f8"),
        ("on_ground", "i8"),
    ]
)
"""What the cascade remembers and last decided."""


def set_demand(place: memoryview, demand: Demand) -> None:
    """Write `demand` into a DEMAND, of which these are the bytes."""
    setpoint = demand.setpoint
    attitude = setpoint.attitude
    _DEMAND_NUMBERS.pack_into(
        place,
        0,
        demand.armed,
        demand.idle,
        *setpoint.position_ned_m,
        *setpoint.velocity_ned_mps,
        *setpoint.acceleration_ned_mps2,
        setpoint.yaw_ned_rad,
        setpoint.yaw_rate_ned_radps,
        *(_NO_ATTITUDE if attitude is None else _numbers(attitude)),
    )


def _numbers(attitude: AttitudeSetpoint) -> Iterable[float]:
    """What the cascade begins with, then the attitude, the rates and the thrust."""
    q = attitude.q_ned_frd
    by, q_ned_frd = (_BY_RATE, _LEVEL) if q is None else (_BY_ATTITUDE, q.tolist())
    return by, *q_ned_frd, *attitude.rate_frd_radps.tolist(), attitude.thrust


def set_gains(record: np.ndarray, params: Params, airframe: Airframe) -> None:
    """Write PX4's parameters into a GAINS."""
    g = record[0]

    def triple(xy: str, z: str) -> tuple[float, float, float]:
        return params[xy], params[xy], params[z]

    def axes(name: str) -> tuple[float, float, float]:
        return params[name.format("ROLL")], params[name.format("PITCH")], params[name.format("YAW")]

    def alpha(cutoff: str, dt: float) -> float:
        return dt / (dt + 1.0 / (2.0 * math.pi * params[cutoff]))

    g["position_p"] = triple("MPC_XY_P", "MPC_Z_P")
    g["speed_max_mps"] = params["MPC_XY_VEL_MAX"]
    g["climb_max_mps"], g["descent_max_mps"] = params["MPC_Z_VEL_MAX_UP"], params["MPC_Z_VEL_MAX_DN"]
    g["velocity_p"] = triple("MPC_XY_VEL_P_ACC", "MPC_Z_VEL_P_ACC")
    g["velocity_i"] = triple("MPC_XY_VEL_I_ACC", "MPC_Z_VEL_I_ACC")
    g["velocity_d"] = triple("MPC_XY_VEL_D_ACC", "MPC_Z_VEL_D_ACC")
    g["velocity_slope_alpha"] = alpha("MPC_VELD_LP", CASCADE_S)
    g["thrust_hover"], g["thrust_margin"] = params["MPC_THR_HOVER"], params["MPC_THR_XY_MARG"]
    g["thrust_min"], g["thrust_max"] = params["MPC_THR_MIN"], params["MPC_THR_MAX"]
    g["steepest_mps2"] = GRAVITY_MPS2 * math.tan(math.radians(params["MPC_TILTMAX_AIR"]))
    g["attitude_p"] = axes("MC_{}_P")
    g["yaw_weight"] = params["MC_YAW_WEIGHT"]
    g["rate_max_radps"] = np.radians(axes("MC_{}RATE_MAX"))
    g["rate_p"], g["rate_i"] = axes("MC_{}RATE_P"), axes("MC_{}RATE_I")
    g["rate_d"], g["rate_ff"] = axes("MC_{}RATE_D"), axes("MC_{}RATE_FF")
    g["rate_integral_max"] = params["MC_RR_INT_LIM"], params["MC_PR_INT_LIM"], params["MC_YR_INT_LIM"]
    g["rate_slope_alpha"] = alpha("IMU_DGYRO_CUTOFF", 1.0 / _GYRO_HZ)
    g["gyro"] = low_pass(_GYRO_HZ, params["IMU_GYRO_CUTOFF"])
    g["yaw_torque_alpha"] = alpha("MC_YAW_TQ_CUTOFF", CASCADE_S)
    g["thrust_model"], g["signal_idle"] = params["THR_MDL_FAC"], airframe.rotors.idle
    g["mix"] = mix_columns(airframe.rotors)
    g["land_climb_mps"], g["land_speed_mps"] = params["LNDMC_Z_VEL_MAX"], params["LNDMC_XY_VEL_MAX"]
    g["land_rate_radps"] = math.radians(params["LNDMC_ROT_MAX"])
    g["land_time_s"] = params["LNDMC_TRIG_TIME"]


def new_mind() -> np.ndarray:
    """One MIND, on the ground with nothing decided."""
    mind = np.zeros(1, MIND)
    mind["q_wanted_ned_frd"] = 1.0, 0.0, 0.0, 0.0
    mind["on_ground"] = 1
    return mind


@kernel
def _rest(mind: np.record, armed: bool, idle: float, velocity_ned_mps: FloatArray) -> None:
    """Motors still, or idling when armed; nothing is integrated, nothing remembered."""
    for i in range(3):
        mind.velocity_integral[i] = 0.0
        mind.velocity_before[i] = velocity_ned_mps[i]
        mind.velocity_slope[i] = 0.0
        mind.rate_integral[i] = 0.0
        mind.torque[i] = 0.0
    mind.yaw_torque = 0.0
    mind.thrust = 0.0
    for i in range(4):
        mind.motors[i] = 0.0
        mind.signals[i] = idle if armed else 0.0


@kernel
def _steer_by_attitude(
    mind: np.record,
    gains: np.record,
    demand: np.record,
    velocity_ned_mps: FloatArray,
    q_ned_frd: FloatArray,
) -> None:
    """Set thrust and wanted rates as demanded; position and velocity control rest."""
    for i in range(3):
        mind.velocity_before[i] = velocity_ned_mps[i]
        mind.velocity_slope[i] = 0.0
    mind.thrust = min(max(demand.thrust, 0.0), 1.0)
    if demand.by == _BY_ATTITUDE:
        for i in range(4):
            mind.q_wanted_ned_frd[i] = demand.q_ned_frd[i]
        control_attitude(mind, gains, q_ned_frd, demand.rate_frd_radps[2])
        return
    for i in range(3):
        limit = gains.rate_max_radps[i]
        mind.rate_wanted_frd_radps[i] = min(max(demand.rate_frd_radps[i], -limit), limit)


@kernel
def control(
    mind: np.record,
    gains: np.record,
    demand: np.record,
    position_ned_m: FloatArray,
    velocity_ned_mps: FloatArray,
    q_ned_frd: FloatArray,
) -> None:
    """One pass through the cascade: `mind.signals` is what the motors are told."""
    if not demand.armed or demand.idle:
        _rest(mind, demand.armed != 0, gains.signal_idle, velocity_ned_mps)
        return
    if demand.by == _BY_POSITION:
        control_position(mind, gains, demand, position_ned_m)
        control_velocity(mind, gains, demand, velocity_ned_mps, CASCADE_S)
        yaw = to_yaw(q_ned_frd) if math.isnan(demand.yaw_ned_rad) else demand.yaw_ned_rad
        q = attitude_for(mind.thrust_ned, yaw)
        for i in range(4):
            mind.q_wanted_ned_frd[i] = q[i]
        yaw_rate = 0.0 if math.isnan(demand.yaw_rate_ned_radps) else demand.yaw_rate_ned_radps
        control_attitude(mind, gains, q_ned_frd, yaw_rate)
        t = mind.thrust_ned
        mind.thrust = math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
    else:
        _steer_by_attitude(mind, gains, demand, velocity_ned_mps, q_ned_frd)
    control_rate(mind, gains, CASCADE_S)
    mix(gains.mix, mind.torque, mind.thrust, mind.motors, mind.saturated)
    for i in range(4):
        mind.signals[i] = max(gains.signal_idle, signal_for(mind.motors[i], gains.thrust_model))


@kernel
def detect_ground(mind: np.record, gains: np.record, velocity_ned_mps: FloatArray, dt: float) -> None:
    """Set `mind.on_ground`: little thrust and hardly any motion for LNDMC_TRIG_TIME; thrust alone lifts it.

    Little is, as in PX4, below three tenths of the way from least to hover thrust.
    """
    little = gains.thrust_min + 0.3 * (gains.thrust_hover - gains.thrust_min)
    if mind.thrust > little:
        mind.still_s = 0.0
        # On the ground until the motors carry most of the weight: a take-off not yet happened is no flight.
        if mind.thrust > 0.7 * gains.thrust_hover:
            mind.on_ground = 0
        return
    v, w = velocity_ned_mps, mind.rate_frd_radps
    still = (
        abs(v[2]) < gains.land_climb_mps
        and math.hypot(v[0], v[1]) < gains.land_speed_mps
        and w[0] * w[0] + w[1] * w[1] + w[2] * w[2] < gains.land_rate_radps**2
    )
    mind.still_s = mind.still_s + dt if still else 0.0
    if mind.still_s >= gains.land_time_s:
        mind.on_ground = 1
