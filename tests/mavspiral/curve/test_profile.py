import numpy as np
import pytest

from mavspiral.curve.profile import Profile


@pytest.fixture
def wavy():
    return Profile(np.random.default_rng(2).normal(size=40), 0.3)


def test_weights_are_convex_and_a_constant_stays_one():
    assert Profile(np.full(9, 2.5), 0.7)(np.linspace(0, 2.8, 50)) == pytest.approx(2.5)
    lone = Profile(np.eye(12)[6], 1.0)(np.linspace(0.0, 7.0, 701))
    assert lone.min() >= 0.0
    assert np.flatnonzero(lone > 1e-9)[[0, -1]] / 100 == pytest.approx([1.05, 6.95])


def test_a_straight_line_is_kept_with_its_slope():
    u = np.linspace(0.0, 6.0, 61)
    line = Profile.along(u, 2.0 * u, 0.25, 24)
    inside = np.linspace(1.0, 5.0, 99)
    assert line(inside) == pytest.approx(2.0 * inside)
    assert line(inside, 1) == pytest.approx(2.0)
    assert np.abs(line(inside, 2)).max() < 1e-9


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_are_derivatives_also_across_knots(order, wavy):
    u = np.linspace(0.01, 10.4, 4001)
    slope = (wavy(u + 1e-5, order - 1) - wavy(u - 1e-5, order - 1)) / 2e-5
    np.testing.assert_allclose(slope, wavy(u, order), atol=1e-4 * np.abs(wavy(u, order)).max())
    assert (wavy.jet(u) == np.stack([wavy(u, k) for k in range(3)])).all()


def test_a_profile_above_is_nowhere_below():
    rng = np.random.default_rng(5)
    u = np.linspace(0.0, 20.0, 400)
    values = np.where(rng.uniform(size=400) < 0.05, rng.uniform(1.0, 9.0, 400), 0.0)
    above = Profile.above(u, values, 0.5, 40)
    assert (above(u) >= values - 1e-12).all()
    assert above(u).max() <= values.max() + 1e-12


def test_wrong_orders_and_too_few_knots_are_refused(wavy):
    with pytest.raises(ValueError, match="order is 4"):
        wavy(0.0, 4)
    with pytest.raises(ValueError, match="wanted 6 or more"):
        Profile(np.zeros(5), 1.0)
