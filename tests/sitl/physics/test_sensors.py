import numpy as np
import pytest

from sitl.airframe import RECEIVERS
from sitl.geo import ned_of_geodetic
from sitl.physics.sensors import measure_baro, measure_fix, measure_imu, measure_mag, new_sensed
from sitl.rotation import from_euler
from sitl.signals import GeoPoint

HOME = GeoPoint(19.4, -99.1, 2240.0)
FIELD = (0.27, 0.02, 0.3)


def sensed(x500, noise=True, grade="standard", seed=1):
    normals = np.random.default_rng(seed).standard_normal(10)
    return new_sensed(x500.senses, RECEIVERS[grade], HOME, FIELD, normals, noise).view(np.recarray)


def test_without_noise_the_senses_tell_the_truth(x500):
    senses, rng = sensed(x500, noise=False), np.random.default_rng(2)
    s = senses[0]
    force, rate = np.array([1.0, 2.0, -9.0]), np.array([0.1, -0.2, 0.3])
    measure_imu(s, 1, force, rate, rng.standard_normal(12))
    np.testing.assert_array_equal(senses["imu"][0, 1], [*force, *rate])
    measure_baro(s, -12.0, rng.standard_normal(2))
    assert senses["baro_alt_m"][0] == HOME.alt_amsl_m + 12.0
    measure_mag(s, np.array(from_euler(0.0, 0.0, np.pi / 2)), rng.standard_normal(3))
    np.testing.assert_allclose(senses["mag_frd_gauss"][0], (FIELD[1], -FIELD[0], FIELD[2]), atol=1e-12)
    place, velocity = np.array([3.0, -4.0, -5.0]), np.array([1.0, 0.0, -1.0])
    measure_fix(s, 19, place, velocity, rng.standard_normal(9), True)
    fix = senses["fix"][0, 19 % 16]
    home = (HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m)
    np.testing.assert_allclose(ned_of_geodetic(home, tuple(fix[:3])), place, atol=1e-6)
    np.testing.assert_array_equal(fix[3:], velocity)


def test_imu_noise_has_its_density_and_the_bias_walks(x500):
    senses, rng = sensed(x500), np.random.default_rng(3)
    samples, biases = [], []
    for _ in range(20_000):
        biases.append(senses["imu_bias"][0].copy())
        measure_imu(senses[0], 0, np.zeros(3), np.zeros(3), rng.standard_normal(12))
        samples.append(senses["imu"][0, 0] - biases[-1])
    spread = np.std(samples, axis=0)
    np.testing.assert_allclose(spread[:3], x500.senses.accel_noise_mps2_rthz * 200**0.5, rtol=0.03)
    np.testing.assert_allclose(spread[3:], x500.senses.gyro_noise_radps_rthz * 200**0.5, rtol=0.03)
    steps = np.diff(biases, axis=0).std(axis=0)
    np.testing.assert_allclose(steps[:3], x500.senses.accel_walk_mps3_rthz * 0.005**0.5, rtol=0.03)


@pytest.mark.parametrize("grade", ["rtk", "standard"])
def test_fix_errors_are_what_the_receiver_reports_and_wander(x500, grade):
    senses, rng = sensed(x500, grade=grade), np.random.default_rng(4)
    home, errors = (HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m), []
    for _ in range(60_000):
        measure_fix(senses[0], 0, np.zeros(3), np.zeros(3), rng.standard_normal(9), True)
        errors.append(ned_of_geodetic(home, tuple(senses["fix"][0, 0, :3])))
    errors = np.array(errors)
    h, v, _ = RECEIVERS[grade].sigma
    np.testing.assert_allclose(np.sqrt((errors**2).mean(axis=0)), (h, h, v), rtol=0.25)
    lag = 20  # 2 s later the white part is new, the wander hardly changed
    kept = (errors[:-lag] * errors[lag:]).mean(axis=0)
    wander = RECEIVERS[grade].wander_h_m
    np.testing.assert_allclose(kept[:2], wander**2, rtol=0.5)
