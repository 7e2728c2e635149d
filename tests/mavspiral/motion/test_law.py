import numpy as np
import pytest

from mavspiral.motion.law import TimeLaw


def cubic_law(knots=9, step_s=0.5):
    """A law by integration of ü, linear between knots: the slow way to what `TimeLaw` stores."""
    acceleration = np.array([0, 1, 2, 1, 0, -1, -2, -1, 0], dtype=float)[:knots]
    fine = 10_000
    t = np.linspace(0, step_s * (knots - 1), fine * (knots - 1) + 1)
    a = np.interp(t, step_s * np.arange(knots), acceleration)
    v = np.concatenate([[0], np.cumsum((a[1:] + a[:-1]) / 2 * t[1])])
    u = np.concatenate([[0], np.cumsum((v[1:] + v[:-1]) / 2 * t[1])])
    v[-1] = 0.0
    return TimeLaw(step_s, u[::fine], v[::fine], acceleration), t, (u, v, a)


def test_between_knots_it_is_the_integral_of_a_linear_acceleration():
    law, t, truth = cubic_law()
    for order, expected in enumerate(truth):
        np.testing.assert_allclose(law(t, order), expected, atol=1e-7)
    np.testing.assert_array_equal(law([0.1, 0.9, 1.2], 3), [2.0, 2.0, -2.0])


def test_time_is_clipped_to_the_ends():
    law, _, _ = cubic_law()
    assert law.duration_s == 4.0
    assert law(-1.0) == law(0.0) == 0.0
    assert law(99.0) == law(4.0) == pytest.approx(law.phase_rad[-1], rel=1e-9)
    assert law(99.0, 1) == pytest.approx(0.0, abs=1e-7)


def test_stretched_it_passes_the_same_phases_later():
    law, t, _ = cubic_law()
    slow = law.stretched(1.25)
    assert slow.duration_s == 1.25 * law.duration_s
    for order in range(4):
        np.testing.assert_allclose(
            slow(1.25 * t[::999], order) * 1.25**order, law(t[::999], order), atol=1e-12
        )


@pytest.mark.parametrize(
    ("step_s", "rate", "message"),
    [
        (0.0, [0, 1, 0], "apart"),
        (0.1, [0, 1, 1], "rest"),
        (0.1, [0, np.nan, 0], "finite"),
        (0.1, [0, 0], "shape"),
    ],
)
def test_what_is_no_law_is_refused(step_s, rate, message):
    with pytest.raises(ValueError, match=message):
        TimeLaw(step_s, [0.0, 1.0, 2.0], rate, [0.0, 0.0, 0.0])


def test_it_cannot_be_written_to():
    law, _, _ = cubic_law()
    with pytest.raises(ValueError, match="read-only"):
        law.phase_rad[0] = 1.0
