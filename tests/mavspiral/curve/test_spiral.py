from itertools import pairwise

import numpy as np
import pytest

from mavspiral.curve import Path
from mavspiral.curve.mixing import BASIS, DEGREE
from mavspiral.curve.spiral import TOLERANCE_M
from mavspiral.errors import InputError, LimitError

PODIUM_AND_TOWER = [(0, 0, 60, 40, 12), (0, 0, 12, 12, 50)]
PODIUM_AND_COURT = [(0, 0, 60, 40, 10), (0, 0, 60, 8, 40), (0, 0, 8, 40, 40), (52, 0, 60, 40, 40)]
NUMBERS = {"standoff_m": 8.0, "rise_m": 5.0, "bottom_m": 3.0, "clearance_m": 4.0, "corner_radius_m": 3.0}


def samples(path, spacing_m=0.3):
    u = np.linspace(0.0, path.u_end_rad, 200)
    length_m = np.linalg.norm(path(u, 1), axis=1).mean() * path.u_end_rad
    return np.linspace(0.0, path.u_end_rad, int(length_m / spacing_m))


def outlines_mixed(path, u_rad, order):
    """The slow twin: key by key, with FourierCurve and numpy's polynomials."""
    total = np.zeros((len(u_rad), 2))
    span = np.minimum(np.floor(u_rad / path.key_rad).astype(int), len(path.of_key) - DEGREE - 1)
    binomial = [[1], [1, 1], [1, 2, 1], [1, 3, 3, 1]][order]
    for i, (u, j) in enumerate(zip(u_rad, span, strict=True)):
        for k in range(DEGREE + 1):
            piece = np.polynomial.Polynomial(BASIS[0, k])
            for m, times in enumerate(binomial):
                weight = (piece.deriv(m) if m else piece)(u / path.key_rad - j) / path.key_rad**m
                total[i] += times * weight * path.outline(j + k)(u, order - m)
    return total


@pytest.mark.parametrize("seed", range(25))
def test_the_flown_curve_keeps_its_distance(seed, random_site, box_distance, spiral_round):
    rng = np.random.default_rng(seed)
    site = random_site(rng)
    standoff_m, top_m = float(rng.uniform(4.0, 15.0)), site.heights.top_m
    clearance_m = float(rng.uniform(1.0, min(standoff_m, 6.0)))
    planned = spiral_round(
        site,
        standoff_m=standoff_m,
        rise_m=float(rng.uniform(3.0, 10.0)),
        bottom_m=min(2.0, top_m),
        top_m=top_m + float(rng.uniform(-1.0, 3.0)),
        clearance_m=clearance_m,
        corner_radius_m=float(rng.choice([0.0, 1.0, 2.0, 4.0, 8.0])),
    )
    distance = box_distance(site, planned.path(samples(planned.path)))
    assert distance.min() >= max(standoff_m - TOLERANCE_M, clearance_m) - 0.01
    assert distance.min() >= planned.clearance_min_m - 0.01


@pytest.mark.parametrize("boxes", [PODIUM_AND_TOWER, PODIUM_AND_COURT])
def test_an_outline_that_jumps_walks_gently_and_arrives(boxes, blocks, box_distance, spiral_round):
    site = blocks(*boxes, size=(60, 40))
    path = spiral_round(site, top_m=39.0, **NUMBERS).path
    u = samples(path)
    slope = np.abs(path(u, 1)[:, 2]) / np.linalg.norm(path(u, 1)[:, :2], axis=1)
    assert slope.max() < 0.15
    last = u > path.u_end_rad - 2.0 * np.pi
    distance = box_distance(site, path(u[last]))
    assert abs(np.median(distance) - 8.0) < 0.1
    assert distance.max() < 8.0 + 3.0 * 0.4143 + 0.2
    outlines = [path.outline(k)(np.linspace(0.0, 6.28, 200)) for k in range(len(path.of_key))]
    assert max(np.linalg.norm(b - a, axis=1).max() for a, b in pairwise(outlines)) < 6.0


