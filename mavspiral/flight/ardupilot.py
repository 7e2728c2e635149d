"""ArduCopter, as 4.6.3 was seen to behave.

It follows setpoints in GUIDED, takes off there by NAV_TAKEOFF (a height above home), and drops a take-off when a setpoint
comes in. It sends nothing that it was not asked for, and forgets what it was asked for before it has booted. It
arms half a minute after it says that it can: only its answer to arming tells. Between setpoints it goes on along
their velocity and acceleration by itself, and shapes what it is told: an acceleration that is not the motion's
own would move its target. Without setpoints it goes on for GUID_TIMEOUT, then holds; only the loss of a ground station's
heartbeat has a failsafe. Since 4.7 its parameters are in SI units, under names that tell it.
"""

from __future__ import annotations

import math
from dataclasses import replace

from mavspiral.flight.messages import Command, MessageId, TypeMask
from mavspiral.flight.packing import SYSTEM_ID
from mavspiral.flight.profile import Mode, Profile

__all__ = ["ARDUPILOT"]

_CUSTOM_MODE_ENABLED = 1
_CENTI = 0.01
_RTL, _NEEDS_NOBODY = 1.0, frozenset({1, 3, 4, 5})
_LOSS_S = 1.0


def _mode(name: str, number: int) -> Mode:
    return Mode(name, number, (_CUSTOM_MODE_ENABLED, number, 0))


def _gimbal(pitch_deg: float) -> tuple[Command, tuple[float, ...]]:
    """Yaw 0 is the vehicle's own; rates are left to the gimbal."""
    return Command.DO_GIMBAL_MANAGER_PITCHYAW, (pitch_deg, 0.0, math.nan, math.nan)


def _takeoff_params(_alt_amsl_m: float, height_home_m: float) -> tuple[float, ...]:
    return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, height_home_m)


_GUIDED = _mode("GUIDED", 4)

_BEFORE_4_7 = Profile(
    name="ArduPilot",
    autopilot=3,
    type_mask=TypeMask(0),
    coordinate_frame=1,  # MAV_FRAME_LOCAL_NED
    follow=_GUIDED,
    hold=_mode("BRAKE", 17),
    land=_mode("LAND", 9),
    go_home=_mode("RTL", 6),
    climb=(_GUIDED,),
    arm_in=_GUIDED,
    camera_id=1,  # the autopilot drives the camera itself
    gimbal=_gimbal,
    takeoff_mode=None,
    other_modes=(
        _mode("STABILIZE", 0),
        _mode("ACRO", 1),
        _mode("ALT_HOLD", 2),
        _mode("AUTO", 3),
        _mode("LOITER", 5),
        _mode("CIRCLE", 7),
        _mode("DRIFT", 11),
        _mode("SPORT", 13),
        _mode("FLIP", 14),
        _mode("AUTOTUNE", 15),
        _mode("POSHOLD", 16),
        _mode("THROW", 18),
        _mode("AVOID_ADSB", 19),
        _mode("GUIDED_NOGPS", 20),
        _mode("FLOWHOLD", 22),
        _mode("FOLLOW", 23),
        _mode("ZIGZAG", 24),
        _mode("AUTO_RTL", 27),
        _mode("SMART_RTL", 21),
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
            MessageId.GPS_GLOBAL_ORIGIN,
            MessageId.COMMAND_ACK,
            MessageId.TIMESYNC,
            MessageId.AUTOPILOT_VERSION,
            MessageId.HOME_POSITION,
            MessageId.STATUSTEXT,
        }
    ),
    quiet=frozenset(),
    lead_s=0.02,
    tilt_lead_s=0.02,
    turn_lead_s=0.02,
    pre_stream_s=0.1,
    takeoff_params=_takeoff_params,
    takeoff_from_home=True,
    takeoff_within_m=1.0,
    speed_parameters=("WPNAV_SPEED", "WPNAV_SPEED_UP", "WPNAV_SPEED_DN"),
    acceleration_parameter="WPNAV_ACCEL",
    parameter_units={
        "WPNAV_SPEED": _CENTI,
        "WPNAV_SPEED_UP": _CENTI,
        "WPNAV_SPEED_DN": _CENTI,
        "WPNAV_ACCEL": _CENTI,
        "RTL_ALT": _CENTI,
    },
    integers_bytewise=False,
    loss_timeout="GUID_TIMEOUT",
    loss_action="FS_GCS_ENABLE",
    loss_actions={
        0: "nothing, it holds where it is until its battery is empty",
        1: "RTL",
        2: "RTL",
        3: "SmartRTL or RTL",
        4: "SmartRTL or Land",
        5: "Land",
        6: "DO_LAND_START or RTL",
        7: "Brake or Land",
    },
    safe_loss_actions=_NEEDS_NOBODY,
    long_loss_s=1.0,
    loss_listens_to="SYSID_MYGCS",
    return_height="RTL_ALT",
    failsafes={
        "GUID_TIMEOUT": lambda now_s, _: min(now_s, _LOSS_S),
        "FS_GCS_ENABLE": lambda now, _: now if now in _NEEDS_NOBODY else _RTL,
        "SYSID_MYGCS": lambda _now, _safe: float(SYSTEM_ID),
        "RTL_ALT": lambda now_cm, safe_m: max(now_cm, math.ceil(safe_m) / _CENTI),
        # Near home its Return would stay below RTL_ALT, inside this cone; 0 is none.
        "RTL_CONE_SLOPE": lambda _now, _safe: 0.0,
        "RTL_ALT_TYPE": lambda _now, _safe: 0.0,
    },
    pitfalls={
        "RTL_CONE_SLOPE": "near home its own RTL stays below RTL_ALT, maybe beside the building",
        "RTL_ALT_TYPE": "its own RTL counts its height above a terrain that it may not know",
    },
    forbidding=frozenset(),
    low_battery=None,
    unguarded=None,  # its failsafe listens to our heartbeat, setpoints or not
    damping=None,
    feels_drag=False,
)

_FROM_4_7 = replace(
    _BEFORE_4_7,
    speed_parameters=("WP_SPD", "WP_SPD_UP", "WP_SPD_DN"),
    acceleration_parameter="WP_ACC",
    parameter_units={},
    loss_listens_to="MAV_GCS_SYSID",
    return_height="RTL_ALT_M",
    failsafes={
        **{
            name: safe
            for name, safe in _BEFORE_4_7.failsafes.items()
            if name not in ("SYSID_MYGCS", "RTL_ALT")
        },
        "MAV_GCS_SYSID": _BEFORE_4_7.failsafes["SYSID_MYGCS"],
        "RTL_ALT_M": lambda now_m, safe_m: max(now_m, float(math.ceil(safe_m))),
    },
    pitfalls={
        **_BEFORE_4_7.pitfalls,
        "RTL_CONE_SLOPE": "near home its own RTL stays below RTL_ALT_M, maybe beside the building",
    },
)

ARDUPILOT = replace(_BEFORE_4_7, later=((4, 7), _FROM_4_7))
