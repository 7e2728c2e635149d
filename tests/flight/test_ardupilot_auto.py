"""The exported ArduPilot mission, flown in AUTO by the bundled vehicle's ArduPilot dialect."""

import math

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from mavspiral.handover import inspection_missions
from sitl.airframe import load_airframe
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

WAYPOINT = 16


def test_the_exported_mission_loads_and_flies_along_the_curve(planned):
    """Chords and cut corners leave it: as near as WPNAV_RADIUS allows. Then it comes home and disarms."""
    inspection = planned("kiosk").flown_by("ardupilot")
    frame = inspection.site.heights.frame
    home = frame.geo_point(inspection.home_enu_m)
    (sortie,) = inspection_missions(inspection).missions
    items = sortie.items
    airframe = load_airframe("x500")
    place = GeoPoint(home.lat_deg, home.lon_deg, home.alt_amsl_m)
    simulator = Simulator(
        SimulatorConfig(VehicleConfig(airframe, Params(airframe.params), place), "ardupilot")
    )
    mav = mavlink.MAVLink(None, 255, 190)
    mav.robust_parsing = True

    def live(seconds, *messages):
        data, heard = b"".join(message.pack(mav) for message in messages), []
        for _ in range(round(seconds * 100)):
            step = simulator.step(simulator.time_us + 10_000, data)
            data = b""
            heard += mav.parse_buffer(step.send) or []
        return heard

    def command(number, *params):
        return mavlink.MAVLink_command_long_message(1, 1, number, 0, *params, *(0.0,) * (7 - len(params)))

    def item(seq):
        if seq == 0:
            return mavlink.MAVLink_mission_item_int_message(1, 1, 0, 0, 16, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0)
        one = items[seq - 1]
        p1, p2, p3, p4, x, y, z = (0.0 if math.isnan(value) else value for value in one.params)
        degree = 1e7 if one.frame != 2 else 1.0
        return mavlink.MAVLink_mission_item_int_message(
            1,
            1,
            seq,
            one.frame,
            one.command,
            0,
            1,
            p1,
            p2,
            p3,
            p4,
            round(x * degree),
            round(y * degree),
            z,
            0,
        )

    live(42.0)
    heard = live(0.02, mavlink.MAVLink_mission_count_message(1, 1, len(items) + 1, 0))
    while not [m for m in heard if m.get_type() == "MISSION_ACK"]:
        heard = live(0.02, *(item(m.seq) for m in heard if m.get_type() == "MISSION_REQUEST"))
    assert [m.type for m in heard if m.get_type() == "MISSION_ACK"] == [0]

    live(0.1, command(176, 1, 4))
    live(0.1, command(400, 1))
    live(0.1, command(300))
    rows = []
    while simulator.report.flight.armed:
        assert simulator.time_us < 600e6
        live(0.2)
        truth = frame.to_vehicle(home).position_enu_m(simulator.truth.position_ned_m)
        rows.append((simulator.report.flight.run.seq, *truth))
    flown = np.array(rows)
    assert np.linalg.norm(flown[-1, 1:3] - inspection.home_enu_m[:2]) < 1.0

    waypoints = [seq for seq, one in enumerate(items, start=1) if one.command == WAYPOINT]
    on_it = (flown[:, 0] > waypoints[1]) & (flown[:, 0] <= waypoints[-1])
    curve = inspection.trajectory.sampled(0.1).position_enu_m
    off_m = [np.linalg.norm(curve - place, axis=1).min() for place in flown[on_it, 1:]]
    assert len(off_m) > 200
    assert np.quantile(off_m, 0.95) < 1.0
    assert max(off_m) < 2.0
