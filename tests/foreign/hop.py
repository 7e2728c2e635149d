"""The code under test: arms, climbs and reports how high it came."""

import time

from pymavlink import mavutil


def hop(url, height_m, limit_s=90.0):
    link = mavutil.mavlink_connection(url, dialect="common")
    try:
        link.wait_heartbeat()
        home = link.recv_match(type="HOME_POSITION", blocking=True, timeout=limit_s)
        nan = float("nan")
        send = link.mav.command_long_send
        top_m = home.altitude / 1e3 + height_m
        best_m, deadline, ask_s = 0.0, time.monotonic() + limit_s, 0.0
        while best_m < height_m - 0.5 and time.monotonic() < deadline:
            if best_m < 0.5 and time.monotonic() > ask_s:  # what is not obeyed is asked for again
                ask_s = time.monotonic() + 3.0
                send(
                    link.target_system,
                    1,
                    mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
                    0,
                    1,
                    0,
                    0,
                    0,
                    0,
                    0,
                    0,
                )
                send(
                    link.target_system,
                    1,
                    mavutil.mavlink.MAV_CMD_NAV_TAKEOFF,
                    0,
                    0,
                    0,
                    0,
                    nan,
                    nan,
                    nan,
                    top_m,
                )
            place = link.recv_match(type="GLOBAL_POSITION_INT", blocking=True, timeout=1.0)
            if place is not None:
                best_m = max(best_m, place.relative_alt / 1e3)
        return best_m
    finally:
        link.close()
