"""Whole flights in lockstep, frame by frame, over a link that tests may worsen: session against bundled vehicle."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np

from mavspiral.closedloop import _config
from mavspiral.flight.autopilots import PROFILES
from mavspiral.flight.outcome import SessionConfig
from mavspiral.flight.session import Session
from sitl.signals import GeoPoint as VehiclePoint
from sitl.simulator import Simulator


class Air:
    """Frames arrive `delay_us` later, or not at all: `loss` of them, and all of them while it is `cut`."""

    def __init__(self, seed, loss, delay_us):
        self._random, self._loss, self._delay_us = random.Random(seed), loss, delay_us
        self._under_way = []
        self.cut = False

    def __call__(self, now_us, data):
        while data:
            size = data[1] + 12
            if not self.cut and self._random.random() >= self._loss:
                self._under_way.append((now_us + self._delay_us, data[:size]))
            data = data[size:]
        arrived = b"".join(frame for due_us, frame in self._under_way if due_us <= now_us)
        self._under_way = [(due_us, frame) for due_us, frame in self._under_way if due_us > now_us]
        return arrived


def flown(
    inspection,
    *,
    seed,
    loss=0.0,
    delay_us=0,
    each=None,
    sortie=None,
    limit_s=900.0,
    faults=(),
    stands_enu_m=None,
    align_at_enu_m=None,
):
    """The session, and the truth in the plan's ENU, a row every frame; it stands at home, or at `stands_enu_m`.

    `each` is called with the time, the session, the way up and down, and the simulator. A question is approved.
    """
    config = _config(inspection, seed, 0.0, False, faults)
    start_enu_m = inspection.home_enu_m if stands_enu_m is None else stands_enu_m
    frame = inspection.site.heights.frame
    place = frame.geo_point(start_enu_m)
    start = VehiclePoint(place.lat_deg, place.lon_deg, place.alt_amsl_m)
    simulator = Simulator(replace(config, vehicle=replace(config.vehicle, home=start)))
    sortie = sortie or inspection.sorties()[0]
    session = Session(
        lambda home_enu_m: inspection.route_from(home_enu_m, sortie),
        frame,
        SessionConfig(safe_height_enu_m=inspection.safe_height_enu_m),
        way_home=inspection.way_home,
        profiles=(PROFILES[inspection.mission.vehicle.autopilot],),
        shots=inspection.shot_orders(sortie),
        align_at_enu_m=align_at_enu_m,
    )
    up, down = Air(seed, loss, delay_us), Air(seed + 1, loss, delay_us)
    now_us, sent, truth_ned_m = 0, b"", []
    while session.outcome is None and now_us < limit_s * 1e6:
        said = simulator.step(now_us, up(now_us, sent)).send
        sent = session.step(now_us, down(now_us, said)).send
        if each is not None:
            each(now_us, session, (up, down), simulator)
        session.approve()
        truth_ned_m.append(simulator.truth.position_ned_m)
        now_us += 10_000
    while simulator.report.flight.armed and now_us < limit_s * 1e6:  # nobody steers it now
        simulator.step(now_us, b"")
        truth_ned_m.append(simulator.truth.position_ned_m)
        now_us += 10_000
    to_home = frame.to_vehicle(place)
    return session, to_home.position_enu_m(np.array(truth_ned_m))
