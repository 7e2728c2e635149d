"""The code under test: arms, climbs and reports how high it came."""

import time

from pymavlink import mavutil


def hop(url, height_m, limit_s=40.0):
    link = mavutil.mavlink_connection(url, dialect="common")
    try:
        link.wait_heartbeat()
        home = link.recv_match(type="HOME_POSITION", blocking=True, timeout=5.0)
        nan = float("nan")
        send = link.mav.command_long_send
        send(link.target_system, 1, mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, 0, 0, 0, 0, 0, 0)
        top_m = home.altitude / 1e3 + height_m
        send(link.target_system, 1, mavutil.mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, nan, nan, nan, top_m)
        best_m, deadline = 0.0, time.monotonic() + limit_s
        while best_m < height_m - 0.5 and time.monotonic() < deadline:
            place = link.recv_match(type="GLOBAL_POSITION_INT", blocking=True, timeout=1.0)
            best_m = max(best_m, place.relative_alt / 1e3)
        return best_m
    finally:
        link.close()
