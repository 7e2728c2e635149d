"""PX4's Position mode: a setpoint that a pilot's sticks lead, from a joystick at the ground station.

Source: PX4 v1.17, Sticks.cpp and FlightTaskManualPosition.cpp. Where the sticks are let go it stops and stays. Simpler than PX4:
a stick asks for a speed, as with MPC_POS_MODE 0, and not for an acceleration; sticks neither arm nor take over from other
modes (COM_RC_OVERRIDE). And more lenient: in flight PX4 refuses the mode until sticks are heard. Here it is taken, as by a pilot whose
sticks rest in their middle, so that a pilot's hand can be played without a joystick.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from sitl.autopilot.glide import AT_REST_MPS, Glide, climbing, led_across
from sitl.signals import Estimate, Sticks

__all__ = ["led"]


def led(
    glide: Glide, sticks: Sticks, estimate: Estimate, parameters: Mapping[str, float], dt_s: float
) -> Glide:
    """The setpoint `dt_s` later. As long as it moves its place is the vehicle's own: only its speed is followed."""
    dead = parameters["MAN_DEADZONE"]
    forward, right, up, clockwise = (_beyond(deflection, dead) for deflection in sticks)
    north_m, east_m, here_down_m = estimate.position_ned_m.tolist()
    ahead = complex(math.cos(glide.yaw_ned_rad), math.sin(glide.yaw_ned_rad))
    tilt = complex(forward, right)
    wanted_mps = parameters["MPC_VEL_MANUAL"] * ahead * tilt / max(1.0, abs(tilt))
    climb_mps = up * parameters["MPC_Z_VEL_MAX_UP" if up > 0.0 else "MPC_Z_VEL_MAX_DN"]
    jerk_mps3 = parameters["MPC_JERK_MAX"]
    here_m, most_mps2 = complex(north_m, east_m), parameters["MPC_ACC_HOR_MAX"]
    glide = led_across(glide, here_m, wanted_mps, most_mps2, jerk_mps3, dt_s)
    if climb_mps != 0.0 or abs(glide.down_speed_mps) > AT_REST_MPS:
        glide = glide._replace(down_m=here_down_m)
    most_mps2 = parameters["MPC_ACC_UP_MAX" if up > 0.0 else "MPC_ACC_DOWN_MAX"]
    glide = climbing(glide, climb_mps, most_mps2, jerk_mps3, dt_s)
    yaw_rate_radps = clockwise * math.radians(parameters["MPC_MAN_Y_MAX"])
    yaw_ned_rad = math.remainder(glide.yaw_ned_rad + yaw_rate_radps * dt_s, math.tau)
    return glide._replace(yaw_ned_rad=yaw_ned_rad, yaw_rate_ned_radps=yaw_rate_radps)


def _beyond(deflection: float, dead: float) -> float:
    """The deflection beyond the dead zone, which ends where it did."""
    size = min(1.0, abs(deflection))
    return math.copysign(max(0.0, size - dead) / (1.0 - dead), deflection)
