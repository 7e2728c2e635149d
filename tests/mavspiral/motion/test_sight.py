import numpy as np
import pytest

from mavspiral.motion.sight import Sight
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze


def looked_at(states, distance_m):
    """Where the camera's axis meets what is so far away, by another road: the point itself."""
    yaw, pitch = states.yaw_enu_rad, states.gimbal_pitch_rad
    axis = np.stack([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)], axis=1)
    return states.position_enu_m + distance_m * axis, axis


def across_mps(states, distance_m):
    """How fast that point moves across the axis, by finite differences."""
    point, axis = looked_at(states, distance_m)
    velocity = np.gradient(point, states.t_s, axis=0)
    return np.linalg.norm(velocity - (velocity * axis).sum(axis=1, keepdims=True) * axis, axis=1)[2:-2]


@pytest.mark.parametrize("pitch", [TurnGaze(0.0, 0.0), TurnGaze(-0.4, -1.1, 6 * np.pi)])
def test_what_passes_is_how_the_point_looked_at_moves(make_helix, make_gaze, limits, pitch):
    path, gaze = make_helix(turns=3), make_gaze(sway_rad=0.3)
    leg = Leg("inspection", path, gaze, fastest_law(path, gaze, limits), pitch)
    states = Trajectory((leg,)).sampled(0.005)
    yaw = np.stack([states.yaw_enu_rad, states.yaw_rate_enu_radps])
    tilt = np.stack([states.gimbal_pitch_rad, np.gradient(states.gimbal_pitch_rad, states.t_s)])
    told = Sight(9.0, 1.0).passing(states.velocity_enu_mps, yaw, tilt)[2:-2]
    np.testing.assert_allclose(told, across_mps(states, 9.0), atol=2e-3 * told.max())


def test_a_law_with_a_sight_keeps_its_pictures_sharp_and_is_no_slower_than_that_takes(
    make_helix, make_gaze, limits
):
    path, gaze = make_helix(turns=3), make_gaze(sway_rad=0.3)
    sight = Sight(9.0, 3.0)
    plain, sharp = fastest_law(path, gaze, limits), fastest_law(path, gaze, limits, sight=sight)

    def fastest_mps(law):
        states = Trajectory((Leg("inspection", path, gaze, law),)).sampled(0.005)
        return across_mps(states, 9.0).max()

    assert fastest_mps(plain) > 1.3 * sight.speed_mps
    assert 0.97 * sight.speed_mps < fastest_mps(sharp) <= sight.speed_mps
    assert sharp.duration_s > plain.duration_s
    easy = fastest_law(path, gaze, limits, sight=Sight(9.0, 100.0))
    assert easy.duration_s == pytest.approx(plain.duration_s, rel=1e-12)
