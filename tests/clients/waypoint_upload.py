"""A mission's way up, as pymavlink's and MAVProxy's `wp load` go it."""

from patience import LIMIT_S, eventually
from pymavlink import mavutil


def upload(master, loader):
    """All of it is taken. Begun anew where the vehicle, whose time is short, has asked twice or given it up meanwhile."""
    eventually(lambda: _taken(master, loader))


def _taken(master, loader):
    while master.recv_match(type="MISSION_ACK") is not None:
        pass  # of an earlier try
    master.waypoint_clear_all_send()
    assert master.recv_match(type="MISSION_ACK", blocking=True, timeout=LIMIT_S) is not None
    master.waypoint_count_send(loader.count())
    given = None
    while True:
        kinds = ["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"]
        message = master.recv_match(type=kinds, blocking=True, timeout=10.0)
        if message is None:
            return False
        if message.get_type() != "MISSION_ACK":
            given = message.seq
            master.mav.send(loader.wp(given))
        elif message.type != mavutil.mavlink.MAV_MISSION_ACCEPTED:
            return False
        elif given == loader.count() - 1:
            return True
