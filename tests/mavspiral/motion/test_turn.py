import numpy as np
import pytest

from mavspiral.motion.turn import TurnGaze


@pytest.mark.parametrize(
    ("start", "end", "turn"),
    [(0.0, 1.0, 1.0), (3.0, -3.0, 2 * np.pi - 6.0), (-3.0, 3.0, 6.0 - 2 * np.pi), (7.0, 7.0, 0.0)],
)
def test_it_turns_the_short_way_and_rests_at_both_ends(start, end, turn):
    gaze = TurnGaze(start, end, u_end_rad=2.0)
    assert gaze(0.0) == start
    assert gaze(2.0) == pytest.approx(start + turn)
    for order in (1, 2):
        np.testing.assert_allclose(gaze(np.array([0.0, 2.0]), order), 0.0, atol=1e-12)


def test_derivatives_are_those_of_the_yaw():
    gaze = TurnGaze(0.3, 2.0, u_end_rad=1.7)
    u, h = np.linspace(0.1, 1.6, 50), 1e-5
    for order in (0, 1):
        slope = (gaze(u + h, order) - gaze(u - h, order)) / (2 * h)
        np.testing.assert_allclose(gaze(u, order + 1), slope, rtol=1e-6, atol=1e-8)
