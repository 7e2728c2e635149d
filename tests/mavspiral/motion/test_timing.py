import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mavspiral.curve.line import LinePath
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze

AHEAD = TurnGaze(0.0, 0.0)


def worst_ratio(path, gaze, law, limits, dt_s):
    """The largest part of any limit that the trajectory uses, sampled every `dt_s`."""
    state = Trajectory((Leg("leg", path, gaze, law),)).sampled(dt_s)
    climb = state.velocity_enu_mps[:, 2]
    return max(
        np.linalg.norm(state.velocity_enu_mps, axis=1).max() / limits.speed_mps,
        climb.max() / limits.climb_mps,
        -climb.min() / limits.descent_mps,
        np.linalg.norm(state.acceleration_enu_mps2, axis=1).max() / limits.acceleration_mps2,
        np.linalg.norm(state.jerk_enu_mps3, axis=1).max() / limits.jerk_mps3,
        np.abs(state.yaw_rate_enu_radps).max() / limits.yaw_rate_radps,
        np.abs(state.yaw_acceleration_enu_radps2).max() / limits.yaw_acceleration_radps2,
    )


def s_curve_s(length, speed, acceleration, jerk):
    """The least time of a straight line, rest to rest, under the three limits: the closed form."""
    peak = min(acceleration, (jerk**2 * length / 2) ** (1 / 3))
    ramp = peak / jerk
    top = min(speed, (-ramp + math.sqrt(ramp**2 + 4 * length / peak)) / 2 * peak)
    if top < peak * ramp - 1e-12:  # the speed limit is met before full acceleration
        ramp = math.sqrt(top / jerk)
        return length / top + 2 * ramp
    return length / top + top / peak + ramp


def drawn_limits():
    def between(low, high):
        return st.floats(low, high)

    return st.builds(
        Limits,
        between(1, 10),
        between(0.5, 4),
        between(0.5, 4),
        between(0.5, 5),
        between(0.7, 12),
        between(0.2, 2),
        between(0.2, 3),
    )


@settings(max_examples=25, deadline=None)
@given(limits=drawn_limits(), data=st.data())
def test_no_limit_is_exceeded_on_a_curve(make_helix, make_gaze, limits, data):
    size = data.draw(st.floats(5, 40))
    bumps = data.draw(st.lists(st.floats(-1, 1), min_size=8, max_size=8))
    harmonics = {1: (size, 0.7 * size)} | {
        k: (size * a / k**3, size * b / k**3)
        for k, a, b in zip((2, 3, 5, 8), bumps[::2], bumps[1::2], strict=True)
    }
    path = make_helix(
        turns=data.draw(st.floats(0.3, 1.2)), harmonics=harmonics, pitch_m=data.draw(st.floats(-4, 4))
    )
    gaze = make_gaze(sway_rad=data.draw(st.floats(0, 0.4)), times=data.draw(st.integers(1, 5)))
    law = fastest_law(path, gaze, limits)
    assert worst_ratio(path, gaze, law, limits, 0.001) <= 1.0


@settings(max_examples=40, deadline=None)
@given(
    limits=drawn_limits(),
    length=st.floats(math.log(0.05), math.log(300)).map(math.exp),
    way=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda way: np.linalg.norm(way) > 0.1),
    turn=st.floats(-3, 3),
)
def test_no_limit_is_exceeded_on_a_line(limits, length, way, turn):
    path = LinePath(
        [3.0, -2.0, 50.0], np.array([3.0, -2.0, 50.0]) + length * np.array(way) / np.linalg.norm(way)
    )
    gaze = TurnGaze(0.5, 0.5 + turn)
    law = fastest_law(path, gaze, limits)
    assert worst_ratio(path, gaze, law, limits, 0.001) <= 1.0


def test_the_law_goes_from_rest_to_rest_and_never_back(make_helix, make_gaze, limits):
    path = make_helix()
    law = fastest_law(path, make_gaze(), limits)
    t = np.linspace(0.0, law.duration_s, 40_001)
    u, rate, acceleration, _ = law.derivatives(t)
    assert u[0] == 0.0
    assert u[-1] == pytest.approx(path.u_end_rad, rel=1e-10)
    assert np.all(rate[1:-1] > 0.0)
    np.testing.assert_allclose([rate[0], rate[-1], acceleration[0], acceleration[-1]], 0.0, atol=1e-9)
    assert np.abs(np.diff(acceleration)).max() < 2e-3 * np.abs(acceleration).max() + 1e-3  # ü is continuous


@pytest.mark.parametrize("length", [0.05, 0.3, 1.0, 2.0, 8.0, 13.0, 60.0, 300.0])
def test_a_straight_line_takes_the_optimal_s_curve(length, limits):
    law = fastest_law(LinePath([0, 0, 9], [length, 0, 9]), AHEAD, limits)
    best_s = s_curve_s(length, limits.speed_mps, limits.acceleration_mps2, limits.jerk_mps3)
    assert best_s * (1 - 1e-6) < law.duration_s < 1.012 * best_s
    t = np.linspace(0.0, law.duration_s, 101)
    np.testing.assert_allclose(law(t) + law(law.duration_s - t), 1.0, atol=2e-3)  # there as back


