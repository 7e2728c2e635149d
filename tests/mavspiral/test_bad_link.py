"""Whole flights over a link that loses a third and takes its time, against the bundled vehicle in lockstep."""

from __future__ import annotations

import numpy as np
import pytest
from lockstep import flown

from mavspiral.progress import estimated_shots, inspected_s, together
from mavspiral.sorties import overlapping_s
from mavspiral.survey.solids import Solids


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

    def cut(_, session, airs, __):
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
