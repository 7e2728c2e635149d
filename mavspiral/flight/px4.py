"""PX4, as v1.17 was seen to behave.

DO_SET_MODE is answered by two ACKs, of which only the second is the commander's: the HEARTBEAT alone tells.
NAV_TAKEOFF wants a height above mean sea level, and NaN for "here". Without setpoints for COM_OF_LOSS_T it
does what COM_OBL_RC_ACT says, and takes up OFFBOARD again by itself when they come back. It does not
interpolate between setpoints; with all feedforwards sent it lagged by 0.02 s without drag, 0.06 s with some.
Its yaw rate comes later than that, because motors turn a quadrotor slowly: round the kiosk the bundled one's heading is within
6.3° (p95) when the rate is sent with the yaw, 2.4° when it is that of 0.3 s later, 1.2° of 0.4 s; a stiffer one would overshoot.
"""

from __future__ import annotations

import math

from mavspiral.flight.messages import Command, MessageId, TypeMask
from mavspiral.flight.profile import Mode, Profile

__all__ = ["PX4"]

_CUSTOM_MODE_ENABLED = 1
_AUTO = 4
_RETURN = 3
_NEEDS_NOBODY = frozenset({3, 4, 5})
_EXCEPT_OFFBOARD = 4  # a bit of COM_RCL_EXCEPT: no pilot's sticks are missed in OFFBOARD
_ACTS = frozenset({1, 2, 3})  # of COM_LOW_BAT_ACT: it returns, lands, or returns and in the end lands
_RETURN_OR_LAND = 3
_LOSS_S = 1.0


def _mode(name: str, main: int, sub: int = 0) -> Mode:
    return Mode(name, main << 16 | sub << 24, (_CUSTOM_MODE_ENABLED, main, sub))


def _takeoff_params(alt_amsl_m: float, _height_home_m: float) -> tuple[float, ...]:
    return (0.0, 0.0, 0.0, math.nan, math.nan, math.nan, alt_amsl_m)


def _gimbal(pitch_deg: float) -> tuple[Command, tuple[float, ...]]:
    """Yaw 0 is the vehicle's own; rates are left to the gimbal."""
    return Command.DO_GIMBAL_MANAGER_PITCHYAW, (pitch_deg, 0.0, math.nan, math.nan)


PX4 = Profile(
    name="PX4",
    autopilot=12,
    type_mask=TypeMask(0),
    coordinate_frame=1,  # MAV_FRAME_LOCAL_NED
    follow=_mode("OFFBOARD", 6),
    hold=_mode("AUTO.LOITER", _AUTO, 3),
    land=_mode("AUTO.LAND", _AUTO, 6),
    go_home=_mode("AUTO.RTL", _AUTO, 5),
    climb=(_mode("AUTO.TAKEOFF", _AUTO, 2), _mode("AUTO.LOITER", _AUTO, 3)),
    arm_in=None,
    camera_id=100,  # MAV_COMP_ID_CAMERA
    gimbal=_gimbal,
    takeoff_mode=_mode("AUTO.TAKEOFF", _AUTO, 2),
    other_modes=(
        _mode("MANUAL", 1),
        _mode("ALTCTL", 2),
        _mode("POSCTL", 3),
        _mode("ACRO", 5),
        _mode("STABILIZED", 7),
        _mode("AUTO.MISSION", _AUTO, 4),
    ),
    telemetry_hz={
        MessageId.LOCAL_POSITION_NED: 50.0,
        MessageId.ATTITUDE: 10.0,
        MessageId.EXTENDED_SYS_STATE: 2.0,
        MessageId.GPS_RAW_INT: 5.0,
        MessageId.SYS_STATUS: 1.0,
    },
    kept=frozenset(
        {
            MessageId.HEARTBEAT,
            MessageId.PARAM_VALUE,
            MessageId.MISSION_CURRENT,  # no stream: PX4 goes on sending it whatever one asks
            MessageId.GPS_GLOBAL_ORIGIN,
            MessageId.COMMAND_ACK,
            MessageId.CAMERA_IMAGE_CAPTURED,
            MessageId.AUTOPILOT_VERSION,
            MessageId.STATUSTEXT,
        }
    ),
    quiet=frozenset(
        {
            MessageId.ATTITUDE_TARGET,
            MessageId.POSITION_TARGET_LOCAL_NED,
            MessageId.POSITION_TARGET_GLOBAL_INT,
        }
    ),
    lead_s=0.02,
    tilt_lead_s=0.12,
    turn_lead_s=0.3,
    pre_stream_s=1.0,
    takeoff_params=_takeoff_params,
    takeoff_from_home=False,
    takeoff_within_m=1.0,
    speed_parameters=("MPC_XY_VEL_MAX", "MPC_Z_VEL_MAX_UP", "MPC_Z_VEL_MAX_DN"),
    acceleration_parameter=None,
    parameter_units={},
    integers_bytewise=True,
    loss_timeout="COM_OF_LOSS_T",
    loss_action="COM_OBL_RC_ACT",
    loss_actions={
        0: "Position mode, which needs a pilot's sticks",
        1: "Altitude mode, which needs a pilot's sticks",
        2: "Stabilized mode, which needs a pilot's sticks",
        3: "Return",
        4: "Land",
        5: "Hold",
        6: "Terminate",
        7: "Disarm",
    },
    safe_loss_actions=_NEEDS_NOBODY,
    long_loss_s=3.0,
    loss_listens_to=None,
    return_height="RTL_RETURN_ALT",
    failsafes={
        "COM_OF_LOSS_T": lambda now_s, _: min(now_s, _LOSS_S),
        "COM_OBL_RC_ACT": lambda now, _: now if now in _NEEDS_NOBODY else _RETURN,
        "COM_RCL_EXCEPT": lambda now, _: int(now) | _EXCEPT_OFFBOARD,
        "RTL_RETURN_ALT": lambda now_m, safe_m: max(now_m, float(math.ceil(safe_m))),
        "RTL_CONE_ANG": lambda _now, _safe: 0,
        "RTL_TYPE": lambda _now, _safe: 0,
        "COM_LOW_BAT_ACT": lambda now, _: now if now in _ACTS else _RETURN_OR_LAND,
        "COM_TAKEOFF_ACT": lambda _now, _safe: 0,
    },
    pitfalls={
        "COM_RCL_EXCEPT": "it leaves OFFBOARD when the pilot's sticks are lost, or where there are none",
        "RTL_CONE_ANG": "near home its own Return stays below RTL_RETURN_ALT, maybe beside the building",
        "RTL_TYPE": "its own Return may follow a mission that it still holds, instead of the straight way home",
        "COM_LOW_BAT_ACT": "an empty battery it only warns of",
        "COM_TAKEOFF_ACT": "after its take-off it flies a mission that it still holds, not this one",
    },
    forbidding=frozenset({"COM_TAKEOFF_ACT"}),
    low_battery=(
        "COM_LOW_BAT_ACT",
        "a battery that fails at once (below BAT_CRIT_THR) is its own affair: it returns straight over the building, and "
        "lands where it is below BAT_EMERGEN_THR, be it on a roof; take over if it would",
    ),
    # NAV_DLL_ACT is no way out: it waits for the heartbeat of a ground station, which we are not.
    unguarded="until it flies by our setpoints (OFFBOARD), none of its failsafes acts if mavspiral dies or its link breaks: "
    "it ends its climb and hovers above home; then land it yourself (AUTO.LAND)",
    damping="MPC_XY_VEL_D_ACC",
    feels_drag=True,
)
