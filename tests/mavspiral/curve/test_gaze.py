import numpy as np
import pytest

from mavspiral.curve.gaze import YawSpline, box_average, inward_gaze

NUMBERS = {
    "standoff_m": 8.0,
    "rise_m": 5.0,
    "bottom_m": 3.0,
    "top_m": 18.0,
    "clearance_m": 4.0,
    "corner_radius_m": 3.0,
}
COURT = [(0, 0, 60, 12, 20), (0, 0, 12, 40, 20), (48, 0, 60, 40, 20)]


def test_along_a_wall_the_nose_points_at_it(blocks, spiral_round):
    path = spiral_round(blocks((10, 20, 50, 40, 20)), **NUMBERS).path
    gaze = inward_gaze(path, smoothing_m=3.0)
    u = np.linspace(0.0, path.u_end_rad, 2000)
    x, y, _ = path(u).T
    south = (y < 20.0) & (x > 15.0) & (x < 45.0)
    east = (x > 50.0) & (y > 25.0) & (y < 35.0)
    assert np.abs(np.sin(gaze(u[south])) - 1.0).max() < 0.003
    assert np.abs(np.cos(gaze(u[east])) + 1.0).max() < 0.003


@pytest.mark.parametrize("boxes", [COURT, [(10, 20, 50, 40, 20)]])
def test_a_turn_of_the_path_is_a_turn_of_the_nose(boxes, blocks, spiral_round):
    path = spiral_round(blocks(*boxes), **NUMBERS).path
    gaze = inward_gaze(path, smoothing_m=4.0)
    u = np.linspace(0.0, path.u_end_rad - 2.0 * np.pi, 3000)
    np.testing.assert_allclose(gaze(u + 2.0 * np.pi) - gaze(u), 2.0 * np.pi, atol=0.02)
    assert np.abs(np.diff(gaze(u))).max() < 0.15
    assert 0.0 <= gaze(0.0) < 2.0 * np.pi


def test_smoothing_bounds_the_yaw_rate(blocks, spiral_round):
    path = spiral_round(blocks(*COURT), **NUMBERS).path
    u = np.linspace(0.0, path.u_end_rad, 8000)
    speed = np.linalg.norm(path(u, 1), axis=1)
    rates = [np.abs(inward_gaze(path, smoothing_m=s)(u, 1) / speed).max() for s in (1.0, 4.0, 8.0)]
    assert rates == sorted(rates, reverse=True)
    assert rates[1] < np.pi / 4.0


def test_derivatives_are_derivatives_and_do_not_jump(blocks, spiral_round):
    path = spiral_round(blocks(*COURT), **NUMBERS).path
    gaze = inward_gaze(path, smoothing_m=4.0)
    u = np.linspace(0.001, path.u_end_rad - 0.001, 3001)
    h = 1e-6
    for order in (1, 2):
        slope = (gaze(u + h, order - 1) - gaze(u - h, order - 1)) / (2.0 * h)
        np.testing.assert_allclose(slope, gaze(u, order), atol=2e-3 * np.abs(gaze(u, order)).max())
    knots = np.arange(1, int(path.u_end_rad / gaze.knot_rad)) * gaze.knot_rad
    for order in (0, 1, 2):
        jump = np.abs(gaze(knots + 1e-10, order) - gaze(knots - 1e-10, order))
        assert jump.max() < 1e-6 * max(1.0, np.abs(gaze(knots, order)).max())


def test_too_few_knots_are_refused():
    with pytest.raises(ValueError, match="3 knots"):
        YawSpline(np.zeros(3), 0.1)
    with pytest.raises(ValueError, match="order is 3"):
        YawSpline(np.zeros(4), 1.0)(0.0, 3)


@pytest.mark.parametrize("width", [0.3, 4.0, 500.0])
def test_the_average_is_what_the_integral_gains_over_the_window_by_its_width(width):
    rng = np.random.default_rng(5)
    s = np.cumsum(np.concatenate([[0.0, 0.4, 0.0], rng.uniform(0.0, 1.0, 60), [0.0]]))  # some places twice
    values = rng.normal(size=len(s))
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(s))])
    half = np.minimum(0.5 * width, np.minimum(s - s[0], s[-1] - s))
    gained = np.interp(s + half, s, integral) - np.interp(s - half, s, integral)
    expected = np.where(half > 0.0, gained / np.where(half > 0.0, 2 * half, 1.0), values)
    np.testing.assert_allclose(box_average(s, values, width), expected, atol=1e-12)
