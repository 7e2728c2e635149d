"""Whole flights over a link that loses a third and takes its time, against the bundled vehicle in lockstep."""

from __future__ import annotations

import random

import numpy as np
import pytest

from mavspiral.closedloop import _config
from mavspiral.flight.outcome import SessionConfig
from mavspiral.flight.session import Session
from mavspiral.progress import estimated_shots, inspected_s, together
from mavspiral.sorties import overlapping_s
from mavspiral.survey.solids import Solids
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


def flown(inspection, *, seed, loss=0.0, delay_us=0, each=None, sortie=None, limit_s=900.0):
    """The session, and the truth in the plan's ENU, a row every frame."""
    simulator = Simulator(_config(inspection, seed, 0.0, False, ()))
    sortie = sortie or inspection.sorties()[0]
    session = Session(
        lambda home_enu_m: inspection.route_from(home_enu_m, sortie),
        inspection.site.heights.frame,
        SessionConfig(safe_height_enu_m=inspection.safe_height_enu_m),
        way_home=inspection.way_home,
        shots=inspection.shot_orders(sortie),
    )
    up, down = Air(seed, loss, delay_us), Air(seed + 1, loss, delay_us)
    now_us, sent, truth_ned_m = 0, b"", []
    while session.outcome is None and now_us < limit_s * 1e6:
        said = simulator.step(now_us, up(now_us, sent)).send
        sent = session.step(now_us, down(now_us, said)).send
        if each is not None:
            each(now_us, session, (up, down))
        truth_ned_m.append(simulator.truth.position_ned_m)
        now_us += 10_000
    while simulator.report.flight.armed and now_us < limit_s * 1e6:  # nobody steers it now
        simulator.step(now_us, b"")
        truth_ned_m.append(simulator.truth.position_ned_m)
        now_us += 10_000
    frame = inspection.site.heights.frame
    to_home = frame.to_vehicle(frame.geo_point(inspection.home_enu_m))
    return session, to_home.position_enu_m(np.array(truth_ned_m))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_third_lost_each_way_and_a_fifth_of_a_second_late_it_completes_clear_of_all(planned, seed):
    kiosk = planned("kiosk")
    session, truth_enu_m = flown(kiosk, seed=seed, loss=0.3, delay_us=200_000)
    assert session.outcome is not None and session.outcome.ok, session.outcome
    assert Solids.of_map(kiosk.site.heights).distance_m(truth_enu_m).min() >= kiosk.mission.limits.clearance_m
    missed_n = len(session.missed_shots)
    assert missed_n <= 3, "four times lost is one in a hundred"
    assert len(kiosk.shots) - missed_n - 1 <= len({p.shot for p in session.pictures}) == len(session.pictures)


def test_a_link_that_is_cut_in_mid_inspection_then_resumed_shows_every_wall_in_the_end(planned):
    """Its failsafe brings it home clear of all; the user goes on; the pictures of both flights show what one would."""
    kiosk = planned("kiosk")

    def cut(_, session, airs):
        for air in airs:
            air.cut |= session.path_t_s > 30.0

    session, truth_enu_m = flown(kiosk, seed=3, each=cut)
    assert session.outcome.exit_code == 3 and "link lost" in session.outcome.reason
    solids = Solids.of_map(kiosk.site.heights)
    assert solids.distance_m(truth_enu_m).min() >= kiosk.mission.limits.clearance_m
    assert np.linalg.norm(truth_enu_m[-1] - kiosk.home_enu_m) < 2.0

    whole, log = kiosk.sorties()[0], session.log()
    begins_s = session.trajectory.span_s("inspection")[0]
    done_s = inspected_s(log, whole, begins_s)
    seen = [estimated_shots(kiosk, whole, log, begins_s, session.pictures)]
    assert 5.0 < done_s < kiosk.duration_s - 10.0
    assert kiosk.coverage_from(seen[0]).walls < 0.9

    [rest] = kiosk.sorties(overlapping_s(kiosk.shots_s, done_s))
    session, _ = flown(kiosk, seed=4, sortie=rest)
    assert session.outcome.ok
    begins_s = session.trajectory.span_s("inspection")[0]
    seen.append(estimated_shots(kiosk, rest, session.log(), begins_s, session.pictures))
    assert len(seen[0]) + len(seen[1]) > len(kiosk.shots)
    both = kiosk.coverage_from(together(tuple(seen)))
    assert both.walls == pytest.approx(kiosk.coverage.walls, abs=0.005)
