import numpy as np
import pytest

from sitl.airframe import RECEIVERS
from sitl.geo import ned_of_geodetic
from sitl.physics.sensors import (
    BOOT_NORMALS,
    STUCK_BITS,
    measure_baro,
    measure_fix,
    measure_imu,
    measure_mag,
    new_sensed,
)
from sitl.rotation import from_euler
from sitl.signals import GeoPoint

HOME = GeoPoint(19.4, -99.1, 2240.0)
FIELD = (0.27, 0.02, 0.3)


def sensed(x500, noise=True, grade="standard", seed=1):
    normals = np.random.default_rng(seed).standard_normal(BOOT_NORMALS)
    return new_sensed(x500.senses, RECEIVERS[grade], HOME, FIELD, normals, noise).view(np.recarray)


def test_without_noise_the_senses_tell_the_truth(x500):
    senses, rng = sensed(x500, noise=False), np.random.default_rng(2)
    s = senses[0]
    force, rate = np.array([1.0, 2.0, -9.0]), np.array([0.1, -0.2, 0.3])
    measure_imu(s, 1, force, rate, rng.standard_normal(12))
    np.testing.assert_array_equal(senses["imu"][0, 1], [*force, *rate])
    measure_baro(s, -12.0, 1.0, 5.0, rng.standard_normal(2))
    assert senses["baro_alt_m"][0] == HOME.alt_amsl_m + 12.0
    measure_mag(s, np.array(from_euler(0.0, 0.0, np.pi / 2)), rng.standard_normal(3))
    np.testing.assert_allclose(senses["mag_frd_gauss"][0], (FIELD[1], -FIELD[0], FIELD[2]), atol=1e-12)
    place, velocity = np.array([3.0, -4.0, -5.0]), np.array([1.0, 0.0, -1.0])
    measure_fix(s, 19, place, velocity, rng.standard_normal(12), True)
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
        measure_fix(senses[0], 0, np.zeros(3), np.zeros(3), rng.standard_normal(12), True)
        errors.append(ned_of_geodetic(home, tuple(senses["fix"][0, 0, :3])))
    errors = np.array(errors)
    h, v, _ = RECEIVERS[grade].sigma
    np.testing.assert_allclose(np.sqrt((errors**2).mean(axis=0)), (h, h, v), rtol=0.25)
    lag = 20  # 2 s later the white part is new, the wander hardly changed
    kept = (errors[:-lag] * errors[lag:]).mean(axis=0)
    wander = RECEIVERS[grade].wander_h_m
    np.testing.assert_allclose(kept[:2], wander**2, rtol=0.5)


def test_the_imus_scale_errs_by_its_sheet_and_is_the_samples_slope(x500):
    scales = np.array([sensed(x500, seed=seed)["imu_scale"][0] for seed in range(400)]) - 1.0
    np.testing.assert_allclose(scales[:, :3].std(), x500.senses.accel_scale, rtol=0.1)
    np.testing.assert_allclose(scales[:, 3:].std(), x500.senses.gyro_scale, rtol=0.1)
    senses, quiet = sensed(x500), np.zeros(12)
    one, two = (np.full(3, value) for value in (1.0, 3.0))
    measure_imu(senses[0], 0, one, one, quiet)
    measure_imu(senses[0], 1, two, two, quiet)
    rise = (senses["imu"][0, 1] - senses["imu"][0, 0]) / 2.0
    np.testing.assert_allclose(rise, senses["imu_scale"][0], rtol=1e-12)


def test_propellers_and_airstream_make_the_barometer_read_high(x500):
    senses, quiet = sensed(x500), np.zeros(2)
    read = []
    for load, speed in ((0.0, 0.0), (1.0, 0.0), (0.0, 5.0)):
        senses["baro_drift_m"] = 0.0
        measure_baro(senses[0], -12.0, load, speed, quiet)
        read.append(float(senses["baro_alt_m"][0]))
    assert read[1] - read[0] == pytest.approx(x500.senses.baro_wash_m)
    assert read[2] - read[0] == pytest.approx(x500.senses.baro_speed_share * 25.0 / (2.0 * 9.80665))


def test_steel_nearby_turns_the_field(x500):
    senses = sensed(x500, noise=False)
    senses["disturbance_ned_gauss"] = 0.0, 0.2, 0.0
    measure_mag(senses[0], np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3))
    np.testing.assert_allclose(senses["mag_frd_gauss"][0], (FIELD[0], FIELD[1] + 0.2, FIELD[2]))


def fixes(senses, count, frame0=9):
    home, rng, places = (HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m), np.random.default_rng(6), []
    for k in range(count):
        frame = frame0 + 10 * k
        measure_fix(senses[0], frame, np.zeros(3), np.zeros(3), rng.standard_normal(12), True)
        places.append(ned_of_geodetic(home, tuple(senses["fix"][0, frame % 16, :3])))
    return np.array(places)


def test_multipath_wanders_on_top_by_its_size_for_tens_of_seconds(x500):
    senses = sensed(x500, noise=False)
    senses["multipath_sigma_m"] = 2.0
    error = fixes(senses, 40_000)
    np.testing.assert_allclose(error.std(axis=0), 2.0, rtol=0.25)
    kept = (error[:-200] * error[200:]).mean(axis=0) / error.var(axis=0)  # 20 s later
    np.testing.assert_allclose(kept, np.exp(-1.0), atol=0.12)


def test_jumped_fixes_lie_north_and_drifting_ones_creep_there(x500):
    senses = sensed(x500, noise=False)
    senses["fix_offset_m"] = 5.0
    np.testing.assert_allclose(fixes(senses, 1)[0], (5.0, 0.0, 0.0), atol=1e-6)
    senses["fix_offset_m"], senses["fix_drift_mps"] = 0.0, 0.5
    np.testing.assert_allclose(fixes(senses, 20)[-1], (1.0, 0.0, 0.0), atol=1e-6)


@pytest.mark.parametrize("sense", STUCK_BITS)
def test_a_stuck_sense_repeats_itself_and_the_others_do_not(x500, sense):
    senses, rng = sensed(x500), np.random.default_rng(7)

    def sample(frame):
        for slot in (0, 1):
            measure_imu(
                senses[0], slot, rng.standard_normal(3), rng.standard_normal(3), rng.standard_normal(12)
            )
        measure_baro(senses[0], -frame, 1.0, 0.0, rng.standard_normal(2))
        measure_mag(senses[0], np.array([1.0, 0.0, 0.0, 0.0]), rng.standard_normal(3))
        measure_fix(senses[0], frame, rng.standard_normal(3), np.zeros(3), rng.standard_normal(12), True)
        now = senses[0]
        return {
            "accel": now.imu[1, :3].tolist(),
            "gyro": now.imu[1, 3:].tolist(),
            "baro": now.baro_alt_m,
            "mag": now.mag_frd_gauss.tolist(),
            "gps": now.fix[frame % 16].tolist(),
        }

    before = sample(9)
    senses["stuck"] = STUCK_BITS[sense]
    after = sample(19)
    assert {name for name in before if before[name] == after[name]} == {sense}
