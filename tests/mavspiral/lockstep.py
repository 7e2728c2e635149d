"""Whole flights in lockstep, frame by frame, over a link that tests may worsen: session against bundled vehicle."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np

from mavspiral.closedloop import _config
from mavspiral.flight.autopilots import PROFILES
from mavspiral.flight.messages import Command
from mavspiral.flight.outcome import SessionConfig
from mavspiral.flight.session import Session
from mavspiral.logbook.progress import Flown, estimated_shots, inspected_s, left_of, together
from sitl.signals import GeoPoint as VehiclePoint
from sitl.simulator import Simulator


class Air:
    """Frames arrive `delay_us` later, or not at all: `loss` of them, and all of them while it is `cut`."""

    def __init__(self, seed, loss, delay_us):
        self._random, self._loss, self._delay_us = random.Random(seed), loss, delay_us
        self._under_way = []
        self.cut = False
        self.deaf = False

    def __call__(self, now_us, data):
        while data:
            size = data[1] + 12
            lost = self.cut or (self.deaf and _shoots(data[:size]))
            if not lost and self._random.random() >= self._loss:
                self._under_way.append((now_us + self._delay_us, data[:size]))
            data = data[size:]
        arrived = b"".join(frame for due_us, frame in self._under_way if due_us <= now_us)
        self._under_way = [(due_us, frame) for due_us, frame in self._under_way if due_us > now_us]
        return arrived


def _shoots(frame):
    """Whether it is a COMMAND_LONG for a picture."""
    command = int.from_bytes(frame[10 + 28 : 10 + 30], "little")
    return int.from_bytes(frame[7:10], "little") == 76 and command == Command.IMAGE_START_CAPTURE


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
    set_failsafes=False,
):
    """The session, and the truth in the plan's ENU, a row every frame; it stands at home, or at `stands_enu_m`.

    `each` is called with the time, the session and the way up and down; what it returns a ground station sends. A question
    is approved.
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
        SessionConfig(safe_height_enu_m=inspection.safe_height_enu_m, set_failsafes=set_failsafes),
        way_home=inspection.way_home,
        profiles=(PROFILES[inspection.mission.vehicle.autopilot],),
        shots=inspection.shot_orders(sortie),
        align_at_enu_m=align_at_enu_m,
    )
    up, down = Air(seed, loss, delay_us), Air(seed + 1, loss, delay_us)
    now_us, sent, pilot, truth_ned_m = 0, b"", (), []
    while session.outcome is None and now_us < limit_s * 1e6:
        said = simulator.exchange(now_us, (up(now_us, sent), *pilot))[0]
        step = session.step(now_us, down(now_us, said))
        sent = step.send
        if step.afterwards is not None:
            step.afterwards()
        if each is not None:
            pilot = (each(now_us, session, (up, down)) or b"",)
        session.approve()
        truth_ned_m.append(simulator.truth.position_ned_m)
        now_us += 10_000
    while simulator.report.flight.armed and now_us < limit_s * 1e6:  # nobody steers it now
        simulator.step(now_us, b"")
        truth_ned_m.append(simulator.truth.position_ned_m)
        now_us += 10_000
    to_home = frame.to_vehicle(place)
    return session, to_home.position_enu_m(np.array(truth_ned_m))


def resumed_until_nothing_is_left(inspection, *, seed, **first):
    """Flights as a user resumes them, each by a fresh vehicle; what is special is so in the `first` alone.

    The sessions, the truth of each flight in the plan's ENU, and the shots of each.
    """
    sessions, truths_enu_m, shots, done = [], [], [], ()
    while left_s := left_of(inspection, done):
        assert len(sessions) < 4, (left_s, [session.outcome for session in sessions])
        sortie = inspection.sorties(*left_s[0])[0]
        session, truth_enu_m = flown(inspection, seed=seed + len(sessions), sortie=sortie, **first)
        log, begins_s = session.log(), session.trajectory.span_s("inspection")[0]
        done = (*done, Flown(sortie, inspected_s(log, sortie, begins_s), session.pictures))
        shots.append(estimated_shots(inspection, sortie, log, begins_s, session.pictures))
        sessions.append(session)
        truths_enu_m.append(truth_enu_m)
        first = {}
    return sessions, truths_enu_m, shots


__all__ = ["flown", "resumed_until_nothing_is_left", "together"]
