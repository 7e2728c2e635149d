import numpy as np
import pytest

from sitl.estimator import error_state as m
from sitl.estimator.filters import KernelFilter
from sitl.estimator.stock import StockFilter
from sitl.estimator.strapdown import new_nav

RNG = np.random.default_rng(11)


def twins():
    nav = new_nav()
    nav["mean_q"] = 0.5
    nav["mean_force"], nav["mean_rate"] = (0.3, -0.2, -9.7), (0.1, 0.2, -0.3)
    noise = m.process_noise(7e-3, 2e-4, 1e-4, 1e-5, 0.01)
    pair = KernelFilter(nav, noise), StockFilter(nav, noise)
    A = 0.1 * RNG.standard_normal((m.STATES, m.STATES))
    for one in pair:
        one.P = A @ A.T + 0.01 * np.eye(m.STATES)
    return pair


@pytest.mark.parametrize("size", [1, 3, 6])
def test_the_kernels_equal_filterpys_own_arithmetic(size):
    mine, stock = twins()
    H, z = RNG.standard_normal((size, m.STATES)), RNG.standard_normal(size)
    R = np.diag(0.1 + RNG.random(size))
    for _ in range(5):
        for one in (mine, stock):
            one.predict()
            one.update(z, lambda _: H, lambda x: H @ x + 0.1, R=R)
        for name in ("x", "P", "y", "K", "S"):
            np.testing.assert_allclose(
                getattr(mine, name), getattr(stock, name), rtol=1e-9, atol=1e-12, err_msg=name
            )
        assert mine.mahalanobis == pytest.approx(stock.mahalanobis, rel=1e-9)
        mine.x[:] = stock.x[:] = 0.0  # as `inject` leaves it


def test_the_kernels_covariance_stays_exactly_symmetric_and_positive():
    mine, _ = twins()
    H, R = np.eye(6, m.STATES), 1e-4 * np.eye(6)
    for _ in range(2000):
        mine.predict()
        mine.update(np.zeros(6), lambda _: H, lambda _: np.zeros(6), R=R)
    np.testing.assert_array_equal(mine.P, mine.P.T)
    assert np.linalg.eigvalsh(mine.P).min() > 0.0


@pytest.mark.parametrize("which", [0, 1])
def test_an_update_is_refused_where_its_worst_component_lies_beyond_the_gate(which):
    one = twins()[which]
    H, R, r = RNG.standard_normal((3, m.STATES)), 0.2 * np.eye(3), np.array([0.1, -3.0, 0.2])
    gate = np.sqrt((r**2 / np.diag(H @ one.P @ H.T + R)).max())
    before = one.P.copy()
    assert not one.fuse(r, np.zeros(3), H, R, gate * (1.0 - 1e-9))
    np.testing.assert_array_equal(one.P, before)
    assert one.fuse(r, np.zeros(3), H, R, gate * (1.0 + 1e-9))
    assert np.trace(one.P) < np.trace(before)
