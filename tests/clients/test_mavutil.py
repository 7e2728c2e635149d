"""pymavlink's mavutil against the vehicle over UDP, with the idioms of its own examples."""

import subprocess
import sys
import time

import pytest
from pymavlink import mavutil


def connect(port):
    connection = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}", dialect="common", source_system=251)
    assert connection.wait_heartbeat(timeout=10) is not None
    return connection


def wait(connection, kind, holds, limit_s=20.0):
    deadline = time.monotonic() + limit_s
    while time.monotonic() < deadline:
        message = connection.recv_match(type=kind, blocking=True, timeout=1.0)
        if message is not None and holds(message):
            return message
    raise AssertionError(f"no such {kind} within {limit_s} s")


def command(connection, number, *params):
    values = [*params, *[0.0] * (7 - len(params))]
    connection.mav.command_long_send(connection.target_system, 1, number, 0, *values)
    return wait(connection, "COMMAND_ACK", lambda ack: ack.command == number, 5.0).result


def test_arm_take_off_and_land_on_the_ground_stations_link(start_vehicle):
    vehicle = start_vehicle("--speedup", "10")
    connection = connect(vehicle.gcs_port)
    assert connection.target_system == vehicle.system
    assert connection.messages["HEARTBEAT"].autopilot == mavutil.mavlink.MAV_AUTOPILOT_PX4
    home = wait(connection, "HOME_POSITION", lambda _: True)
    nan = float("nan")

    assert command(connection, mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    connection.motors_armed_wait()
    takeoff = (0, 0, 0, nan, nan, nan, home.altitude * 1e-3 + 5.0)
    assert command(connection, mavutil.mavlink.MAV_CMD_NAV_TAKEOFF, *takeoff) == 0
    wait(connection, "GLOBAL_POSITION_INT", lambda position: position.relative_alt > 4500)
    assert command(connection, mavutil.mavlink.MAV_CMD_NAV_LAND) == 0
    connection.motors_disarmed_wait()
    position = wait(connection, "GLOBAL_POSITION_INT", lambda _: True)
    assert position.relative_alt == pytest.approx(0, abs=500)
    connection.close()


def test_the_second_client_is_obeyed_but_hears_nothing(start_vehicle):
    vehicle = start_vehicle("--speedup", "10")
    first = connect(vehicle.offboard_port)
    first.mav.heartbeat_send(6, 8, 0, 0, 4)
    time.sleep(0.3)
    second = mavutil.mavlink_connection(
        f"udpout:127.0.0.1:{14580 + vehicle.instance}", dialect="common", source_system=252
    )
    second.mav.command_long_send(vehicle.system, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
    first.motors_armed_wait()
    assert second.recv_msg() is None
    first.close()
    second.close()


def test_a_taken_port_is_said_in_one_line(start_vehicle):
    vehicle = start_vehicle()
    again = subprocess.run(
        [sys.executable, "-m", "sitl", "--instance", str(vehicle.instance)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert again.returncode == 2
    assert str(14580 + vehicle.instance) in again.stderr
    assert len(again.stderr.splitlines()) == 1


def test_a_polite_kill_ends_it_cleanly(start_vehicle, tmp_path):
    vehicle = start_vehicle("--tlog", str(tmp_path / "all.tlog"))
    vehicle.process.terminate()
    assert vehicle.process.wait(10.0) == 0
    assert vehicle.process.stderr.read() == ""
    logged = mavutil.mavlink_connection(str(tmp_path / "all.tlog"), dialect="common")
    assert logged.recv_match(type="HEARTBEAT").autopilot == mavutil.mavlink.MAV_AUTOPILOT_PX4
