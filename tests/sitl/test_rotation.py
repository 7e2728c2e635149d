import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl import rotation as r

part = st.floats(-1.0, 1.0)
quaternions = (
    st.tuples(part, part, part, part).filter(lambda q: sum(x * x for x in q) > 1e-3).map(r.normalized)
)
vectors = st.tuples(*[st.floats(-100.0, 100.0)] * 3)
few = settings(max_examples=60, deadline=None)


@few
@given(quaternions, vectors)
def test_rotate_is_its_matrix_and_unrotate_is_the_way_back(q, v):
    np.testing.assert_allclose(r.rotate(q, v), np.array(r.matrix(q)) @ v, atol=1e-11)
    np.testing.assert_allclose(r.unrotate(q, r.rotate(q, v)), v, atol=1e-11)


@few
@given(quaternions, quaternions, vectors)
def test_a_product_does_the_right_factor_first(p, q, v):
    np.testing.assert_allclose(r.rotate(r.multiply(p, q), v), r.rotate(p, r.rotate(q, v)), atol=1e-11)


@few
@given(quaternions)
def test_axes_give_the_rotation_back_up_to_sign(q):
    x, y, z = np.array(r.matrix(q)).T
    assert abs(np.dot(r.from_axes(tuple(x), tuple(y), tuple(z)), q)) > 1.0 - 1e-12


@few
@given(vectors)
def test_the_exponential_turns_about_its_vector_by_its_length(v):
    angle = math.sqrt(sum(x * x for x in v))
    q = r.exponential(v)
    np.testing.assert_allclose(np.linalg.norm(q), 1.0, atol=1e-12)
    np.testing.assert_allclose(r.rotate(q, v), v, atol=1e-10)
    np.testing.assert_allclose(q[0], math.cos(angle / 2.0), atol=1e-12)


def test_the_exponential_is_continuous_where_it_changes_to_its_series():
    below, above = r.exponential((9.9999e-5, 0.0, 0.0)), r.exponential((1.00001e-4, 0.0, 0.0))
    np.testing.assert_allclose(below[1], 0.5 * 9.9999e-5, rtol=1e-9)
    np.testing.assert_allclose(above[1], 0.5 * 1.00001e-4, rtol=1e-9)


@few
@given(quaternions, quaternions)
def test_between_takes_one_direction_to_the_other_the_short_way(p, q):
    a, b = r.rotate(p, (1.0, 0.0, 0.0)), r.rotate(q, (1.0, 0.0, 0.0))
    turn = r.between(a, b)
    np.testing.assert_allclose(r.rotate(turn, a), b, atol=1e-6)
    assert turn[0] >= 0.0


def test_between_opposite_directions_is_half_a_turn():
    for a in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        b = tuple(-x for x in a)
        np.testing.assert_allclose(r.rotate(r.between(a, b), a), b, atol=1e-12)


def test_euler_angles_by_the_compass():
    q = r.from_euler(0.0, 0.0, math.pi / 2.0)  # nose east
    np.testing.assert_allclose(r.rotate(q, (1.0, 0.0, 0.0)), (0.0, 1.0, 0.0), atol=1e-12)
    q = r.from_euler(0.0, 0.1, 0.0)  # nose up
    assert r.rotate(q, (1.0, 0.0, 0.0))[2] < 0.0
    q = r.from_euler(0.1, 0.0, 0.0)  # right wing down
    assert r.rotate(q, (0.0, 1.0, 0.0))[2] > 0.0
    np.testing.assert_allclose(r.to_yaw(r.from_euler(0.2, -0.3, 1.1)), 1.1, atol=1e-12)
