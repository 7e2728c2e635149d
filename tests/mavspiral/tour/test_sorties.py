"""An inspection cut into sorties: the same curve, with an overlap, and nothing left out."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from mavspiral import inspection
from mavspiral.brief import camera_of, limits_of, pace_of
from mavspiral.errors import LimitError
from mavspiral.motion.timing import fastest_law
from mavspiral.tour.sorties import OVERLAP_SHOTS_N, digest_of, flies, plan_sorties, stretch


@pytest.fixture(scope="module")
def kiosk(planned):
    return planned("kiosk")


@pytest.fixture(scope="module")
def retime(kiosk):
    limits = pace_of(kiosk.mission, camera_of(kiosk.mission), limits_of(kiosk.mission))
    return lambda leg: fastest_law(leg.path, leg.gaze, limits, sight=leg.sight)


@pytest.fixture(scope="module")
def legs(kiosk):
    return kiosk.tour


@pytest.fixture(scope="module")
def shots_s(kiosk):
    return kiosk.shots.t_s - kiosk.trajectory.span_s("inspection")[0]


def work_s(sortie):
    return sum(leg.law.duration_s for leg in sortie.legs)


def test_the_whole_is_the_plan_itself(legs, retime):
    whole = stretch(legs, 0.0, 1e9, retime)
    assert whole.legs == legs
    t_s = np.linspace(0.0, work_s(whole), 50)
    assert np.allclose(whole.inspection_s(t_s), t_s)


def test_a_stretch_is_the_same_curve_from_rest_to_rest(legs, retime):
    """By another road: its own positions against the plan's at the times that it claims."""
    [leg] = legs
    part = stretch(legs, 20.0, 45.0, retime)
    t_s = np.linspace(0.5, work_s(part) - 0.5, 200)
    on_piece = part.legs[0].path(part.legs[0].law(t_s))
    on_plan = leg.path(leg.law(part.inspection_s(t_s)))
    assert np.linalg.norm(on_piece - on_plan, axis=1).max() < 0.01
    assert np.allclose(
        part.legs[0].gaze(part.legs[0].law(t_s)), leg.gaze(leg.law(part.inspection_s(t_s))), atol=0.01
    )
    assert (part.begin_s, part.end_s) == pytest.approx((20.0, 45.0), abs=0.02)
    assert np.allclose(part.legs[0].law([0.0, work_s(part)], 1), 0.0, atol=1e-12)
    assert np.isnan(part.inspection_s([-0.1, work_s(part) + 0.1])).all()


def test_sorties_cover_all_with_an_overlap_and_none_is_too_long(legs, shots_s, retime):
    total_s = legs[0].law.duration_s
    sorties = plan_sorties(
        legs, shots_s, endurance_s=60.0, flight_s=lambda s: 30.0 + work_s(s), retime=retime
    )
    assert len(sorties) >= 3
    assert max(30.0 + work_s(s) for s in sorties) <= 60.0
    assert sorties[0].begin_s == 0.0 and sorties[-1].end_s == pytest.approx(total_s)
    for before, after in itertools.pairwise(sorties):
        shared = (shots_s > after.begin_s - 0.03) & (shots_s < before.end_s + 0.03)
        assert shared.sum() == OVERLAP_SHOTS_N + 1
    lengths_s = [s.end_s - s.begin_s for s in sorties]
    assert max(lengths_s) < 1.6 * min(lengths_s), "about equal: no battery for a last metre"


def test_one_battery_that_lasts_flies_it_in_one(legs, shots_s, retime):
    [only] = plan_sorties(legs, shots_s, endurance_s=1e4, flight_s=work_s, retime=retime)
    assert only.legs == legs


def test_a_battery_that_does_not_even_last_there_and_back_is_refused(legs, shots_s, retime):
    with pytest.raises(LimitError, match="endurance_s = 60 leaves nothing"):
        plan_sorties(legs, shots_s, endurance_s=60.0, flight_s=lambda s: 60.0 + work_s(s), retime=retime)


def test_a_cut_may_be_thought_of_where_a_pass_ends_and_a_way_to_the_next_begins(legs, retime):
    """Every pass takes its last picture at its very end: a moment after it nothing is inspected."""
    [leg] = legs
    tour = tuple(replace(leg, name=name) for name in ("inspection-1", "transit-1", "inspection-2"))
    own_s = np.linspace(0.0, leg.law.duration_s, 20)
    shots_s = np.concatenate([own_s, 2 * leg.law.duration_s + own_s])
    endurance_s = 30.0 + 2.0 * leg.law.duration_s
    sorties = plan_sorties(
        tour, shots_s, endurance_s=endurance_s, flight_s=lambda s: 30.0 + work_s(s), retime=retime
    )
    assert max(30.0 + work_s(s) for s in sorties) <= endurance_s
    flown = np.sum([flies(sortie, shots_s) for sortie in sorties], axis=0)
    assert flown.min() >= 1, "every shot is some sortie's"


def test_another_plan_has_another_digest(planned, legs, shots_s):
    assert digest_of(legs, shots_s) == digest_of(legs, shots_s) == planned("kiosk").digest
    assert planned("asilo").digest != planned("kiosk").digest != digest_of(legs, shots_s + 0.01)


def test_what_stands_there_is_looked_at_once_for_all_sorties(planned, monkeypatch):
    asilo, seen = planned("asilo"), []
    ways_of = inspection.ways_of
    monkeypatch.setattr(inspection, "ways_of", lambda *args: seen.append(args) or ways_of(*args))
    assert len(asilo.sorties(endurance_s=180.0)) > 1
    assert len(seen) == 1
