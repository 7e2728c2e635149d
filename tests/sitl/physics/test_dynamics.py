import numpy as np
import pytest

from sitl.geo import GRAVITY_MPS2
from sitl.physics.dynamics import STEP_S, cushion, new_body, new_plant, step
from sitl.rotation import from_euler, rotate, to_yaw

STILL = np.zeros(4)
GRAVITY_NED = np.array([0.0, 0.0, GRAVITY_MPS2])
LEVEL = (1.0, 0.0, 0.0, 0.0)


def fly(body, plant, speed, seconds):
    for _ in range(round(seconds / STEP_S)):
        step(body[0], plant[0], speed)


@pytest.fixture
def plant(x500):
    return new_plant(x500, 0.0)


def in_vacuum(plant):
    plant["drag_ns2pm2"] = 0.0
    plant["rotor_drag_n_per_radps_mps"] = 0.0
    return plant


def hover_speed(x500):
    return np.full(4, (x500.body.mass_kg * GRAVITY_MPS2 / 4.0 / x500.rotors.thrust_n_per_radps2) ** 0.5)


def as_record(array):
    return array.view(np.recarray)


def test_torque_free_rotation_keeps_momentum_and_energy(plant, x500):
    body = new_body(LEVEL, (0.0, 0.0, -1000.0))
    body["rate_frd_radps"] = 3.0, -5.0, 4.0
    inertia = x500.body.inertia_kgm2

    def momentum():
        return np.array(rotate(body["q_ned_frd"][0], inertia * body["rate_frd_radps"][0]))

    before, energy = momentum(), (inertia * body["rate_frd_radps"][0] ** 2).sum()
    fly(as_record(body), as_record(in_vacuum(plant)), STILL, 5.0)
    np.testing.assert_allclose(momentum(), before, rtol=1e-6)
    assert (inertia * body["rate_frd_radps"][0] ** 2).sum() == pytest.approx(energy, rel=1e-7)
    assert np.linalg.norm(body["q_ned_frd"]) == pytest.approx(1.0, abs=1e-14)
    assert not np.allclose(body["rate_frd_radps"], (3.0, -5.0, 4.0))  # it tumbles


def test_free_fall_is_galileos_and_the_accelerometer_feels_nothing(plant):
    body = new_body(LEVEL, (0.0, 0.0, -100.0))
    fly(as_record(body), as_record(in_vacuum(plant)), STILL, 2.0)
    assert body["position_ned_m"][0][2] == pytest.approx(-100.0 + 0.5 * GRAVITY_MPS2 * 4.0, abs=1e-9)
    assert body["velocity_ned_mps"][0][2] == pytest.approx(2.0 * GRAVITY_MPS2, abs=1e-9)
    np.testing.assert_allclose(body["specific_force_frd_mps2"], 0.0, atol=1e-12)


def test_hover_speed_hovers_and_feels_minus_g(plant, x500):
    body = new_body(LEVEL, (0.0, 0.0, -50.0))
    body["rotor_speed_radps"] = hover_speed(x500)
    fly(as_record(body), as_record(plant), hover_speed(x500), 5.0)
    np.testing.assert_allclose(body["velocity_ned_mps"], 0.0, atol=1e-9)
    np.testing.assert_allclose(body["specific_force_frd_mps2"][0], (0.0, 0.0, -GRAVITY_MPS2), atol=1e-9)


@pytest.mark.parametrize(
    ("faster", "axis", "sign"), [((0, 2), 1, 1), ((1, 2), 0, 1), ((0, 1), 2, 1), ((2, 3), 2, -1)]
)
def test_each_pair_of_motors_turns_the_body_the_right_way(plant, x500, faster, axis, sign):
    """Front: nose up. Left: right wing down. Counter-clockwise ones: nose clockwise, seen from above."""
    body, speed = new_body(LEVEL, (0.0, 0.0, -50.0)), hover_speed(x500)
    body["rotor_speed_radps"] = speed
    speed[list(faster)] *= 1.01
    fly(as_record(body), as_record(plant), speed, 0.1)
    rate = body["rate_frd_radps"][0]
    assert sign * rate[axis] > 1e-3
    assert abs(rate[axis]) > 100.0 * np.abs(np.delete(rate, axis)).max()


def test_rotors_reach_63_percent_in_their_time_constants(plant, x500):
    body = new_body(LEVEL, (0.0, 0.0, -50.0))
    fly(as_record(body), as_record(plant), np.full(4, 500.0), x500.rotors.time_constant_up_s)
    np.testing.assert_allclose(body["rotor_speed_radps"], 500.0 * (1.0 - np.exp(-1.0)), rtol=1e-12)
    body["rotor_speed_radps"] = 500.0
    fly(as_record(body), as_record(plant), STILL, x500.rotors.time_constant_down_s)
    np.testing.assert_allclose(body["rotor_speed_radps"], 500.0 * np.exp(-1.0), rtol=1e-12)


def test_wind_drags_a_hovering_vehicle_along(plant, x500):
    body = new_body(LEVEL, (0.0, 0.0, -50.0))
    body["rotor_speed_radps"] = hover_speed(x500)
    plant["wind_ned_mps"] = 0.0, 4.0, 0.0
    fly(as_record(body), as_record(plant), hover_speed(x500), 0.1)
    assert body["velocity_ned_mps"][0][1] > 0.02 and abs(body["velocity_ned_mps"][0][0]) < 1e-6


