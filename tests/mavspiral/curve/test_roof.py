"""Ways above roofs, from the map to what is seen: the brute-force distance, the limits and the pictures judge them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.curve.gaze import GIMBAL_RADPS
from mavspiral.curve.line import LinePath
from mavspiral.motion.limits import Limits
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.pieces.roof_ways import RoofLook
from mavspiral.pieces.roofs import roof_pieces
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.survey.camera import Camera
from mavspiral.survey.certificate import gimbal_figure, motion_figures
from mavspiral.survey.coverage import Demand, measure_coverage
from mavspiral.survey.patches import patches_of
from mavspiral.survey.peaks import peaks_of
from mavspiral.survey.shots import shots_of
from mavspiral.tour.passes import flown_in_order

CAMERA = Camera(0.0088, (0.0132, 0.0088), (5472, 3648), 0.0005, 0.7, True)
PORTRAIT = Camera(0.0088, (0.0088, 0.0132), (3648, 5472), 0.0005, 0.7, True)
DEMAND = Demand(0.005, math.radians(60), 1)
LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, math.radians(45), math.radians(45))
SETBACKS = [(10, 10, 50, 50, 10), (14, 14, 46, 46, 30), (17, 17, 43, 43, 50)]
PODIUM = [(10, 10, 70, 60, 10), (40, 25, 60, 45, 40)]
ELL = [(10, 10, 60, 25, 10), (10, 10, 25, 60, 10)]


def pieces_above(site, standoff_m=8.0, required_m=2.5, camera=CAMERA):
    look = RoofLook.of(
        camera, DEMAND, standoff_m=standoff_m, overlap=0.25, side_overlap=0.6, required_m=required_m
    )
    return roof_pieces(site, look, LIMITS, start_enu_m=np.array([-30.0, -30.0]))


def flown(pieces):
    legs = [each.leg for each in flown_in_order(pieces)]
    return [Trajectory((Leg("inspection", leg.path, leg.gaze, leg.law, leg.gimbal_pitch),)) for leg in legs]


def roof_seen(site, pieces, standoff_m=8.0, camera=CAMERA):
    """The share of the roofs that the shots show, and the places of what they do not."""
    patches = patches_of(site)
    views = np.zeros(len(patches), dtype=np.int64)
    for flight in flown(pieces):
        shots = shots_of(
            flight, camera, standoffs_m=[standoff_m] * len(flight.spans_s("inspection")), side_overlap=0.6
        )
        views += measure_coverage(patches, shots, site, camera, DEMAND).views
    area_m2, seen = patches.area_m2[~patches.is_wall], views[~patches.is_wall] > 0
    return area_m2[seen].sum() / area_m2.sum(), patches.centre_enu_m[~patches.is_wall][~seen]


def places(path, count=2000):
    return path(np.linspace(0.0, path.u_end_rad, count))


def turned(size_m, cell_m, angle_rad):
    """The distances along and across a turned cross of axes through the middle, of each cell."""
    count = round(size_m / cell_m)
    c = (np.arange(count) + 0.5) * cell_m - 0.5 * size_m
    x, y = np.meshgrid(c, c)
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return cos * x + sin * y, cos * y - sin * x


def site_of(heights, cell_m, origin=(0.0, 0.0)):
    return Site(HeightMap(heights, cell_m, None, np.array(origin)), heights > 0.0)


def gabled(rng):
    """A gabled house, at times with a cross wing and a tower at one end."""
    along, across = turned(60.0, 0.25, rng.uniform(0.0, math.pi))
    length, width, slope, eaves = (
        rng.uniform(6, 18),
        rng.uniform(4, 9),
        rng.uniform(0.3, 1.0),
        rng.uniform(3, 9),
    )
    roof = eaves + slope * (width - abs(across))
    heights = np.where((abs(along) < length) & (abs(across) < width), roof, 0.0)
    if rng.uniform() < 0.4:
        wing = (abs(across) < length) & (abs(along - 0.5 * length) < 0.7 * width)
        heights = np.where(
            wing, np.maximum(heights, eaves + slope * (0.7 * width - abs(along - 0.5 * length))), heights
        )
    if rng.uniform() < 0.4:
        heights[(abs(along + length) < 3) & (abs(across) < 3)] = eaves + 15.0
    return site_of(heights, 0.25, tuple(rng.uniform(-50.0, 50.0, 2)))


@pytest.mark.parametrize("seed", range(16))
def test_every_way_keeps_the_clearance_and_all_limits(seed, random_site, box_distance):
    rng = np.random.default_rng(seed)
    site = gabled(rng) if seed % 2 else random_site(rng)
    standoff_m = float(rng.uniform(5.0, 14.0))
    required_m = float(rng.uniform(1.5, min(4.0, standoff_m - 1.0)))
    pieces = pieces_above(site, standoff_m, required_m)
    assert pieces
    for piece in pieces:
        assert box_distance(site, places(piece.path)).min() >= required_m
    for flight in flown(pieces):
        peaks = peaks_of(flight, flight.grid_s(0.01))
        figures = (*motion_figures(peaks, LIMITS), gimbal_figure(peaks))
        assert [str(figure) for figure in figures if not figure.ok] == []
        states = flight.sampled(0.01)
        rate = np.abs(np.diff(states.gimbal_pitch_rad)) / 0.01
        assert rate.max() <= GIMBAL_RADPS


@pytest.mark.parametrize("boxes", [[(20, 20, 50, 45, 10)], ELL, [(20, 20, 50, 45, 10), (30, 30, 50, 45, 11)]])
def test_above_a_roof_without_towers_nothing_comes_nearer_than_the_stand_off(boxes, blocks, box_distance):
    site = blocks(*boxes, size=(80, 80))
    for piece in pieces_above(site):
        distance = box_distance(site, places(piece.path))
        assert distance.min() >= 8.0 - 0.01
        assert np.median(distance) < 8.5


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32))
def test_a_flat_rectangular_roof_is_seen_but_for_a_cell_in_a_corner(seed):
    rng = np.random.default_rng(seed)
    cell_m, standoff_m = float(rng.choice([0.25, 0.5])), float(rng.uniform(4.0, 14.0))
    along, across = turned(100.0, cell_m, rng.uniform(0.0, math.pi))
    inside = (abs(along) < rng.uniform(5, 30)) & (abs(across) < rng.uniform(5, 20))
    site = site_of(np.where(inside, 8.0, 0.0), cell_m)
    share, unseen = roof_seen(site, pieces_above(site, standoff_m, min(3.0, standoff_m - 1.0)), standoff_m)
    assert share >= 0.998, unseen


@pytest.mark.parametrize(
    ("boxes", "standoff_m", "count"),
    [
        (ELL, 8.0, 1),
        ([*ELL, (45, 10, 60, 60, 10)], 8.0, 1),  # a U
        ([(10, 10, 70, 70, 10), (25, 25, 55, 55, 0)], 8.0, 1),  # around a court
        (PODIUM, 8.0, 2),
        ([(10, 10, 70, 60, 10), (50, 40, 70, 60, 40)], 8.0, 2),  # a tower in the podium's corner
        (SETBACKS, 10.0, 3),
        ([(10, 10, 30, 40, 6), (30, 10, 50, 40, 8), (50, 10, 70, 40, 13)], 8.0, 2),  # low steps part no roofs
        ([(10, 10, 70, 17, 6)], 8.0, 1),  # one strip of pictures
        ([(10, 10, 18, 18, 6)], 6.0, 1),
    ],
)
def test_roofs_of_every_kind_are_seen(boxes, standoff_m, count, blocks):
    site = blocks(*boxes, size=(80, 80))
    pieces = pieces_above(site, standoff_m)
    assert len(pieces) == count
    assert roof_seen(site, pieces, standoff_m)[0] >= 0.98


def test_the_camera_tilts_towards_a_gables_slope():
    along, across = turned(60.0, 0.25, 0.4)
    heights = np.where((abs(along) < 14) & (abs(across) < 7), 16.0 - abs(across), 0.0)
    site = site_of(heights, 0.25)
    pieces = pieces_above(site, 11.0)
    assert roof_seen(site, pieces, 11.0)[0] >= 0.97
    pitch = np.degrees(flown(pieces)[0].sampled(0.1).gimbal_pitch_rad)
    assert -80.0 < np.median(pitch) < -40.0


def test_a_terrace_is_looked_at_from_a_ring_around_what_stands_on_it(blocks, box_distance):
    site = blocks(*SETBACKS, size=(60, 60))
    above, upper, lower = pieces_above(site, 10.0)
    for ring, base_m in ((upper, 30.0), (lower, 10.0)):
        place = places(ring.path)
        np.testing.assert_allclose(place[0], place[-1], atol=0.3)
        assert place[:, 2].min() > base_m + 6.0
        pitch = np.degrees(ring.gimbal_pitch(np.linspace(0.0, ring.path.u_end_rad, 50)))
        assert (pitch.min() > -75.0, pitch.max() < -40.0) == (True, True)
        assert box_distance(site, place).min() > 7.0
    assert np.degrees(above.gimbal_pitch(np.linspace(0.0, above.path.u_end_rad, 50))).min() == pytest.approx(
        -90.0
    )


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_are_derivatives(order, blocks):
    for piece in pieces_above(blocks(*PODIUM, size=(80, 80))):
        u = np.linspace(0.01, piece.path.u_end_rad - 0.01, 3000)
        slope = (piece.path(u + 1e-5, order - 1) - piece.path(u - 1e-5, order - 1)) / 2e-5
        np.testing.assert_allclose(
            slope, piece.path(u, order), atol=2e-4 * np.abs(piece.path(u, order)).max()
        )


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_no_derivative_jumps_at_any_seam(order, blocks):
    (piece,) = pieces_above(site := blocks((10, 10, 50, 40, 8), (20, 20, 30, 40, 9.5), size=(60, 50)))
    assert site.heights.top_m == 9.5
    path = piece.path
    keys = np.arange(1, round(path.u_end_rad / path.key_rad)) * path.key_rad
    knots = np.arange(1, len(path.height_m.knots) - 5) * path.height_m.knot_rad
    seams = np.concatenate([keys, knots])
    jump = np.abs(path(seams + 1e-9, order) - path(seams - 1e-9, order)).max()
    assert np.ptp(path(seams)[:, 2]) > 0.5
    assert jump < 1e-6 * np.abs(path(seams, order)).max() + 1e-6


def test_the_spiral_goes_inward_and_ends_in_the_middle(blocks):
    (piece,) = pieces_above(blocks((20, 20, 80, 60, 10), size=(100, 80)), 12.0)
    place = places(piece.path)
    x, y = place[:, 0], place[:, 1]
    assert np.sum(x[:-1] * np.diff(y) - y[:-1] * np.diff(x)) > 0.0
    from_edge = np.minimum(np.minimum(x - 20, 80 - x), np.minimum(y - 20, 60 - y))
    quarters = [part.mean() for part in np.array_split(from_edge, 4)]
    assert quarters == sorted(quarters)
    assert from_edge[-1] > 15.0
    assert np.ptp(place[:, 2]) == pytest.approx(0.0, abs=1e-9)
    assert place[0, 2] == pytest.approx(22.0)


def test_a_portrait_camera_takes_fewer_turns_and_sees_as_much(blocks):
    site = blocks((20, 20, 60, 60, 10), size=(80, 80))
    lengths_m = {}
    for camera in (CAMERA, PORTRAIT):
        pieces = pieces_above(site, camera=camera)
        lengths_m[camera.sensor_m] = sum(each.length_m for each in flown_in_order(pieces))
        assert roof_seen(site, pieces, camera=camera)[0] >= 0.995
    assert lengths_m[PORTRAIT.sensor_m] < 0.8 * lengths_m[CAMERA.sensor_m]


def test_a_roof_smaller_than_a_picture_is_crossed_on_a_line(blocks):
    site = blocks((10, 10, 22, 14, 6), size=(40, 30))
    (piece,) = pieces_above(site)
    assert isinstance(piece.path, LinePath)
    assert roof_seen(site, (piece,))[0] == 1.0


def test_a_neighbour_above_the_roof_is_kept_from(blocks, box_distance):
    house = blocks((10, 10, 40, 30, 8), (43, 10, 55, 30, 30), size=(60, 50))
    east = house.heights.centres_enu_m()[0] > 41.0
    site = Site(house.heights, house.building & ~east)
    (piece,) = pieces_above(site, required_m=3.0)
    assert box_distance(house, places(piece.path)).min() >= 3.0
    assert piece.path(0.0)[2] < 20.0
