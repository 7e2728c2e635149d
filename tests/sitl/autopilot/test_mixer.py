import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.airframe import load_airframe
from sitl.autopilot.mixer import mix, mix_columns, signal_for

COLUMNS = mix_columns(load_airframe("x500").rotors)
torque = st.floats(-1.5, 1.5)
few = settings(max_examples=150, deadline=None)


def mixed(roll, pitch, yaw, thrust):
    motors, saturated = np.zeros(4), np.zeros(3, np.int64)
    mix(COLUMNS, np.array([roll, pitch, yaw]), thrust, motors, saturated)
    return motors, saturated


def made(motors):
    """The torque and thrust that these motors make, in the mixer's own units."""
    return COLUMNS @ motors / (COLUMNS**2).sum(axis=1)


def test_the_columns_are_px4s():
    h = 0.5**0.5
    np.testing.assert_allclose(
        COLUMNS, [[-h, h, h, -h], [h, -h, h, -h], [1, 1, -1, -1], [1, 1, 1, 1]], atol=1e-12
    )


@few
@given(torque, torque, torque, st.floats(0.0, 1.0))
def test_motors_stay_between_nothing_and_all(roll, pitch, yaw, thrust):
    motors, _ = mixed(roll, pitch, yaw, thrust)
    assert (motors >= 0.0).all() and (motors <= 1.0).all()


@few
@given(*[st.floats(-0.1, 0.1)] * 3, st.floats(0.3, 0.7))
def test_what_fits_is_made_exactly(roll, pitch, yaw, thrust):
    motors, saturated = mixed(roll, pitch, yaw, thrust)
    np.testing.assert_allclose(made(motors), (roll, pitch, yaw, thrust), atol=1e-12)
    assert not saturated.any()


@few
@given(*[st.floats(-0.3, 0.3)] * 2, torque, st.floats(0.45, 0.55))
def test_roll_and_pitch_are_kept_whatever_the_yaw(roll, pitch, yaw, thrust):
    motors, saturated = mixed(roll, pitch, yaw, thrust)
    np.testing.assert_allclose(made(motors)[:2], (roll, pitch), atol=0.08)
    assert abs(made(motors)[2]) <= abs(yaw) + 1e-9
    assert saturated[2] in (0, np.sign(yaw))


@few
@given(torque, torque, torque, st.floats(0.0, 1.0))
def test_thrust_is_never_raised_for_torques_sake(roll, pitch, yaw, thrust):
    motors, _ = mixed(roll, pitch, 0.0, thrust)
    assert motors.mean() <= thrust + 1e-9


def test_at_full_thrust_a_roll_still_gets_through_by_giving_up_thrust():
    motors, saturated = mixed(0.4, 0.0, 0.0, 1.0)
    assert made(motors)[0] == pytest.approx(0.4)
    assert motors.mean() < 0.8 and saturated[0] == 0


def test_saturation_is_reported_by_axis_and_direction():
    assert mixed(-1.5, 0.0, 0.0, 0.5)[1].tolist() == [-1, 0, 0]
    assert mixed(0.0, 0.0, 1.5, 0.5)[1].tolist() == [0, 0, 1]


def test_rotors_that_do_not_balance_are_refused():
    rotors = load_airframe("x500").rotors
    crooked = rotors.position_frd_m.copy()
    crooked[0, 0] += 0.05
    with pytest.raises(ValueError, match="not symmetric"):
        mix_columns(dataclasses.replace(rotors, position_frd_m=crooked))


@few
@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_the_signal_undoes_the_thrust_curve(thrust, model):
    s = signal_for(thrust, model)
    assert model * s * s + (1.0 - model) * s == pytest.approx(thrust, abs=1e-9)