def test_it_stands_to_the_last_bit_in_a_wind_that_would_push_it(plant):
    body = new_body(from_euler(0.0, 0.0, 0.7), (0.0, 0.0, 0.0))
    plant["wind_ned_mps"] = 6.0, 6.0, 0.0
    before = body.copy()
    fly(as_record(body), as_record(plant), np.full(4, 150.0), 5.0)
    for name in ("position_ned_m", "velocity_ned_mps", "q_ned_frd", "rate_frd_radps"):
        np.testing.assert_array_equal(body[name], before[name])
    np.testing.assert_allclose(body["specific_force_frd_mps2"][0], (0.0, 0.0, -GRAVITY_MPS2), atol=1e-12)


def test_a_storm_moves_it_all_the_same(plant):
    body = new_body(LEVEL, (0.0, 0.0, 0.0))
    plant["wind_ned_mps"] = 40.0, 0.0, 0.0
    fly(as_record(body), as_record(plant), STILL, 2.0)
    assert body["position_ned_m"][0][0] > 0.1


def test_dropped_askew_and_drifting_it_comes_to_rest_level_on_the_ground(plant):
    body = new_body(from_euler(0.15, -0.1, 0.5), (0.0, 0.0, -0.5))
    body["velocity_ned_mps"] = 0.5, 0.0, 0.0
    fly(as_record(body), as_record(plant), STILL, 3.0)
    at_rest = body.copy()
    np.testing.assert_array_equal(body["velocity_ned_mps"], 0.0)
    assert body["position_ned_m"][0][2] == pytest.approx(0.0, abs=2e-3)
    assert 0.01 < body["position_ned_m"][0][0] < 0.6
    assert rotate(body["q_ned_frd"][0], (0.0, 0.0, 1.0))[2] > 0.9999
    assert to_yaw(body["q_ned_frd"][0]) == pytest.approx(0.5, abs=0.1)
    fly(as_record(body), as_record(plant), STILL, 3.0)
    np.testing.assert_array_equal(body["position_ned_m"], at_rest["position_ned_m"])


def test_what_the_accelerometer_feels_integrates_to_the_velocity_through_a_landing(plant, x500):
    """Also while thrust fades on the ground, where the body falls asleep and wakes."""
    body, velocity, speed = new_body(LEVEL, (0.0, 0.0, -0.3)), np.zeros(3), hover_speed(x500)
    body["rotor_speed_radps"] = speed
    body["velocity_ned_mps"] = 0.2, 0.1, 0.7
    velocity = body["velocity_ned_mps"][0].copy()
    for k in range(2400):
        step(as_record(body)[0], as_record(plant)[0], speed * max(0.3, 1.0 - k / 2400.0))
        velocity += STEP_S * (
            np.array(rotate(body["q_ned_frd"][0], body["specific_force_frd_mps2"][0])) + GRAVITY_NED
        )
        np.testing.assert_allclose(velocity, body["velocity_ned_mps"][0], atol=0.02)
    np.testing.assert_array_equal(body["velocity_ned_mps"], 0.0)


def test_the_ground_lies_where_it_is_put(x500):
    plant = new_plant(x500, -3.0)
    body = new_body(LEVEL, (0.0, 0.0, -5.0))
    fly(as_record(body), as_record(plant), STILL, 4.0)
    assert body["position_ned_m"][0][2] == pytest.approx(-3.0, abs=2e-3)


def test_near_the_ground_each_rotor_gains_what_cheeseman_and_bennett_say(x500, plant):
    """1 / (1 - (R/4z)²): 6.7 % one radius up, 1.6 % two up, nothing above ten."""
    p, radius = as_record(plant)[0], x500.rotors.radius_m
    rotor_m = -x500.rotors.position_frd_m[0, 2]
    for radii, gain in ((1.0, 1.0667), (2.0, 1.0159), (4.0, 1.0039), (30.0, 1.0)):
        centre_down = plant["ground_down_m"][0] - radii * radius + rotor_m
        cushion((0.0, 0.0, centre_down), LEVEL, p)
        np.testing.assert_allclose(plant["cushion"][0], gain, atol=1e-4)


def test_a_bank_near_the_ground_lifts_the_lower_side_more(plant):
    cushion((0.0, 0.0, -0.1), from_euler(0.2, 0.0, 0.0), as_record(plant)[0])
    front_right, rear_left, front_left, rear_right = plant["cushion"][0]
    assert front_right == rear_right > front_left == rear_left > 1.0


def test_hover_speed_climbs_off_the_ground_and_hovers_higher_up(plant, x500):
    body = new_body(LEVEL, (0.0, 0.0, -0.05))
    body["rotor_speed_radps"] = hover_speed(x500)
    fly(as_record(body), as_record(plant), hover_speed(x500), 0.5)
    height_m = 0.05 + 0.5 + 0.2
    gain = 1.0 / (1.0 - (x500.rotors.radius_m / (4.0 * (height_m - 0.5 + 0.06))) ** 2) - 1.0
    assert 0.3 * gain * GRAVITY_MPS2 * 0.5 < -body["velocity_ned_mps"][0][2] < 2.0 * gain * GRAVITY_MPS2 * 0.5


def test_a_rotor_whose_disc_touches_the_ground_stands(plant, x500):
    body = new_body(from_euler(np.pi, 0.0, 0.0), (0.0, 0.0, -0.06 + float(plant["ground_down_m"][0])))
    full = np.full(4, x500.rotors.speed_max_radps)
    fly(as_record(body), as_record(plant), full, 1.0)
    assert np.all(body["rotor_speed_radps"] < 0.25 * full)
    assert np.all(np.abs(body["velocity_ned_mps"]) < 0.01)
    body = new_body(LEVEL, (0.0, 0.0, 0.0))
    fly(as_record(body), as_record(plant), full, 0.2)
    assert np.all(body["rotor_speed_radps"] > 0.95 * full)
