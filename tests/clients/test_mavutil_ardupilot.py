"""pymavlink's mavutil, mavwp and mavparm against the ArduPilot dialect over TCP, with the idioms of its examples."""

import json
import os
import subprocess
import sys
import time

import pytest
from copter_process import ROOT, copter
from patience import LIMIT_S
from pymavlink import mavparm, mavutil, mavwp
from waypoint_upload import upload


def connect(port):
    os.environ["MAVLINK20"] = "1"
    master = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", dialect="ardupilotmega", retries=30)
    assert master.wait_heartbeat(timeout=LIMIT_S) is not None
    return master


def wait(master, condition, limit_s=LIMIT_S, **match):
    deadline = time.monotonic() + limit_s
    while time.monotonic() < deadline:
        message = master.recv_match(blocking=True, timeout=1.0, **match)
        if message is not None and condition(message):
            return message
    raise AssertionError(f"no such {match} within {limit_s} s")


def ready(master):
    """Wait until it knows its place, as examples wait for the EKF's flags."""
    master.mav.request_data_stream_send(
        master.target_system, master.target_component, mavutil.mavlink.MAV_DATA_STREAM_ALL, 4, 1
    )
    wait(master, lambda m: m.flags & 831 == 831, type="EKF_STATUS_REPORT")


@pytest.fixture(scope="module")
def master():
    with copter("--speedup", "10") as (port, system):
        connection = connect(port)
        assert connection.target_system == system
        # The first seconds of asking are forgotten: it has not booted.
        wait(connection, lambda m: m.system_status == 3, type="HEARTBEAT")
        ready(connection)
        connection.param_set_send("DISARM_DELAY", 0.0)  # it waits for us, however late
        wait(connection, lambda v: (v.param_id, v.param_value) == ("DISARM_DELAY", 0.0), type="PARAM_VALUE")
        yield connection
        connection.close()


def test_who_it_is_and_which_modes_it_has(master):
    assert master.messages["HEARTBEAT"].autopilot == mavutil.mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    assert master.mode_mapping()["GUIDED"] == 4
    master.set_mode("GUIDED")
    wait(master, lambda _: master.flightmode == "GUIDED", type="HEARTBEAT")
    master.set_mode_apm("LOITER")
    wait(master, lambda _: master.flightmode == "LOITER", type="HEARTBEAT")


def test_all_parameters_are_fetched_and_one_is_set(master):
    parameters = mavparm.MAVParmDict()
    master.param_fetch_all()
    deadline = time.monotonic() + LIMIT_S
    count = None
    while (count is None or len(parameters) < count) and time.monotonic() < deadline:
        value = wait(master, lambda _: True, type="PARAM_VALUE")
        parameters[value.param_id] = value.param_value
        count = value.param_count
    assert len(parameters) == count > 500
    assert parameters["WPNAV_SPEED"] == 1000.0
    assert parameters.mavset(master, "WPNAV_SPEED", 700.0)
    master.param_fetch_one("WPNAV_SPEED")
    assert wait(master, lambda v: v.param_id == "WPNAV_SPEED", type="PARAM_VALUE").param_value == 700.0
    parameters.mavset(master, "WPNAV_SPEED", 1000.0)


def test_arm_take_off_in_guided_go_somewhere_and_land(master):
    master.set_mode("GUIDED")
    wait(master, lambda _: master.flightmode == "GUIDED", type="HEARTBEAT")
    master.arducopter_arm()
    master.motors_armed_wait()
    master.mav.command_long_send(
        master.target_system, master.target_component, mavutil.mavlink.MAV_CMD_NAV_TAKEOFF, 0,
        0, 0, 0, 0, 0, 0, 8,
    )  # fmt: skip
    assert wait(master, lambda a: a.command == 22, type="COMMAND_ACK").result == 0
    wait(master, lambda m: m.relative_alt > 7500, type="GLOBAL_POSITION_INT")
    time.sleep(0.3)
    here = wait(master, lambda _: True, type="GLOBAL_POSITION_INT")
    master.mav.set_position_target_global_int_send(
        0, master.target_system, master.target_component,
        mavutil.mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, 0xDF8,
        here.lat + 1000, here.lon, 8.0, 0, 0, 0, 0, 0, 0, 0, 0,
    )  # fmt: skip
    wait(master, lambda m: m.lat > here.lat + 900, type="GLOBAL_POSITION_INT")
    master.set_mode("LAND")
    master.motors_disarmed_wait()


def test_a_waypoint_file_is_uploaded_read_back_and_flown(master, tmp_path):
    home = wait(master, lambda _: True, type="GLOBAL_POSITION_INT")
    lat, lon = home.lat * 1e-7, home.lon * 1e-7
    rows = [
        (0, 0, 16, 0, lat, lon, home.alt * 1e-3),
        (1, 3, 22, 0, 0.0, 0.0, 6.0),
        (2, 3, 16, 0, lat + 2e-4, lon, 8.0),
        (3, 3, 16, 0, lat + 2e-4, lon + 2e-4, 8.0),
        (4, 3, 20, 0, 0.0, 0.0, 0.0),
    ]
    lines = ["QGC WPL 110"] + [
        "\t".join(map(str, (seq, int(seq == 0), frame, command, p1, 0, 0, 0, x, y, z, 1)))
        for seq, frame, command, p1, x, y, z in rows
    ]
    path = tmp_path / "square.waypoints"
    path.write_text("\n".join(lines) + "\n")
    loader = mavwp.MAVWPLoader(master.target_system, master.target_component)
    loader.load(str(path))
    upload(master, loader)
    master.waypoint_request_list_send()
    count = wait(master, lambda _: True, type="MISSION_COUNT").count
    assert count == loader.count() == 5
    for seq in range(1, count):
        master.waypoint_request_send(seq)
        item = wait(master, lambda m, seq=seq: m.seq == seq, type=["MISSION_ITEM", "MISSION_ITEM_INT"])
        assert (item.command, item.z) == (rows[seq][2], rows[seq][6])
    master.set_mode("GUIDED")
    wait(master, lambda _: master.flightmode == "GUIDED", type="HEARTBEAT")
    master.arducopter_arm()
    master.motors_armed_wait()
    master.mav.command_long_send(
        master.target_system, master.target_component, mavutil.mavlink.MAV_CMD_MISSION_START, 0,
        0, 0, 0, 0, 0, 0, 0,
    )  # fmt: skip
    for seq in (1, 2, 3):
        wait(master, lambda m, seq=seq: m.seq == seq, type="MISSION_ITEM_REACHED")
    assert master.flightmode == "AUTO"
    master.motors_disarmed_wait()


def test_mavspiral_flies_the_kiosk_over_tcp(tmp_path):
    """The second of the README's two terminals, at eight times real time."""
    with copter("--speedup", "8") as (port, _):
        flown = subprocess.run(
            [
                *(sys.executable, "-m", "mavspiral.cli", "fly", "missions/kiosk.toml", "--yes", "--json"),
                *("--connect", f"tcp:127.0.0.1:{port}", "--out", str(tmp_path)),
            ],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=400,
        )
    assert flown.returncode == 0, flown.stdout + flown.stderr
    summary = json.loads(flown.stdout)
    assert summary["autopilot"] == "ardupilot"
    assert summary["passed"]
    assert (tmp_path / "kiosk.tlog").stat().st_size > 100_000
