"""Holes in a survey: what stands in them is never nearer than the map says, and shadows stay empty."""

import math

import cv2
import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.site_map import MapRequest
from mavspiral.shape.survey_grid import site_from_survey
from mavspiral.shape.unmeasured import fill_holes, gaps_told

CELL_M, TOP_M = 0.25, 20.0
FRAME, SOUTH_WEST_M = LocalFrame(GeoPoint(48.1, 11.5, 0.0)), np.full(2, -30.0)


def house(turn_deg):
    """A house of 30 × 20 m, turned on the grid: along and across it `(rows, cols)`, and which cells it stands on."""
    c = (np.arange(240) + 0.5) * CELL_M - 30.0
    x, y = np.meshgrid(c, c)
    a = math.radians(turn_deg)
    along, across = x * math.cos(a) + y * math.sin(a), y * math.cos(a) - x * math.sin(a)
    return along, across, (abs(along) < 15) & (abs(across) < 10)


def holed(own, hole):
    surface_m = np.where(own, TOP_M, 0.0)
    surface_m[hole] = np.nan
    return surface_m


HOLES = {
    "a hole in a façade": lambda along, across: (abs(along) < 2.2) & (abs(across + 9) < 2.0),
    "a stripe through all": lambda along, across: abs(along - 3) < 0.6,
    "a small hole at a corner": lambda along, across: (abs(along - 15) < 1) & (abs(across - 10) < 1),
    "a hole in the roof": lambda along, across: np.hypot(along, across) < 2.5,
}


@pytest.mark.parametrize("turn_deg", [0.0, 11.0, 25.0, 45.0])
@pytest.mark.parametrize("kind", HOLES)
def test_no_place_is_nearer_to_the_house_than_to_what_the_map_says_of_it(turn_deg, kind):
    along, across, own = house(turn_deg)
    surface_m = holed(own, HOLES[kind](along, across))
    filled_m, filled = fill_holes(surface_m, surface_m > 1.5, CELL_M)
    assert np.array_equal(filled, np.isnan(surface_m) & np.isfinite(filled_m))
    assert np.array_equal(filled_m[~np.isnan(surface_m)], surface_m[~np.isnan(surface_m)])

    def away_m(standing):
        return CELL_M * cv2.distanceTransform(
            (~standing).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE
        )

    told_m, true_m = away_m(filled_m > 1.5), away_m(own)
    far = true_m > 6.0
    assert (told_m - true_m)[far].max() < 0.02
    # Nor much farther out than it is; a corner's small hole is filled whole.
    assert (true_m - told_m)[far].max() < (1.6 if "corner" in kind else 0.4)


@pytest.mark.parametrize("turn_deg", [0.0, 25.0])
def test_a_shadow_beside_a_wall_stays_empty(turn_deg):
    along, across, own = house(turn_deg)
    surface_m = holed(own, (along > 15) & (along < 21) & (abs(across) < 10))
    _, filled = fill_holes(surface_m, surface_m > 1.5, CELL_M)
    assert along[filled].max(initial=15.0) < 15.0 + 3 * CELL_M


def test_a_whole_survey_stays_as_it_is_and_the_ground_has_no_holes():
    along, across, own = house(0.0)
    for hole in (np.zeros_like(own), np.hypot(along - 25, across) < 2):
        surface_m = holed(own, hole)
        filled_m, filled = fill_holes(surface_m, surface_m > 1.5, CELL_M)
        assert np.array_equal(filled_m, surface_m, equal_nan=True)
        assert not filled.any()


@pytest.mark.parametrize("classified", [False, True])
def test_a_stripe_without_data_does_not_cut_a_building_in_two(tmp_path, classified):
    along, across, own = house(25.0)
    surface_m = holed(own, HOLES["a stripe through all"](along, across))
    answer = site_from_survey(
        MapRequest(tmp_path / "dsm.tif", cell_m=CELL_M, ground_amsl_m=0.0),
        surface_m,
        np.zeros_like(surface_m),
        FRAME,
        SOUTH_WEST_M,
        surface_m > 1.5 if classified else None,
        (),
    )
    assert np.count_nonzero(answer.site.building) == pytest.approx(np.count_nonzero(own), rel=0.01)
    hole, *_ = answer.warnings
    assert "of the building was not measured, e.g. at lat 48." in hole
    assert "taken to be as high as what is beside it" in hole


@pytest.mark.parametrize("half_m", [4, 2])
def test_where_a_piece_may_be_hidden_is_said(half_m):
    along, across, own = house(0.0)
    hole = (abs(along - 15) < half_m) & (abs(across - 10) < half_m)
    surface_m = holed(own, hole)
    _, filled = fill_holes(surface_m, surface_m > 1.5, CELL_M)
    measured = ~hole
    told = gaps_told(own & (measured | filled), measured, measured | filled, CELL_M, FRAME, SOUTH_WEST_M)
    assert "at the building's wall, e.g. at lat 48.100" in told[-1]
    assert gaps_told(own, np.ones_like(own), np.ones_like(own), CELL_M, FRAME, SOUTH_WEST_M) == ()
