"""pymavlink's mavutil against the vehicle over UDP, with the idioms of its own examples."""

import os
import subprocess
import sys
import time

import pytest
from patience import LIMIT_S, eventually
from pymavlink import mavutil
from vehicle_process import ROOT, free_instance

ANSWER_S = 3.0


def connect(port):
    connection = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}", dialect="common", source_system=251)
    assert connection.wait_heartbeat(timeout=LIMIT_S) is not None
    return connection


def heard(connection, kind, holds, limit_s):
    deadline = time.monotonic() + limit_s
    while time.monotonic() < deadline:
        message = connection.recv_match(type=kind, blocking=True, timeout=1.0)
        if message is not None and holds(message):
            return message
    return None


def wait(connection, kind, holds):
    message = heard(connection, kind, holds, LIMIT_S)
    assert message is not None, f"no such {kind} within {LIMIT_S} s"
    return message


def command(connection, number, *params):
    values = [*params, *[0.0] * (7 - len(params))]

    def answer():
        """MAVLink's command protocol: what is not answered is sent again."""
        connection.mav.command_long_send(connection.target_system, 1, number, 0, *values)
        return heard(connection, "COMMAND_ACK", lambda ack: ack.command == number, ANSWER_S)

    return eventually(answer).result


def waits_for_take_off(connection):
    """Armed, it does not lose patience, which a speed-up makes short."""

    def told():
        connection.param_set_send("COM_DISARM_PRFLT", 0.0)
        return heard(connection, "PARAM_VALUE", lambda value: value.param_id == "COM_DISARM_PRFLT", ANSWER_S)

    assert eventually(told).param_value == 0.0


def test_arm_take_off_and_land_on_the_ground_stations_link(start_vehicle):
    vehicle = start_vehicle("--speedup", "5")
    connection = connect(vehicle.gcs_port)
    assert connection.target_system == vehicle.system
    assert connection.messages["HEARTBEAT"].autopilot == mavutil.mavlink.MAV_AUTOPILOT_PX4
    home = wait(connection, "HOME_POSITION", lambda _: True)
    nan = float("nan")
    waits_for_take_off(connection)

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


def test_two_instances_do_not_hear_each_other(start_vehicle):
    vehicles = [start_vehicle("--speedup", "5") for _ in range(2)]
    links = [connect(port) for vehicle in vehicles for port in (vehicle.offboard_port, vehicle.gcs_port)]
    for vehicle, link in zip((vehicles[0], vehicles[0], vehicles[1], vehicles[1]), links, strict=True):
        assert link.target_system == vehicle.system
    waits_for_take_off(links[0])
    for other in links[2:]:  # even those who have the wrong number on their link
        other.mav.command_long_send(vehicles[0].system, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
    assert command(links[0], mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
    links[1].motors_armed_wait()
    for vehicle, link in zip(vehicles, links[::2], strict=True):
        seen = {wait(link, "HEARTBEAT", lambda _: True).get_srcSystem() for _ in range(20)}
        assert seen == {vehicle.system}
    assert not links[2].motors_armed() and not links[3].motors_armed()
    for link in links:
        link.close()


def test_the_second_client_is_obeyed_but_hears_nothing(start_vehicle):
    vehicle = start_vehicle()
    first = connect(vehicle.offboard_port)
    waits_for_take_off(first)  # and so it is the first
    second = mavutil.mavlink_connection(
        f"udpout:127.0.0.1:{14580 + vehicle.instance}", dialect="common", source_system=252
    )
    second.mav.command_long_send(vehicle.system, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
    first.motors_armed_wait()
    assert second.recv_msg() is None
    first.close()
    second.close()


def test_a_taken_port_is_said_in_one_line_and_before_anything_compiles(start_vehicle, tmp_path):
    vehicle = start_vehicle()
    again = subprocess.run(
        [sys.executable, "-m", "sitl", "--instance", str(vehicle.instance)],
        capture_output=True,
        text=True,
        timeout=400,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
    )
    assert again.returncode == 2
    assert "compiling" not in again.stdout
    assert str(14580 + vehicle.instance) in again.stderr
    assert len(again.stderr.splitlines()) == 1


def test_a_polite_kill_ends_it_cleanly(start_vehicle, tmp_path):
    vehicle = start_vehicle("--tlog", str(tmp_path / "all.tlog"))
    vehicle.process.terminate()
    assert vehicle.process.wait(LIMIT_S) == 0
    assert vehicle.process.stderr.read() == ""
    logged = mavutil.mavlink_connection(str(tmp_path / "all.tlog"), dialect="common")
    assert logged.recv_match(type="HEARTBEAT").autopilot == mavutil.mavlink.MAV_AUTOPILOT_PX4


def test_who_no_longer_reads_what_it_prints_does_not_bring_it_down():
    """As `python -m sitl | head -1`."""
    instance = free_instance()
    vehicle = subprocess.Popen(
        [sys.executable, "-m", "sitl", "--instance", str(instance), "--speedup", "5"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert any("UDP" in line for line in vehicle.stdout)  # it may compile first, and says so
    vehicle.stdout.close()
    link = connect(14540 + instance)
    link.mav.command_long_send(instance + 1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)  # there is something to tell
    wait(link, "SYSTEM_TIME", lambda time: time.time_boot_ms > 5000)
    vehicle.terminate()
    assert vehicle.wait(LIMIT_S) == 0
    assert vehicle.stderr.read() == ""
    link.close()
