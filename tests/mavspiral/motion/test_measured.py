from dataclasses import replace

import numpy as np
import pytest

from mavspiral.curve.gaze import YawSpline
from mavspiral.curve.line import LinePath
from mavspiral.curve.meander import MeanderPath
from mavspiral.motion.measured import slower
from mavspiral.motion.sight import Sight
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import LEVEL, TurnGaze


def factor(path, gaze, law, limits, dt_s):
    """The factor of time, from samples that are close together and nothing else."""
    state = Trajectory((Leg("leg", path, gaze, law),)).sampled(dt_s)
    velocity, acceleration, jerk = (
        np.linalg.norm(vectors, axis=1).max()
        for vectors in (state.velocity_enu_mps, state.acceleration_enu_mps2, state.jerk_enu_mps3)
    )
    climb = state.velocity_enu_mps[:, 2]
    return max(
        velocity / limits.speed_mps,
        climb.max() / limits.climb_mps,
        -climb.min() / limits.descent_mps,
        np.abs(state.yaw_rate_enu_radps).max() / limits.yaw_rate_radps,
        (acceleration / limits.acceleration_mps2) ** (1 / 2),
        (np.abs(state.yaw_acceleration_enu_radps2).max() / limits.yaw_acceleration_radps2) ** (1 / 2),
        (jerk / limits.jerk_mps3) ** (1 / 3),
    )


def zigzag(seed):
    """A way whose third derivative has a kink at every place, and a gaze whose second has."""
    rng = np.random.default_rng(seed)
    places = np.cumsum(np.column_stack([np.full(60, 0.8), rng.normal(0.0, 0.25, (60, 2))]), axis=0)
    path = MeanderPath(places)
    return path, YawSpline(np.cumsum(rng.normal(0.0, 0.05, 60)), 1.0)


@pytest.mark.parametrize("seed", range(6))
def test_between_the_samples_nothing_is_missed_where_splines_have_their_kinks(seed, limits):
    path, gaze = zigzag(seed)
    for stretch in (0.8, 1.0, 1.7):
        law = fastest_law(path, gaze, limits).stretched(stretch)
        told = slower(path, gaze, law, limits, LEVEL, None)
        dense = factor(path, gaze, law, limits, 1e-5)
        assert dense <= told * (1 + 2e-5)  # the law's own margin
        assert told <= dense * (1 + 1e-5)  # what the samples here miss


@pytest.mark.parametrize("speed_mps", [1.2, 1.4])
def test_a_speed_near_its_limit_hides_no_jerk(speed_mps, limits):
    slow = replace(limits, speed_mps=speed_mps)
    for seed in range(6):
        path, gaze = zigzag(seed)
        law = fastest_law(path, gaze, slow)
        told = slower(path, gaze, law, slow, LEVEL, None)
        assert factor(path, gaze, law, slow, 2e-4) <= told * (1 + 2e-5)


@pytest.mark.parametrize("seed", range(6))
def test_a_law_keeps_its_limits_where_splines_have_their_kinks_and_uses_them(seed, limits):
    path, gaze = zigzag(seed)
    worst = factor(path, gaze, fastest_law(path, gaze, limits), limits, 2e-4)
    assert 0.9995 < worst <= 1.0


def test_a_gimbal_that_tilts_on_a_short_way_takes_its_time(limits):
    path, pitch = LinePath([0, 0, 9], [2, 0, 9]), TurnGaze(0.0, -1.5)
    law = fastest_law(path, LEVEL, limits, pitch=pitch)
    t = np.linspace(0.0, law.duration_s, 20_001)
    rate = np.abs(np.gradient(pitch(law(t)), t))
    assert 0.999 < rate.max() / np.radians(30.0) <= 1.0
    assert law.duration_s > 1.2 * fastest_law(path, LEVEL, limits).duration_s


def test_sharp_pictures_are_measured_too(limits):
    path, gaze = zigzag(1)
    sight = Sight(8.0, 0.4)
    law = fastest_law(path, gaze, limits, sight=sight)
    state = Trajectory((Leg("leg", path, gaze, law),)).sampled(0.001)
    yaw = np.stack([state.yaw_enu_rad, state.yaw_rate_enu_radps])
    passing = sight.passing(state.velocity_enu_mps, yaw, np.zeros_like(yaw))
    assert 0.98 < passing.max() / sight.speed_mps <= 1.0