@pytest.mark.parametrize("length", [1e-9, 1e-7, 1e-5, 1e-3])
def test_a_leg_that_was_cut_beside_its_rest_still_has_a_law(length, limits):
    path = LinePath([0, 0, 0], [length, 0, 0])
    law = fastest_law(path, AHEAD, limits)
    assert law(law.duration_s) == pytest.approx(path.u_end_rad, rel=1e-9)
    assert worst_ratio(path, AHEAD, law, limits, 0.001) <= 1.0
    assert (
        law.duration_s < s_curve_s(length, limits.speed_mps, limits.acceleration_mps2, limits.jerk_mps3) + 0.3
    )


def test_a_vertical_line_knows_up_from_down(limits):
    up, down = LinePath([0, 0, 0], [0, 0, 60]), LinePath([0, 0, 60], [0, 0, 0])
    for path, speed in ((up, limits.climb_mps), (down, limits.descent_mps)):
        best_s = s_curve_s(60.0, speed, limits.acceleration_mps2, limits.jerk_mps3)
        assert fastest_law(path, AHEAD, limits).duration_s == pytest.approx(best_s, rel=0.002)


def test_a_long_turn_on_a_short_way_takes_the_time_of_the_turn(limits):
    law = fastest_law(LinePath([0, 0, 5], [0.05, 0, 5]), TurnGaze(0.0, 3.0), limits)
    least_s = 3.0 / limits.yaw_rate_radps + limits.yaw_rate_radps / limits.yaw_acceleration_radps2
    assert least_s < law.duration_s < 1.2 * least_s


def test_jerk_costs_a_spiral_little(make_helix, make_gaze, limits):
    path, gaze = make_helix(turns=6), make_gaze()
    with_jerk = fastest_law(path, gaze, limits).duration_s
    without = fastest_law(path, gaze, dataclasses.replace(limits, jerk_mps3=400.0)).duration_s
    assert without < with_jerk < 1.02 * without


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_time_scales_with_the_limits(make_helix, make_gaze, limits, factor):
    """Speed × c, acceleration × c², jerk × c³: the same law, c times as fast."""
    path, gaze = make_helix(), make_gaze()
    powers = (1, 1, 1, 2, 3, 1, 2)
    scaled = Limits(
        *(bound * factor**n for bound, n in zip(dataclasses.astuple(limits), powers, strict=True))
    )
    ratio = fastest_law(path, gaze, limits).duration_s / fastest_law(path, gaze, scaled).duration_s
    assert ratio == pytest.approx(factor, rel=2e-3)


def test_time_does_not_depend_on_how_the_curve_is_turned_or_parameterised(make_helix, make_gaze, limits):
    path, gaze = make_helix(), make_gaze()

    class Faster:
        """The same curve at three times the phase, turned a right angle about the vertical."""

        u_end_rad = path.u_end_rad / 3

        def __call__(self, u_rad, order=0):
            x, y, z = np.moveaxis(path(3 * np.asarray(u_rad), order), -1, 0)
            return 3**order * np.stack([-y, x, z], axis=-1)

        def jet(self, u_rad):
            return np.stack([self(u_rad, order) for order in range(4)])

    class FasterGaze:
        def jet(self, u_rad):
            return np.stack([3**order * gaze(3 * np.asarray(u_rad), order) for order in range(3)])

    expected = fastest_law(path, gaze, limits).duration_s
    assert fastest_law(Faster(), FasterGaze(), limits).duration_s == pytest.approx(expected, rel=1e-6)


def test_more_of_anything_is_never_much_slower(make_helix, make_gaze, limits):
    path, gaze = make_helix(turns=2), make_gaze()
    duration_s = fastest_law(path, gaze, limits).duration_s
    for field in dataclasses.fields(limits):
        wider = dataclasses.replace(limits, **{field.name: 2 * getattr(limits, field.name)})
        assert fastest_law(path, gaze, wider).duration_s < 1.005 * duration_s, field.name


def test_without_a_jerk_limit_to_speak_of_it_is_the_trapezium(limits):
    abrupt = dataclasses.replace(limits, jerk_mps3=1e6)
    law = fastest_law(LinePath([0, 0, 9], [300, 0, 9]), AHEAD, abrupt)
    assert law.duration_s == pytest.approx(300 / 5.0 + 5.0 / 2.0, abs=0.15)
    assert len(law.phase_rad) < 20_000


def test_a_curve_that_stands_still_is_refused(limits):
    with pytest.raises(ValueError, match="stands still at u = 0"):
        fastest_law(LinePath([1, 2, 3], [1, 2, 3]), AHEAD, limits)
