"""What REQUEST_DATA_STREAM asks for: messages in groups, as ArduPilot has them.

Of the 27 that its SITL was seen to start those are missing that this vehicle has nothing to say in: second and third sensors
(SCALED_IMU2, SCALED_IMU3, SCALED_PRESSURE2), the board (POWER_STATUS, MEMINFO, MCU_STATUS), terrain, and truth (SIMSTATE).
"""

from __future__ import annotations

from collections.abc import Mapping

from pymavlink.dialects.v20 import ardupilotmega

__all__ = ["COPTER_RATES_HZ", "FASTEST_HZ", "stream_messages"]

COPTER_RATES_HZ: Mapping[str, float] = {"HEARTBEAT": 1.0, "TIMESYNC": 0.1}
"""All that comes unasked."""
FASTEST_HZ = 320.0
"""0.8 of the main loop's rate: what is asked for beyond is refused."""

_ALL = 0
_GROUPS: Mapping[int, tuple[str, ...]] = {
    1: ("RAW_IMU", "SCALED_PRESSURE"),
    2: (
        "SYS_STATUS",
        "NAV_CONTROLLER_OUTPUT",
        "GPS_RAW_INT",
        "MISSION_CURRENT",
        "FENCE_STATUS",
        "POSITION_TARGET_GLOBAL_INT",
    ),
    3: ("SERVO_OUTPUT_RAW", "RC_CHANNELS"),
    6: ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"),
    10: ("ATTITUDE", "AHRS2"),
    11: ("VFR_HUD",),
    12: ("SYSTEM_TIME", "BATTERY_STATUS", "EKF_STATUS_REPORT", "VIBRATION"),
}


def stream_messages(stream: int) -> tuple[int, ...]:
    """The numbers of the messages in MAV_DATA_STREAM `stream`; of all that there are in stream 0."""
    names = sum(_GROUPS.values(), ()) if stream == _ALL else _GROUPS.get(stream, ())
    return tuple(getattr(ardupilotmega, f"MAVLINK_MSG_ID_{name}") for name in names)
