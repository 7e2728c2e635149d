"""EKF2's output observer: the output comes after the filter, and where nothing is uncertain it is the filter."""

import numpy as np
import pytest


def test_without_noise_it_changes_hardly_anything(vehicle, demand):
    """The filter agrees with its own past, so there is nothing to pull."""
    twins = [vehicle(noise=False, output_observer=observed) for observed in (False, True)]
    for one in twins:
        one.advance(3_000_000, demand(armed=False))
        one.advance(12_000_000, demand((4.0, 0.0, -6.0), yaw=0.0))
    made_anew, observed = (one.estimate.position_ned_m for one in twins)
    np.testing.assert_allclose(observed, made_anew, atol=0.01)


def test_a_jump_of_the_filter_arrives_by_and_by(vehicle, demand):
    """After the delay, at 1 m with the time constant of a quarter of a second and a tenth of an integral."""
    one = vehicle(noise=False, output_observer=True)
    one.advance(5_000_000, demand(armed=False))
    nav = one._ekf.nav
    before = float(one.estimate.position_ned_m[0])
    nav["pose"][0, 0] += 1.0
    shares = []
    for _ in range(25):
        one.advance(one.time_us + 10_000, demand(armed=False))
        nav["pose"][0, 0] = before + 1.0  # whatever the next fixes say
        shares.append(float(one.estimate.position_ned_m[0]) - before)
    assert shares[0] == pytest.approx(0.04, abs=0.01)
    assert 0.5 < shares[-1] < 0.8
    assert np.all(np.diff(shares) > 0.0)


def test_its_state_is_in_the_snapshot(vehicle, demand):
    one = vehicle(output_observer=True)
    one.advance(6_000_000, demand((0.0, 0.0, -3.0), yaw=0.0))
    state = one.snapshot()
    one.advance(9_000_000, demand((5.0, 0.0, -3.0), yaw=0.0))
    flown = one.truth.position_ned_m
    one.restore(state)
    one.advance(9_000_000, demand((5.0, 0.0, -3.0), yaw=0.0))
    assert one.truth.position_ned_m.tobytes() == flown.tobytes()


def test_single_updates_and_the_one_kernel_make_the_same_of_it(vehicle, demand):
    twins = [vehicle(output_observer=True, stock_filter=stock) for stock in (False, True)]
    for one in twins:
        one.advance(6_000_000, demand((2.0, 1.0, -3.0), yaw=0.0))
    ours, stock = (one.truth.position_ned_m for one in twins)
    np.testing.assert_allclose(stock, ours, atol=1e-6)
