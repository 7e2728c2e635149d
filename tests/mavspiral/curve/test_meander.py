from itertools import pairwise

import numpy as np
import pytest

from mavspiral.curve.meander import MeanderPath, Row, meander


def row(height_m, west=0.0, east=30.0):
    """Along a wall to the north, from east to west, so that it lies to the right... of nobody: yaw is given."""
    x = np.arange(east, west - 0.1, -0.5)
    points = np.column_stack([x, np.zeros_like(x), np.full_like(x, height_m)])
    return Row(points, np.full(len(x), np.pi / 2), closed=False)


def ring(height_m, radius=12.0):
    angle = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full_like(angle, height_m)])
    return Row(points, angle + np.pi, closed=True)


def test_it_goes_to_and_fro_and_climbs_at_the_ends():
    path, gaze = meander([row(4.0), row(8.0), row(12.0)], smoothing_m=2.0)
    u = np.linspace(0.0, path.u_end_rad, 4000)
    x, y, z = path(u).T
    np.testing.assert_allclose(gaze(u), np.pi / 2, atol=1e-9)
    np.testing.assert_allclose(y, 0.0, atol=1e-9)
    for height_m in (4.0, 8.0, 12.0):
        level = np.abs(z - height_m) < 0.02
        assert np.ptp(x[level]) > 28.0
    middle = np.abs(x - 15.0) < 10.0
    assert np.abs(z[middle, None] - [4.0, 8.0, 12.0]).min(axis=1).max() < 1e-6
    directions = [np.sign(path(u, 1)[middle & (np.abs(z - h) < 0.02), 0].mean()) for h in (4.0, 8.0, 12.0)]
    assert directions == [-1.0, 1.0, -1.0]
    assert (np.diff(z) > -1e-9).all()


def test_no_derivative_jumps_up_to_the_third_and_all_are_derivatives():
    path, _ = meander([row(4.0), ring(8.0), row(12.0, west=-20.0)], smoothing_m=2.0)
    seams = np.arange(1.0, path.u_end_rad - 0.5)
    for order in range(4):
        jump = np.abs(path(seams + 1e-9, order) - path(seams - 1e-9, order)).max()
        assert jump < 1e-6 * max(1.0, np.abs(path(seams, order)).max())
    u, h = np.linspace(0.1, path.u_end_rad - 0.1, 999), 1e-5
    for low, high in pairwise(range(4)):
        slope = (path(u + h, low) - path(u - h, low)) / (2 * h)
        np.testing.assert_allclose(slope, path(u, high), atol=1e-4)
    assert np.linalg.norm(path(np.linspace(0, path.u_end_rad, 9999), 1), axis=1).min() > 0.05


def test_a_row_that_reaches_farther_is_flown_to_its_end_first():
    path, _ = meander([row(4.0), row(8.0, west=-15.0, east=45.0)], smoothing_m=2.0)
    x, _, z = path(np.linspace(0.0, path.u_end_rad, 4000)).T
    upper = np.abs(z - 8.0) < 0.02
    assert x[upper].max() > 44.0 and x[np.abs(z - 8.0) < 2.1].min() < -14.0
    first_end = np.argmax(x < -14.0)
    assert x[first_end:].max() > 44.0 > x[:first_end].max()
    assert np.ptp(x[first_end:][z[first_end:] < 8.02]) > 40.0


def test_closed_rows_go_all_the_way_round_and_the_gaze_is_unwrapped():
    path, gaze = meander([ring(4.0), ring(8.0)], smoothing_m=1.0)
    u = np.linspace(0.0, path.u_end_rad, 5000)
    x, y, z = path(u).T
    for height_m in (4.0, 8.0):
        level = np.abs(z - height_m) < 0.02
        assert np.ptp(np.unwrap(np.arctan2(y[level], x[level]))) > 6.0
    assert np.ptp(gaze(u)) == pytest.approx(4.0 * np.pi, abs=0.1)
    middle = np.hypot(x, y) * 0.0 + np.abs(gaze(u) - np.unwrap(np.arctan2(y, x)) - np.pi)
    assert np.median(np.abs(np.angle(np.exp(1j * middle)))) < 0.02


def test_too_few_places_are_refused():
    with pytest.raises(ValueError, match="4 places, wanted more than 4"):
        MeanderPath(np.zeros((4, 3)))
