"""The estimator errs as it says; tests/bench/bench_consistency.py shows it over 100 seeds."""

import numpy as np
import pytest
from consistency import DISARMED, DOF, STATES, as_modelled, bounds, demand, error, fly

from sitl.faults import parse_fault
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.vehicle import Vehicle, VehicleConfig

SEEDS = 16


@pytest.fixture(scope="module")
def modelled(x500):
    return [fly(seed=seed, seconds=20.0, **as_modelled(x500)) for seed in range(SEEDS)]


def test_with_senses_as_modelled_mean_nees_is_within_its_95_percent_bounds(modelled):
    low, high = bounds(STATES, SEEDS)
    assert low < np.mean([flown.nees for flown in modelled]) < high


@pytest.mark.parametrize("sense", DOF)
def test_with_senses_as_modelled_mean_nis_is_within_its_95_percent_bounds(modelled, sense):
    looks = np.array([flown.nis[sense] for flown in modelled])
    low, high = bounds(DOF[sense], looks.size)
    assert low < looks.mean() < high


@pytest.mark.parametrize("gps", ["rtk", "standard"])
def test_with_the_full_senses_mean_nees_is_near_its_degrees_of_freedom(x500, gps):
    nees = [fly(x500, seed, seconds=20.0, gps=gps).nees for seed in range(8)]
    assert 0.7 < np.mean(nees) < 1.3


def test_the_barometers_offset_is_the_mean_over_the_first_fixes(x500):
    """After ten seconds on the ground it errs by far less than one sample does."""
    config = as_modelled(x500)
    errors = []
    for seed in range(12):
        home = GeoPoint(19.4332, -99.1412, 2240.0)
        one = Vehicle(VehicleConfig(config["airframe"], Params(), home, seed=seed, gps=config["gps"]))
        one.advance(10_000_000, DISARMED)
        errors.append(float(one._ekf.book["baro_bias_m"][0]))
    assert np.std(errors) < 0.3 * x500.senses.baro_noise_m


def test_thirty_seconds_without_fixes_are_drifted_through_as_told_and_then_recovered(x500):
    """NEES near its degrees of freedom all the while, height's own too; afterwards as exact as before."""
    looks = {}
    for seed in range(16):
        loss = parse_fault("gps_loss@30s+30s")
        home = GeoPoint(19.4332, -99.1412, 2240.0)
        one = Vehicle(VehicleConfig(x500, Params(x500.params), home, seed=seed, faults=(loss,)))
        one.advance(3_000_000, DISARMED)
        for at_s in (40, 50, 60, 63):
            one.advance(at_s * 1_000_000, demand((0.0, 0.0, -10.0)))
            looks.setdefault(at_s, []).append(error(one))
    for at_s, seen in looks.items():
        nees = np.mean([e @ np.linalg.solve(P, e) for e, P in seen]) / STATES
        assert 0.7 < nees < 1.3, at_s
        low, high = bounds(1, len(seen))
        assert low < np.mean([e[2] ** 2 / P[2, 2] for e, P in seen]) < high, at_s
    assert max(np.hypot(*e[:2]) for e, _ in looks[60]) > 1.0
    assert max(np.hypot(*e[:2]) for e, _ in looks[63]) < 0.1
