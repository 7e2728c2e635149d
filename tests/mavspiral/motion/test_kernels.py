"""Each kernel against a slow twin or another's work."""

from dataclasses import astuple, replace

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.motion import kernels
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory


def tabulate(path, gaze, rows):
    u = np.linspace(0.0, path.u_end_rad, rows)
    return np.column_stack([*(path(u, order) for order in (1, 2, 3)), gaze(u, 1), gaze(u, 2)]), u


def without_jerk(table, du, limits):
    bounds = np.array(astuple(limits))
    return kernels.fastest_rates(table, du, kernels.rate_caps(table, bounds), bounds, np.ones(len(table)))


def test_without_jerk_it_is_toppra(make_helix, make_gaze, limits):
    """TOPP-RA with the norm as a 64-gon about it: a level curve, so the plane is enough."""
    toppra = pytest.importorskip("toppra")
    toppra.setup_logging("ERROR")
    path, gaze = make_helix(turns=1, pitch_m=0.0), make_gaze(sway_rad=0.4)
    limits = replace(limits, yaw_acceleration_radps2=0.15)  # so that it binds
    table, u = tabulate(path, gaze, 800)
    angles = 2 * np.pi * np.arange(64) / 64

    class Curve(toppra.interpolator.AbstractGeometricPath):
        path_interval = np.array([0.0, path.u_end_rad])
        dof = 2

        def __call__(self, positions, order=0):
            return path(positions, order)[..., :2]

    class Norms(toppra.constraint.LinearConstraint):
        """|p″b + p′a| ≤ A, |ψ″b + ψ′a| ≤ α; b from the norms of speed and yaw rate."""

        def compute_constraint_params(self, path, gridpoints):
            first, second, last = (np.zeros((len(u), 3)) for _ in range(3))
            first[:, :2], first[:, 2] = table[:, 0:2], table[:, 9]
            second[:, :2], second[:, 2] = table[:, 3:5], table[:, 10]
            faces = np.vstack(
                [np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]), [0, 0, 1], [0, 0, -1]]
            )
            bounds = np.array([limits.acceleration_mps2] * 64 + [limits.yaw_acceleration_radps2] * 2)
            fastest = np.minimum(
                limits.speed_mps**2 / np.sum(table[:, :2] ** 2, axis=1),
                (limits.yaw_rate_radps / table[:, 9]) ** 2,
            )
            squares = np.column_stack([np.zeros(len(u)), fastest])
            return first, second, last, np.array([faces] * len(u)), np.array([bounds] * len(u)), None, squares

    solver = toppra.algorithm.TOPPRA([Norms()], Curve(), gridpoints=u, solver_wrapper="seidel")
    _, theirs, _ = solver.compute_parameterization(0.0, 0.0)
    ours = without_jerk(table, u[1], limits)
    np.testing.assert_allclose(ours[1:-1], theirs[1:-1], rtol=5e-3)
    ours_s, theirs_s = (kernels.time_grid(rates, u[1])[-1] for rates in (ours, np.asarray(theirs)))
    assert theirs_s * (1 - 1e-6) <= ours_s <= 1.001 * theirs_s  # their polygon lies outside of our circle


@pytest.mark.parametrize(("height", "bound"), [(30.0, "climb_mps"), (-30.0, "descent_mps")])
def test_a_steep_way_is_capped_by_climb_or_descent(limits, height, bound):
    table, _ = tabulate(LinePath([0, 0, 40], [4, 0, 40 + height]), lambda u, order=0: 0.0 * u, 50)
    caps = kernels.rate_caps(table, np.array(astuple(limits)))
    np.testing.assert_allclose(30.0 * np.sqrt(caps), getattr(limits, bound))


def test_without_jerk_a_line_is_a_trapezium(make_gaze, limits):
    table, u = tabulate(LinePath([0, 0, 0], [30, 40, 0]), lambda u, order=0: 0.0 * u, 4001)
    times = kernels.time_grid(without_jerk(table, u[1], limits), u[1])
    assert times[-1] == pytest.approx(
        50 / limits.speed_mps + limits.speed_mps / limits.acceleration_mps2, rel=1e-4
    )
    np.testing.assert_allclose(times + times[::-1], times[-1], atol=1e-6)


def test_hills_are_cut_where_they_take_the_window():
    distance = np.linspace(0.0, 8.0, 4001)
    speed = np.sqrt(2 * 2.0 * np.minimum(distance, 8.0 - distance))  # 2 m/s² up, 2 m/s² down
    cut = kernels.level_hills(speed, distance, 0.5)
    level = (-0.5 + np.sqrt(0.5**2 + 4 * 8.0 / 2.0)) / 2 * 2.0  # 8 - c²/2 = 0.5·c
    assert cut.max() == pytest.approx(level, rel=1e-3)
    np.testing.assert_array_equal(cut, np.minimum(speed, cut.max()))


