import numpy as np

from mavspiral.curve.walk import Walk, signed_distance
from mavspiral.shape.contour import Ring


def circle(radius, centre=(0.0, 0.0), count=300):
    u = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return Ring(np.stack([centre[0] + radius * np.cos(u), centre[1] + radius * np.sin(u)], axis=-1))


def capsule(length, radius):
    u = np.linspace(0.0, np.pi, 100)
    east = np.stack([length + radius * np.sin(u), -radius * np.cos(u)], axis=-1)
    west = np.stack([-radius * np.sin(u), radius * np.cos(u)], axis=-1)
    return Ring(np.concatenate([east, west])).resampled(400)


def test_signed_distance_to_a_circle():
    points = np.random.default_rng(0).uniform(-20.0, 20.0, (500, 2))
    np.testing.assert_allclose(
        signed_distance(points, circle(9.0).points_enu_m), np.hypot(*points.T) - 9.0, atol=0.002
    )


def test_the_sign_holds_before_a_spike_and_inside_it():
    spike = np.array(
        [[20.0, 0.0], [19.9, 0.1], [10.0, 1.0], [-5.0, 1.0], [-5.0, -1.0], [10.0, -1.0], [19.0, -0.1]]
    )
    dense = Ring(spike).resampled(400).points_enu_m
    points = np.array([[28.0, 0.2], [28.0, -0.2], [15.0, 0.0], [0.0, 0.9], [0.0, 1.5], [-9.0, 0.0]])
    np.testing.assert_array_equal(np.sign(signed_distance(points, dense)), [1, 1, -1, -1, 1, 1])


def test_a_long_roof_draws_back_from_its_far_end_and_never_enters_the_target():
    start, target = capsule(60.0, 10.0), circle(9.0)
    walk = Walk(start, target, np.zeros(2), 3.0)
    outline, east, steps = start, start.points_enu_m[:, 0].max(), 0
    while not walk.arrived:
        outline = walk.step(2.0)
        steps += 1
        assert signed_distance(outline.points_enu_m, target.points_enu_m).min() > -0.05
        moved = east - outline.points_enu_m[:, 0].max()
        assert -0.05 <= moved < 4.0
        east = outline.points_enu_m[:, 0].max()
    assert outline is target
    assert 25 <= steps <= 60
