"""A user at MAVProxy's prompt, against both dialects: parameters, plans, and a flight in the modes that it knows."""

import pytest
from copter_process import copter
from mavproxy_session import mavproxy, session

LAT, LON, ALT_M = 23.96028, 32.8675, 188.5
RETURN_FRAME = {"px4": 2, "ardupilot": 3}  # PX4 takes what has no place in MAV_FRAME_MISSION only


def plan_file(path, *items):
    """A file as Mission Planner writes it: frame, command, param1, latitude, longitude, altitude a row."""
    rows = [
        (seq, int(seq == 0), frame, command, p1, 0, 0, 0, lat, lon, alt_m, 1)
        for seq, (frame, command, p1, lat, lon, alt_m) in enumerate(items)
    ]
    path.write_text("\n".join(["QGC WPL 110", *("\t".join(map(str, row)) for row in rows)]) + "\n")
    return path


def plans(folder, dialect):
    mission = plan_file(
        folder / "mission.txt",
        (0, 16, 0, LAT, LON, ALT_M),
        (3, 22, 0, LAT, LON, 6),
        (3, 16, 0, LAT + 2e-4, LON, 8),
        (3, 16, 0, LAT + 2e-4, LON + 2e-4, 8),
        (RETURN_FRAME[dialect], 20, 0, 0, 0, 0),
    )
    corners = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    fence = plan_file(
        folder / "fence.txt", *((3, 5001, 4, LAT + n * 1e-3, LON + e * 1e-3, 0) for n, e in corners)
    )
    rally = plan_file(folder / "rally.txt", (3, 5100, 0, LAT + 1e-4, LON, 20))
    return mission, fence, rally


def keeps_plans(prompt, folder, dialect):
    """`wp`, `fence` and `rally`, loaded and listed."""
    mission, fence, rally = plans(folder, dialect)
    prompt.types(f"wp load {mission}", "Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
    prompt.types(f"fence load {fence}", "Got MISSION_ACK: TYPE_FENCE: ACCEPTED")
    prompt.types(f"rally load {rally}", "Got MISSION_ACK: TYPE_RALLY: ACCEPTED")
    prompt.types(
        "wp list", r"(?s)Requesting 5 waypoints.*\n22 \d.*23\.96028.* 6\.0.*\n20 \d.*Saved 5 waypoints"
    )
    prompt.types("fence list", r"(?s)Requesting 4 fence items.*\n5001 .*Saved 4 fence items")
    prompt.types("rally list", r"(?s)Requesting 1 rally items.*\n5100 .* 20\.0.*Saved 1 rally items")


def sets(prompt, name, value):
    """Set a parameter, and ask until it is so: `param set` says nothing."""
    prompt.types(f"param set {name} {value}", "")
    prompt.asks(f"param fetch {name}", rf"{name} = {value}\.0")


def keeps_parameters(prompt, name, value):
    # By FTP in ArduPilot's dialect; PX4's has no such file, says so at once, and lists them.
    # What is lost of the list MAVProxy asks for again; typed again, it begins anew.
    prompt.types("param fetch", r"Received \d{3,} parameters", patience_s=30.0)
    sets(prompt, name, value)
    prompt.types(f"param show {name}", rf"{name} +{value}\.0")


def reaches(prompt, name, low, high):
    """Ask for the vehicle's own GLOBAL_POSITION_INT until it is there."""
    prompt.asks(
        "status GLOBAL_POSITION_INT",
        rf"GLOBAL_POSITION_INT.*\b{name} : (-?\d+)",
        lambda match: low <= int(match[1]) <= high,
    )


def goes(prompt, alt_m):
    """`guided` to a place 13 m north and 12 m up, and there."""
    prompt.types(f"guided 23.9604 32.8676 {alt_m}", "DO_REPOSITION: ACCEPTED")
    reaches(prompt, "lat", 239_603_950, 239_604_050)
    reaches(prompt, "relative_alt", 11_500, 12_500)


@pytest.fixture(autouse=True)
def found():
    mavproxy()


def test_an_arducopter_from_parameters_to_return(tmp_path):
    with copter("--speedup", "6") as (port, _), session(f"tcp:127.0.0.1:{port}", tmp_path) as prompt:
        prompt.sees("online system")
        prompt.sees("EKF3 IMU0 is using GPS")
        keeps_parameters(prompt, "WPNAV_SPEED", "700")
        keeps_plans(prompt, tmp_path, "ardupilot")
        sets(prompt, "DISARM_DELAY", "0")  # it waits for who types, however late
        prompt.types("mode GUIDED", "Mode GUIDED")
        prompt.types("arm throttle", "ARMED")
        prompt.types("takeoff 8", "NAV_TAKEOFF: ACCEPTED")
        reaches(prompt, "relative_alt", 7_500, 8_500)  # a target before that ends the take-off
        goes(prompt, 12)
        prompt.types("mode RTL", "Mode RTL")
        prompt.sees("DISARMED")


def test_a_px4_from_parameters_to_return(start_vehicle, tmp_path):
    vehicle = start_vehicle("--speedup", "3")
    with session(f"udpin:127.0.0.1:{vehicle.offboard_port}", tmp_path) as prompt:
        prompt.sees("online system")
        keeps_parameters(prompt, "RTL_RETURN_ALT", "15")
        keeps_plans(prompt, tmp_path, "px4")
        sets(prompt, "COM_DISARM_PRFLT", "0")  # it waits for who types, however late
        prompt.types("arm throttle", "ARMED")
        # PX4 takes heights above the sea. MAVProxy 1.8.75 fails in its own `mode NAME` there, before it sends.
        prompt.types(f"takeoff {ALT_M + 8}", "Mode TAKEOFF")
        prompt.sees("Mode LOITER")
        goes(prompt, ALT_M + 12)
        prompt.types("long NAV_RETURN_TO_LAUNCH 0 0 0 0 0 0 0", "Mode RTL")
        prompt.sees("DISARMED")