def test_no_hill_is_left_that_is_crossed_sooner_than_the_window():
    rng = np.random.default_rng(3)
    distance = np.linspace(0.0, 100.0, 3001)
    waves = sum(rng.uniform(0, 1) * np.sin(k * distance / 5 + rng.uniform(0, 6)) for k in range(1, 9))
    speed = (4.0 + waves) * np.minimum(1.0, np.minimum(distance, 100 - distance) / 10)
    cut = kernels.level_hills(speed, distance, 0.6)
    assert np.all(cut <= speed)
    assert np.mean(cut == speed) > 0.5
    tops = [i for i in range(1, 3000) if cut[i] > cut[i - 1] and cut[i] >= cut[i + 1]]
    for i in tops:
        end = i
        while cut[end + 1] >= cut[i] * (1 - 1e-9):
            end += 1
        if cut[end + 1] < cut[i]:
            assert distance[end] - distance[i - 1] >= 0.6 * cut[i] * 0.95


def test_knots_are_the_running_mean(limits):
    rng = np.random.default_rng(1)
    rates = np.concatenate([[0.0], rng.uniform(0.5, 2.0, 40), [0.0]])
    times = kernels.time_grid(rates, 0.1)
    steps, width = 4000, 300
    u, u1, u2 = kernels.knots(rates, times, steps, width, 4.1)
    dt = times[-1] / steps
    window = width * dt
    fine = np.linspace(0.0, 1.0, 4001)
    for k in range(100, steps, 391):
        behind = k * dt - window * fine
        mean = np.trapezoid(np.interp(behind, times, rates, left=0.0, right=0.0), fine)
        assert u1[k] == pytest.approx(mean, rel=1e-3)
    assert u[-1] == 4.1
    np.testing.assert_allclose(np.gradient(u, dt)[1:-1], u1[1:-1], atol=1e-4)
    np.testing.assert_allclose(np.gradient(u1, dt)[1:-1], u2[1:-1], atol=5e-2)


def test_demand_is_what_the_trajectory_shows(make_helix, make_gaze, limits):
    path, gaze = make_helix(turns=2), make_gaze()
    law = fastest_law(path, gaze, limits)
    table, u = tabulate(path, gaze, 3000)
    shown = kernels.demand(
        table,
        u[1],
        np.array(astuple(limits)),
        np.zeros(0),
        law.step_s,
        law.phase_rad,
        law.phase_rate_radps,
        law.phase_acceleration_radps2,
    )
    t = law.step_s * np.arange(len(law.phase_rad))
    flight = Trajectory((Leg("leg", path, gaze, law),))
    expected = np.zeros(len(t))
    for side in (-1e-9, 1e-9):  # the jerk steps at the knots
        state = flight(t + side)

        def norm(vectors):
            return np.linalg.norm(vectors, axis=1)

        climb = state.velocity_enu_mps[:, 2]
        first = [
            norm(state.velocity_enu_mps) / limits.speed_mps,
            climb / limits.climb_mps,
            -climb / limits.descent_mps,
            np.abs(state.yaw_rate_enu_radps) / limits.yaw_rate_radps,
        ]
        second = [
            norm(state.acceleration_enu_mps2) / limits.acceleration_mps2,
            np.abs(state.yaw_acceleration_enu_radps2) / limits.yaw_acceleration_radps2,
        ]
        third = norm(state.jerk_enu_mps3) / limits.jerk_mps3
        expected = np.max([expected, *first, *np.sqrt(second), np.cbrt(third)], axis=0)
    np.testing.assert_allclose(shown[1:-1], expected[1:-1], rtol=1e-5)


@pytest.mark.parametrize(("greatest", "gain_slower"), [(1.2, kernels.GAIN_SLOWER), (1.009, 1.0)])
def test_slowness_follows_the_worst_demand_in_the_window(greatest, gain_slower):
    rng = np.random.default_rng(2)
    times = np.cumsum(np.concatenate([[0.0], rng.uniform(0.01, 0.1, 199)]))
    steps, width = 500, 25
    dt = times[-1] / steps
    ratios = rng.uniform(0.8, greatest, steps + width + 1)
    slowness = rng.uniform(1.0, 1.3, 200)
    after = kernels.adjusted(slowness, times, ratios, dt, width)
    for i in range(200):
        k = min(int(times[i] / dt), len(ratios) - 1)
        worst = ratios[k : k + width + 2].max()
        gain = gain_slower if worst > 1 else kernels.GAIN_FASTER
        assert after[i] == pytest.approx(max(1.0, slowness[i] * worst**gain))


def test_the_way_along_rows_is_that_of_the_curve_and_only_a_line_is_straight(make_helix):
    helix, line = make_helix(turns=3), LinePath([0, 0, 9], [30, 40, 9])
    for path, straight in ((helix, False), (line, True)):
        table, u = tabulate(path, lambda u, order=0: 0.0 * u, 3000)
        pace, way, is_straight = kernels.way_along(table, u[1])
        steps = np.linalg.norm(np.diff(path(u), axis=0), axis=1)
        np.testing.assert_allclose(way[1:], np.cumsum(steps), rtol=1e-4)
        np.testing.assert_allclose(pace, np.linalg.norm(path(u, 1), axis=1), rtol=1e-12)
        assert is_straight is straight


def test_rows_are_the_derivatives_side_by_side_and_the_first_still_one_is_found(make_helix, make_gaze):
    path, gaze = make_helix(turns=1), make_gaze()
    expected, u = tabulate(path, gaze, 50)
    table = kernels.rows(path.jet(u), gaze.jet(u))
    np.testing.assert_array_equal(table, expected)
    assert kernels.first_still(table) == 50
    table[7, :3] = table[9, :3] = 0.0
    table[3, 0] = 0.0
    assert kernels.first_still(table) == 7
