"""Where spirals are begun: the guess of a way's time is that of the way flown, and no other beginning is quicker."""

from dataclasses import replace

import numpy as np
import pytest

from mavspiral.brief import camera_of, sharpness_of
from mavspiral.errors import LimitError
from mavspiral.tour.begins import PHASES, WON_S, _begun, _is_as_far, begun_where_ways_are_short, ways_s
from mavspiral.tour.passes import Piece, flown_in_order, tour_of
from mavspiral.tour.route import route_of, ways_of
from mavspiral.tour.transit import Look


def pieces_and_ways(inspection):
    """What was flown, as pieces again, and the ways of its site."""
    pieces = [
        Piece(
            part.name,
            part.kind,
            part.path,
            part.leg.gaze,
            part.rings,
            part.harmonics,
            part.standoff_m,
            part.pace,
            part.leg.gimbal_pitch,
        )
        for part in inspection.passes
    ]
    return pieces, ways_of(inspection.mission, inspection.site, inspection.clearance_required_m)


def flown_s(inspection, pieces, ways):
    passes = flown_in_order(pieces, sharpness_of(inspection.mission, camera_of(inspection.mission)))
    return route_of(inspection.site, tour_of(passes, ways), inspection.home_enu_m, ways).duration_s


def test_the_guess_of_a_way_is_what_flying_it_takes(planned):
    inspection = planned("podium")
    _, ways = pieces_and_ways(inspection)
    rng = np.random.default_rng(5)
    places = rng.uniform([-60, -60, 2], [60, 60, 50], (40, 3))
    places = places[ways.solids.distance_m(places) > ways.clearance_m + 1.0]
    start, end = places[: len(places) // 2], places[len(places) // 2 : 2 * (len(places) // 2)]
    look, over = Look(0.0), 0
    for a, b, guess_s in zip(start, end, ways_s(ways, start, end), strict=True):
        legs = ways.legs(a, b, "way", (look, look))
        over += len(legs) == 3
        assert guess_s == pytest.approx(
            sum(leg.law.duration_s for leg in legs), rel=0.05, abs=2.0 * len(legs)
        )
    assert over >= 3


def test_where_there_is_no_way_the_guess_is_infinite(planned):
    _, ways = pieces_and_ways(planned("podium"))
    beside = np.array([[0.0, 0.0, ways.top_m + ways.clearance_m + 0.2], [0.0, -60.0, 5.0]])
    far = np.array([[70.0, 70.0, 3.0], [0.0, 60.0, 5.0]])
    for low_ways in (ways, replace(ways, ceiling_m=12.0)):
        guess_s = ways_s(low_ways, beside, far)
        for a, b, guess in zip(beside, far, guess_s, strict=True):
            try:
                low_ways.legs(a, b, "way", (Look(0.0), Look(0.0)))
                assert np.isfinite(guess)
            except LimitError:
                assert np.isinf(guess)
    assert np.isinf(guess_s).any()


@pytest.mark.parametrize("name", ["l_block", "kiosk"])
def test_no_other_beginning_is_quicker(name, planned):
    inspection = planned(name)
    (piece,), ways = pieces_and_ways(inspection)
    others_s = []
    for choice in range(1, PHASES):
        try:
            others_s.append(flown_s(inspection, [_begun(piece, choice, ways)], ways))
        except LimitError:
            continue
    assert len(others_s) > PHASES / 2
    assert inspection.trajectory.duration_s <= min(others_s) + WON_S + 0.2
    assert inspection.trajectory.duration_s <= 0.95 * max(others_s)
    assert begun_where_ways_are_short([piece], inspection.home_enu_m, ways)[0] is piece


def test_several_spirals_are_begun_to_suit_each_other(planned):
    inspection = planned("podium")
    pieces, ways = pieces_and_ways(inspection)
    assert begun_where_ways_are_short(pieces, inspection.home_enu_m, ways) == tuple(pieces)
    turned = [_begun(piece, PHASES // 2, ways) for piece in pieces]
    again = begun_where_ways_are_short(turned, inspection.home_enu_m, ways)
    as_planned_s = inspection.trajectory.duration_s
    assert flown_s(inspection, again, ways) == pytest.approx(as_planned_s, abs=2 * WON_S)
    assert flown_s(inspection, turned, ways) > as_planned_s + 10.0


def test_a_spiral_that_comes_nearer_is_not_begun_elsewhere(planned):
    (piece,), ways = pieces_and_ways(planned("l_block"))
    assert _is_as_far(piece.path, piece, ways)
    shrunk = piece.path.coefficients_m.copy()
    shrunk[:, 1:] *= 0.97
    assert not _is_as_far(replace(piece.path, coefficients_m=shrunk), piece, ways)
