from itertools import pairwise

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze


def leg(name, path, gaze, limits, pitch=0.0):
    return Leg(name, path, gaze, fastest_law(path, gaze, limits), TurnGaze(pitch, pitch))


@pytest.fixture
def flight(make_helix, make_gaze, limits):
    """Up, over, and once round; the yaw of the last leg is whole turns away from the one before."""
    helix, inward = make_helix(turns=1), make_gaze()
    entry = helix(0.0)
    up = LinePath([0, 0, 0], [0, 0, entry[2] + 5.0])
    over = LinePath(up.end_enu_m, entry)
    yaw = float(inward(0.0))
    return Trajectory(
        (
            leg("approach-1", up, TurnGaze(0.4 - 4 * np.pi, 0.4), limits),
            leg("approach-2", over, TurnGaze(0.4 - 4 * np.pi, yaw), limits),
            leg("inspection", helix, inward, limits, pitch=-0.2),
        )
    )


def test_derivatives_are_those_of_the_position_and_yaw(flight):
    t, h = np.linspace(0.1, flight.duration_s - 0.1, 700), 1e-4
    before, now, after = flight(t - h), flight(t), flight(t + h)
    chain = ["position_enu_m", "velocity_enu_mps", "acceleration_enu_mps2"]
    turning = ["yaw_enu_rad", "yaw_rate_enu_radps"]
    pairs = [
        *pairwise(chain),
        *zip(turning, [turning[1], "yaw_acceleration_enu_radps2"], strict=True),
    ]
    for low, high in pairs:
        slope = (getattr(after, low) - getattr(before, low)) / (2 * h)
        np.testing.assert_allclose(getattr(now, high), slope, atol=2e-3)
    slope = (after.acceleration_enu_mps2 - before.acceleration_enu_mps2) / (2 * h)
    off = np.abs(now.jerk_enu_mps3 - slope).max(axis=1)
    assert np.mean(off > 1e-2) < 0.03  # but where the jerk itself steps within ±h


def test_it_rests_at_every_join_and_goes_on_without_a_jump(flight):
    for name in ("approach-1", "approach-2", "inspection"):
        ends = flight(np.array(flight.span_s(name)))
        np.testing.assert_allclose(ends.velocity_enu_mps, 0.0, atol=1e-9)
        np.testing.assert_allclose(ends.acceleration_enu_mps2, 0.0, atol=1e-9)
        np.testing.assert_allclose(ends.yaw_rate_enu_radps, 0.0, atol=1e-9)
    dense = flight.sampled(0.01)
    assert np.abs(np.diff(dense.yaw_enu_rad)).max() < 0.01
    assert np.linalg.norm(np.diff(dense.position_enu_m, axis=0), axis=1).max() < 0.0501


def test_legs_follow_each_other_in_time(flight):
    spans = [flight.span_s(name) for name in ("approach-1", "approach-2", "inspection")]
    assert spans[0][0] == 0.0
    assert spans[-1][1] == flight.duration_s
    assert all(before[1] == after[0] for before, after in pairwise(spans))
    middle = sum(spans[2]) / 2
    assert flight(middle).gimbal_pitch_rad == -0.2
    with pytest.raises(KeyError, match="no leg is called 'roof'"):
        flight.span_s("roof")


def test_it_takes_times_of_any_shape_and_clips_them(flight):
    t = np.linspace(-5.0, flight.duration_s + 5.0, 24)
    grid = flight(t.reshape(2, 3, 4))
    assert grid.position_enu_m.shape == (2, 3, 4, 3)
    np.testing.assert_array_equal(grid.position_enu_m.reshape(24, 3), flight(t).position_enu_m)
    one = flight(1.0)
    assert one.position_enu_m.shape == (3,)
    assert one.yaw_enu_rad.shape == ()
    np.testing.assert_array_equal(flight(-5.0).position_enu_m, flight.legs[0].path(0.0))
    np.testing.assert_allclose(flight(1e9).position_enu_m, flight.legs[-1].path(2 * np.pi), atol=1e-9)


def test_sampled_is_the_motion_on_a_grid_with_its_very_end(flight):
    table = flight.sampled(0.02)
    np.testing.assert_allclose(table.t_s[:-1], 0.02 * np.arange(len(table.t_s) - 1))
    assert table.t_s[-1] == flight.duration_s
    assert 0 < table.t_s[-1] - table.t_s[-2] <= 0.02 * (1 + 1e-9)
    np.testing.assert_array_equal(table.velocity_enu_mps[77], flight(table.t_s[77]).velocity_enu_mps)


def test_legs_that_do_not_join_are_refused(limits):
    east, gaze = LinePath([0, 0, 0], [9, 0, 0]), TurnGaze(0.0, 1.0)
    first = leg("approach-1", east, gaze, limits)
    beside = leg("inspection", LinePath([9, 0.5, 0], [0, 0, 0]), TurnGaze(1.0, 0.0), limits)
    askew = leg("inspection", LinePath([9, 0, 0], [0, 0, 0]), TurnGaze(1.3, 0.0), limits)
    with pytest.raises(ValueError, match=r"'inspection' begins 0\.5 m from where 'approach-1' ends"):
        Trajectory((first, beside))
    with pytest.raises(ValueError, match=r"'inspection' begins .*0\.3 rad of yaw"):
        Trajectory((first, askew))
    with pytest.raises(ValueError, match="at least one leg"):
        Trajectory(())


def test_legs_of_one_kind_are_told_together_and_apart(make_helix, make_gaze, limits):
    helix, inward = make_helix(turns=1), make_gaze()
    end, yaw = helix(helix.u_end_rad), float(inward(helix.u_end_rad))
    away = LinePath(end, [90, 0, 30])
    back = LinePath([90, 0, 30], [60, 0, 30])
    tilting = TurnGaze(-0.2, -0.8)
    flight = Trajectory(
        (
            leg("inspection-tower-1", helix, inward, limits, pitch=-0.2),
            Leg(
                "transit-1",
                away,
                TurnGaze(yaw, 1.0),
                fastest_law(away, TurnGaze(yaw, 1.0), limits),
                tilting,
            ),
            leg("inspection-tower-10", back, TurnGaze(1.0, 1.0), limits, pitch=-0.8),
        )
    )
    first, second = flight.spans_s("inspection")
    assert first == flight.span_s("inspection-tower-1") and second == flight.span_s("inspection-tower-10")
    assert flight.span_s("inspection") == (first[0], second[1]) == (0.0, flight.duration_s)
    with pytest.raises(KeyError):
        flight.spans_s("inspect")
    t_s = np.array([first[0], first[1], 0.5 * (first[1] + second[0]), second[0], second[1]])
    np.testing.assert_array_equal(flight.on("inspection", t_s), [True, True, False, True, True])
    pitch = flight(t_s).gimbal_pitch_rad
    assert pitch[0] == -0.2 and pitch[-1] == -0.8 and -0.75 < pitch[2] < -0.25
