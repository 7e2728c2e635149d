"""Scripts as people write them for ArduCopter with pymavlink: each flow ends, and ends as on the real vehicle."""

import math
import time

import pytest
from copter_process import copter
from patience import LIMIT_S
from pymavlink import mavparm, mavutil, mavwp
from waypoint_upload import upload

MAV = mavutil.mavlink
ONLY_VELOCITY = 0b0000_1111_1100_0111
IN_NED, IN_BODY = MAV.MAV_FRAME_LOCAL_NED, MAV.MAV_FRAME_BODY_NED


@pytest.fixture(scope="module")
def master():
    with copter("--speedup", "6") as (port, _):
        connection = mavutil.mavlink_connection(
            f"tcp:127.0.0.1:{port}", dialect="ardupilotmega", retries=30, autoreconnect=False
        )
        connection.wait_heartbeat(timeout=LIMIT_S)
        hear(connection, "HEARTBEAT", "HEARTBEAT.system_status==3")
        connection.mav.request_data_stream_send(
            connection.target_system, connection.target_component, MAV.MAV_DATA_STREAM_ALL, 10, 1
        )
        hear(connection, "EKF_STATUS_REPORT", "EKF_STATUS_REPORT.flags==831")
        connection.param_set_send("DISARM_DELAY", 0.0)  # it waits for us, however late
        hear(connection, "PARAM_VALUE", "PARAM_VALUE.param_id=='DISARM_DELAY' and PARAM_VALUE.param_value==0")
        yield connection
        connection.close()


def hear(master, name, condition=None, limit_s=LIMIT_S):
    message = master.recv_match(type=name, condition=condition, blocking=True, timeout=limit_s)
    assert message is not None, (name, condition)
    return message


def result(master, command):
    return hear(master, "COMMAND_ACK", f"COMMAND_ACK.command=={command}").result


def order(master, command, *params):
    values = (*params, *(0.0,) * (7 - len(params)))
    master.mav.command_long_send(master.target_system, master.target_component, command, 0, *values)
    return result(master, command)


def flies_at(master, velocity, frame, velocity_ned_mps):
    """Sends it again and again, as guided_set_speed_yaw.py does, until for a second of its own it flies so."""
    since_ms, until_s = None, time.monotonic() + LIMIT_S
    while time.monotonic() < until_s:
        master.mav.set_position_target_local_ned_send(
            0, master.target_system, master.target_component, frame, ONLY_VELOCITY, 0, 0, 0, *velocity, 0, 0, 0, 0, 0
        )  # fmt: skip
        here = master.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=0.05)
        if here is None:
            continue
        if (here.vx, here.vy, here.vz) != pytest.approx(velocity_ned_mps, abs=0.4):
            since_ms = None
        elif here.time_boot_ms - (since_ms := since_ms or here.time_boot_ms) >= 1000:
            return
    raise AssertionError((velocity, here))


def test_location_fields_and_the_messages_kept(master):
    place = master.location(relative_alt=True)
    assert place.lat == pytest.approx(23.96028, abs=1e-4)
    assert place.alt == pytest.approx(0.0, abs=0.5)
    assert master.field("VFR_HUD", "alt") == pytest.approx(188.5, abs=1.0)
    assert {"ATTITUDE", "GPS_RAW_INT", "SYS_STATUS", "GLOBAL_POSITION_INT"} <= set(master.messages)
    assert master.messages["SYS_STATUS"].onboard_control_sensors_health & MAV.MAV_SYS_STATUS_PREARM_CHECK


@pytest.mark.parametrize(
    ("switch", "number"),
    [("set_mode_rtl", 6), ("set_mode_loiter", 5)],
    ids=["set_mode_rtl", "set_mode_loiter"],
)
def test_modes_by_their_own_methods(master, switch, number):
    getattr(master, switch)()
    hear(master, "HEARTBEAT", f"HEARTBEAT.custom_mode=={number}")


def test_set_servo_and_a_command_that_is_unknown(master):
    master.set_servo(9, 1600)
    assert result(master, MAV.MAV_CMD_DO_SET_SERVO) == MAV.MAV_RESULT_ACCEPTED
    hear(master, "SERVO_OUTPUT_RAW", "SERVO_OUTPUT_RAW.servo9_raw==1600")
    assert order(master, MAV.MAV_CMD_DO_ORBIT, 10) == MAV.MAV_RESULT_UNSUPPORTED


