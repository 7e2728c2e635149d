"""Homes on roofs, beside walls, in keep-outs and down a slope: where the take-off ends, and what is told where it cannot."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.errors import InputError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.motion.limits import Limits
from mavspiral.motion.turn import TurnGaze
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.survey.solids import Solids
from mavspiral.tour.passes import Piece, flown_in_order, tour_of
from mavspiral.tour.route import TAKEOFF_M, route_of
from mavspiral.tour.transit import MARGIN_M, Ways

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)
FRAME = LocalFrame(GeoPoint(-40.05, -1.93, 1000.0))
KEEPS_M = 4.0
ROOF_M = 20.0


def stage(rough_m=0.0, thing="the building"):
    """A block of 40 × 40 m and 20 m high about the origin, and a pass past it that begins 50 m south."""
    heights = np.zeros((160, 160))
    heights[60:100, 60:100] = ROOF_M - rough_m * np.random.default_rng(4).uniform(size=(40, 40))
    grid = HeightMap(heights, 1.0, FRAME, np.array([-80.0, -80.0]))
    ways = Ways(
        Solids.of_map(grid),
        FRAME,
        ROOF_M,
        LIMITS,
        KEEPS_M,
        60.0,
        radius_m=0.4,
        named=lambda place, sweep: thing,
        smaller=lambda m: f"{m:.2f} m",
    )
    gaze = TurnGaze(1.5, 1.5)
    piece = Piece("a", "spiral", LinePath((0, -50, 8), (30, -50, 8)), gaze, 1, 2, 8.0, LIMITS, TurnGaze(0, 0))
    tour = tour_of(flown_in_order([piece]), ways)
    return lambda home_enu_m: route_of(Site(grid, heights > 0), tour, np.array(home_enu_m, dtype=float), ways)


@pytest.mark.parametrize("home_up_m", [ROOF_M - 0.4, ROOF_M - 1e-4, ROOF_M, ROOF_M + 0.3])
@pytest.mark.parametrize("rough_m", [0.0, 0.4])
def test_from_a_roof_it_takes_off_until_the_roof_is_far_enough_below(home_up_m, rough_m):
    """Wherever on it home is said to be: the earth's curvature alone makes 0.1 mm of 40 m."""
    route = stage(rough_m)((3.3, 5.2, home_up_m - rough_m / 2))
    up_m = route(0.0).position_enu_m[2]
    assert up_m >= ROOF_M - rough_m + KEEPS_M + MARGIN_M - 1e-9
    assert up_m <= ROOF_M + KEEPS_M + MARGIN_M + 0.3
    assert route(route.duration_s).position_enu_m[2] == pytest.approx(up_m)


@pytest.mark.parametrize("home_up_m", [-4.0, -12.0, -60.0])
def test_from_down_a_slope_it_climbs_first_because_nothing_tells_where_the_slope_rises(home_up_m):
    route = stage()((-10.0, -70.0, home_up_m))
    places_m = route.sampled(0.1).position_enu_m
    away = np.hypot(places_m[:, 0] + 10.0, places_m[:, 1] + 70.0) > 1e-6
    assert places_m[0, 2] == pytest.approx(home_up_m + TAKEOFF_M)
    assert places_m[away, 2].min() >= 7.9
    assert places_m[-1] == pytest.approx([-10.0, -70.0, home_up_m + TAKEOFF_M])


def test_from_hardly_below_the_ground_it_goes_straight():
    (first, *_) = (leg for leg in stage()((-10.0, -70.0, -3.0)).legs if leg.name.startswith("approach"))
    assert first.path(first.path.u_end_rad) == pytest.approx([0.0, -50.0, 8.0])


def told(home_enu_m, **how):
    with pytest.raises(InputError) as refusal:
        stage(**how)(home_enu_m)
    return str(refusal.value)


def fixed_home(words, up_m):
    lat, lon = re.search(r"home = \[(-?[\d.]+), (-?[\d.]+)\], [\d.]+ m away", words).groups()
    return FRAME.to_enu(float(lat), float(lon), FRAME.origin.alt_amsl_m + up_m)


@pytest.mark.parametrize("beside_m", [0.3, 3.99, 4.2, 4.49])
def test_a_home_too_near_to_a_wall_is_given_a_place_that_does(beside_m):
    words = told((-20.0 - beside_m, 3.3, 0.0))
    assert f"is {beside_m:.2f} m from the building, 4." in words
    stage()(fixed_home(words, 0.0))


def test_a_home_within_a_wall_may_move_out_or_go_up():
    words = told((3.3, 5.2, 0.0))
    assert "0.0 m above ground, is inside something 20.0 m high. Fix: home = " in words
    stage()(fixed_home(words, 0.0))
    up_m = float(re.search(r"or home_height_m = ([\d.]+) to start", words)[1])
    stage()((3.3, 5.2, up_m))


def test_nobody_starts_from_on_top_of_a_keep_out():
    words = told((3.3, 5.2, 0.0), thing='keepout "crane" at lat 1, lon 2, 20.0 m high')
    assert 'is inside keepout "crane"' in words and "home_height_m" not in words
    stage()(fixed_home(words, 0.0))


def test_a_ceiling_too_low_for_the_take_off_names_one_that_does():
    heights = HeightMap(np.zeros((4, 4)), 1.0, FRAME, np.array([0.0, 0.0]))
    ways = Ways(
        Solids.of_map(heights),
        FRAME,
        0.0,
        LIMITS,
        3.0,
        20.0,
        radius_m=0.4,
        named=lambda *_: "",
        smaller=lambda _: "",
    )
    gaze = TurnGaze(1.5, 1.5)
    piece = Piece("a", "spiral", LinePath((0, 0, 8), (9, 0, 8)), gaze, 1, 2, 8.0, LIMITS, TurnGaze(0, 0))
    tour, site = tour_of(flown_in_order([piece]), ways), Site(heights, np.zeros((4, 4), dtype=bool))
    with pytest.raises(InputError) as refusal:
        route_of(site, tour, np.array([0.0, 0.0, 16.55]), ways)
    most_m, ceiling_m = map(
        float, re.search(r"at most ([\d.]+), or ceiling_m ≥ (\d+)", str(refusal.value)).groups()
    )
    route_of(site, tour, np.array([0.0, 0.0, most_m]), ways)
    route_of(site, tour, np.array([0.0, 0.0, 16.55]), replace(ways, ceiling_m=ceiling_m))
