import numpy as np
import pytest

from sitl.estimator import error_state as m
from sitl.estimator.strapdown import new_nav, propagate
from sitl.rotation import exponential, multiply

RNG = np.random.default_rng(8)
FIELD = np.array([0.27, 0.02, 0.3])


def random_nominal():
    q = RNG.standard_normal(4)
    return np.concatenate([RNG.standard_normal(6), q / np.linalg.norm(q), 0.01 * RNG.standard_normal(6)])


def plus(nominal, error):
    q = multiply(nominal[6:10], exponential(tuple(error[6:9])))
    return np.concatenate([nominal[:6] + error[:6], q, nominal[10:] + error[9:]])


def minus(a, b):
    dq = multiply((b[6], -b[7], -b[8], -b[9]), a[6:10])
    return np.concatenate([a[:6] - b[:6], 2.0 * np.array(dq[1:]) * np.sign(dq[0]), a[10:] - b[10:]])


def moved(nominal, sample, dt):
    p, v, q = nominal[0:3].copy(), nominal[3:6].copy(), nominal[6:10].copy()
    force, rate = sample[:3] - nominal[13:16], sample[3:] - nominal[10:13]
    propagate(p, v, q, tuple(force), tuple(rate), dt)
    return np.concatenate([p, v, q, nominal[10:]])


def numeric(function, nominal, difference, size):
    columns = []
    for i in range(m.STATES):
        step = np.zeros(m.STATES)
        step[i] = 1e-5
        columns.append(difference(function(plus(nominal, step)), function(plus(nominal, -step))) / 2e-5)
    return np.array(columns).T.reshape(size, m.STATES)


@pytest.mark.parametrize("seed", range(5))
def test_the_transition_is_the_propagations_jacobian_to_first_order(seed):
    """Its error falls with dt², a hundredfold for a tenth of the interval."""
    nominal, sample = random_nominal(), RNG.standard_normal(6) * np.array([5.0, 5.0, 5.0, 2.0, 2.0, 2.0])
    error = []
    for dt in (0.01, 0.001):
        half = moved(nominal, sample, dt / 2.0)
        F = m.transition(half[6:10], sample[:3] - nominal[13:], sample[3:] - nominal[10:13], dt)
        error.append(np.abs(F - numeric(lambda n: moved(n, sample, dt), nominal, minus, m.STATES)).max())  # noqa: B023
    assert error[0] < 5e-3
    assert error[1] < error[0] / 50.0


@pytest.mark.parametrize("seed", range(5))
def test_the_magnetometers_jacobian_equals_finite_differences(seed):
    nominal = random_nominal()
    expected = numeric(lambda n: m.mag_expected(n[6:10], FIELD), nominal, np.subtract, 3)
    np.testing.assert_allclose(m.mag_jacobian(nominal[6:10], FIELD), expected, atol=1e-9)


def random_nav():
    nav = new_nav()
    nav["mean_q"] = random_nominal()[6:10]
    nav["mean_force"], nav["mean_rate"] = RNG.standard_normal(3) * 9.0, RNG.standard_normal(3)
    return nav


def test_the_structured_prediction_is_f_p_ft_plus_q():
    A = RNG.standard_normal((m.STATES, m.STATES))
    P, nav, noise = A @ A.T, random_nav(), np.abs(RNG.standard_normal(m.STATES))
    F = m.transition(nav["mean_q"][0], nav["mean_force"][0], nav["mean_rate"][0], 0.01)
    expected = F @ P @ F.T + np.diag(noise)
    m.predict_covariance(P, np.zeros((9, m.STATES)), nav, noise, 0.01)
    np.testing.assert_allclose(P, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(P, P.T)


def test_injecting_an_error_moves_the_state_by_it_and_keeps_p_symmetric():
    nav, error = random_nav(), 0.01 * RNG.standard_normal(m.STATES)
    before = np.concatenate([nav["pose"][0], nav["q_ned_frd"][0], nav["gyro_bias"][0], nav["accel_bias"][0]])
    P = np.diag(np.arange(1.0, 16.0))
    m.inject(nav, error, P)
    after = np.concatenate([nav["pose"][0], nav["q_ned_frd"][0], nav["gyro_bias"][0], nav["accel_bias"][0]])
    np.testing.assert_allclose(minus(after, before), error, atol=1e-7)
    np.testing.assert_allclose(P, P.T, atol=1e-15)


def test_strapdown_follows_a_steady_turn_exactly_enough():
    """A coordinated circle, 10 m at 3 m/s, for ten seconds: millimetres off."""
    w, dt = 0.3, 0.005
    p, v, q = np.array([10.0, 0.0, 0.0]), np.array([0.0, 3.0, 0.0]), np.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(2000):
        mean = np.sin(w * dt / 2.0) / (w * dt / 2.0)  # of the centripetal force over a sample, in the body
        propagate(p, v, q, (-0.9 * mean, 0.0, -9.80665), (0.0, 0.0, w), dt)
    np.testing.assert_allclose(p, (10.0 * np.cos(3.0), 10.0 * np.sin(3.0), 0.0), atol=5e-3)
