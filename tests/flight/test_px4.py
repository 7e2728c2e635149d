from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.messages import TypeMask
from mavspiral.flight.px4 import PX4


def test_modes_are_those_that_pymavlink_knows():
    known = mavutil.px4_map
    names = {"OFFBOARD": "OFFBOARD", "AUTO.LAND": "LAND", "AUTO.RTL": "RTL", "AUTO.TAKEOFF": "TAKEOFF"}
    names |= {
        "AUTO.LOITER": "LOITER",
        "POSCTL": "POSCTL",
        "MANUAL": "MANUAL",
        "ALTCTL": "ALTCTL",
        "ACRO": "ACRO",
    }
    for mode in (PX4.follow, PX4.land, PX4.go_home, *PX4.climb, *PX4.other_modes):
        name = names.get(mode.name, mode.name.removeprefix("AUTO."))
        _, main, sub = known[name]
        assert mode.custom_mode == main << 16 | sub << 24, mode
        assert mode.command == (mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, main, sub)
        assert PX4.mode_name(mode.custom_mode) == mode.name
    assert PX4.mode_name(99 << 16) == "mode 0x630000"


def test_all_of_a_setpoint_is_commanded_in_the_local_frame():
    assert PX4.type_mask == TypeMask(0) and PX4.coordinate_frame == mavlink.MAV_FRAME_LOCAL_NED
    assert PX4.autopilot == mavlink.MAV_AUTOPILOT_PX4