def test_all_1392_parameters_by_index_and_a_set_that_is_verified(master):
    parameters = mavparm.MAVParmDict()
    master.param_fetch_all()
    begin = time.monotonic()
    while len(parameters) < 1392:
        assert time.monotonic() - begin < LIMIT_S, len(parameters)
        value = hear(master, "PARAM_VALUE")
        parameters[value.param_id] = value.param_value
    assert parameters.mavset(master, "SRTL_ACCURACY", 3.0)
    assert parameters["GUID_TIMEOUT"] == 3.0


def test_a_mission_goes_up_by_mavwp_and_comes_down_the_same(master):
    loader = mavwp.MAVWPLoader(master.target_system, master.target_component)
    home = master.location()
    for seq, (command, north) in enumerate(((16, 0), (22, 0), (82, 1e-4), (82, 2e-4), (16, 3e-4), (20, 0))):
        loader.add(
            MAV.MAVLink_mission_item_message(
                *(master.target_system, master.target_component, seq, 3, command, 0, 1),
                *(0, 0, 0, 0, home.lat + north, home.lng, 10.0),
            )
        )
    upload(master, loader)
    master.waypoint_request_list_send()
    assert hear(master, "MISSION_COUNT").count == loader.count()
    for seq in range(1, loader.count()):
        master.waypoint_request_send(seq)
        item = hear(master, ["MISSION_ITEM", "MISSION_ITEM_INT"])
        assert (item.seq, item.command) == (seq, loader.wp(seq).command)
    master.waypoint_set_current_send(2)
    hear(master, "MISSION_CURRENT", "MISSION_CURRENT.seq==2")


def test_a_guided_flight_as_in_the_examples(master):
    """simple_goto, a square by velocities, yaw, region of interest and speed; then a landing."""
    master.set_mode("GUIDED")
    hear(master, "HEARTBEAT", "HEARTBEAT.custom_mode==4")
    master.arducopter_arm()
    master.motors_armed_wait()
    assert order(master, MAV.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == MAV.MAV_RESULT_ACCEPTED
    hear(master, "GLOBAL_POSITION_INT", "GLOBAL_POSITION_INT.relative_alt>9500")
    for velocity in ((3, 0, 0), (0, 3, 0), (-3, 0, 0), (0, -3, 0)):
        flies_at(master, velocity, IN_NED, velocity)
    assert order(master, MAV.MAV_CMD_CONDITION_YAW, 90, 60, 1, 0) == MAV.MAV_RESULT_ACCEPTED
    hear(master, "GLOBAL_POSITION_INT", "8500<GLOBAL_POSITION_INT.hdg<9500")
    master.mav.command_long_send(
        master.target_system, master.target_component, MAV.MAV_CMD_DO_SET_ROI, 0, 0, 0, 0, 0, 23.96, 32.87, 20
    )
    assert result(master, MAV.MAV_CMD_DO_SET_ROI) == MAV.MAV_RESULT_ACCEPTED
    assert order(master, MAV.MAV_CMD_DO_CHANGE_SPEED, 1, 6, -1) == MAV.MAV_RESULT_ACCEPTED
    goal = master.location(relative_alt=True)
    master.mav.mission_item_send(
        master.target_system, master.target_component, 0, 3, 16, 2, 0, 0, 0, 0, 0, goal.lat + 2e-4, goal.lng, 12
    )  # fmt: skip
    assert hear(master, "MISSION_ACK").type == MAV.MAV_MISSION_ACCEPTED
    lat = round((goal.lat + 2e-4) * 1e7)
    hear(master, "GLOBAL_POSITION_INT", f"abs(GLOBAL_POSITION_INT.lat-{lat})<50")
    nose = math.radians(hear(master, "GLOBAL_POSITION_INT").hdg / 100)
    flies_at(master, (2, 0, 0), IN_BODY, (2 * math.cos(nose), 2 * math.sin(nose), 0))
    assert order(master, MAV.MAV_CMD_NAV_LAND) == MAV.MAV_RESULT_ACCEPTED
    master.motors_disarmed_wait()