def test_every_turn_rises_alike_between_two_level_turns(blocks, spiral_round):
    path = spiral_round(blocks((10, 10, 40, 30, 40)), top_m=38.0, **NUMBERS).path
    assert path.rings == 7
    turn = 2.0 * np.pi
    assert np.ptp(path(np.linspace(0.0, turn, 50))[:, 2]) == 0.0
    assert np.ptp(path(np.linspace(path.u_end_rad - turn, path.u_end_rad, 50))[:, 2]) < 1e-9
    u = np.linspace(turn + 1.6, 7.0 * turn - 0.1, 40)
    np.testing.assert_allclose(path(u + turn)[:, 2] - path(u)[:, 2], 5.0, atol=1e-9)
    np.testing.assert_allclose(path([0.0, path.u_end_rad])[:, 2], [3.0, 38.0], atol=1e-9)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_the_kernel_is_the_sum_it_says(order, blocks, spiral_round):
    path = spiral_round(blocks(*PODIUM_AND_TOWER, size=(60, 40)), top_m=30.0, **NUMBERS).path
    u = np.random.default_rng(1).uniform(0.0, path.u_end_rad - 7.0, 60)
    np.testing.assert_allclose(path(u, order)[:, :2], outlines_mixed(path, u, order), rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_are_derivatives(order, blocks, spiral_round):
    path: Path = spiral_round(blocks(*PODIUM_AND_TOWER, size=(60, 40)), top_m=30.0, **NUMBERS).path
    u = np.linspace(0.01, path.u_end_rad - 0.01, 3000)
    h = 1e-5
    slope = (path(u + h, order - 1) - path(u - h, order - 1)) / (2.0 * h)
    np.testing.assert_allclose(slope, path(u, order), atol=1e-4 * np.abs(path(u, order)).max())


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_no_derivative_jumps_at_any_seam(order, blocks, spiral_round):
    path = spiral_round(blocks(*PODIUM_AND_TOWER, size=(60, 40)), top_m=30.0, **NUMBERS).path
    turn = 2.0 * np.pi
    keys = np.arange(1, int(path.u_end_rad / path.key_rad)) * path.key_rad
    climb = np.array([turn, turn + np.pi / 2, turn * (path.rings + 1), path.climb.end_rad])
    seams = np.concatenate([keys, climb])
    eps = 1e-9
    jump = np.abs(path(seams + eps, order) - path(seams - eps, order)).max()
    assert jump < 1e-6 * np.abs(path(seams, order)).max() + 1e-6


def test_a_prism_has_one_outline_and_a_kiosk_a_level_turn(blocks, box_distance, spiral_round):
    assert len(spiral_round(blocks((10, 10, 40, 30, 40)), top_m=38.0, **NUMBERS).path.coefficients_m) == 1
    kiosk = blocks((20, 20, 24, 24, 4))
    path = spiral_round(kiosk, top_m=3.0, **{**NUMBERS, "standoff_m": 6.0}).path
    assert path.rings == 0
    assert path.u_end_rad == pytest.approx(2.0 * np.pi)
    assert np.abs(box_distance(kiosk, path(samples(path))) - 6.0).max() < 0.15


def test_places_of_spirals_begun_elsewhere_are_those_of_the_spirals(blocks, spiral_round):
    path = spiral_round(blocks(*PODIUM_AND_TOWER, size=(60, 40)), top_m=48.0, **NUMBERS).path
    assert len(path.coefficients_m) > 1
    phases = np.array([0.0, 0.3, 2.0, 5.9])
    changing = np.flatnonzero(np.diff(path.of_key))[0] * path.key_rad
    for u in (0.0, float(changing), 0.37 * path.u_end_rad, path.u_end_rad):
        slow = np.array([path.begun(phase)(u) for phase in phases])
        np.testing.assert_allclose(path.places_begun(u, phases), slow, atol=1e-9)


def test_it_goes_around_counter_clockwise(blocks, spiral_round):
    path = spiral_round(blocks((10, 10, 40, 30, 40)), top_m=38.0, **NUMBERS).path
    x, y, _ = path(np.linspace(0.0, 2.0 * np.pi, 400)).T
    assert np.sum(x[:-1] * np.diff(y) - y[:-1] * np.diff(x)) > 0.0


def test_a_building_at_the_edge_of_the_map_needs_no_padding(blocks, spiral_round):
    bare = spiral_round(blocks((0, 0, 60, 60, 20)), top_m=18.0, **NUMBERS).path
    wide = spiral_round(blocks((0, 0, 60, 60, 20)).padded(30.0), top_m=18.0, **NUMBERS).path
    u = np.linspace(0.0, bare.u_end_rad, 100)
    np.testing.assert_allclose(bare(u), wide(u), atol=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"clearance_m": 9.0}, "clearance_m is 9.0"),
        ({"top_m": 1.0}, "below bottom_m"),
        ({"rise_m": 0.0}, "rise_m"),
        ({"bottom_m": 60.0, "top_m": 70.0}, "above everything"),
    ],
)
def test_contradictions_are_refused(change, words, blocks, spiral_round):
    with pytest.raises(InputError, match=words):
        spiral_round(blocks((10, 10, 40, 30, 40)), **{**NUMBERS, "top_m": 38.0, **change})


def test_a_curve_that_comes_too_close_is_refused(blocks, monkeypatch, spiral_round):
    monkeypatch.setattr("mavspiral.curve.spiral.harmonics_needed", lambda *_args, **_numbers: 1)
    monkeypatch.setattr("mavspiral.curve.spiral.ATTEMPTS", 1)
    with pytest.raises(LimitError, match="comes within"):
        spiral_round(blocks((0, 0, 60, 10, 40)), top_m=38.0, **{**NUMBERS, "clearance_m": 7.9})
