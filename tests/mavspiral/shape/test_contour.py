import numpy as np
import pytest

from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.contour import Ring, corners_closed, ring
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.slicing import solid_distance

FRAME = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))
SHAPES = {
    "L": [(0, 0, 40, 12), (0, 0, 12, 40)],
    "U": [(0, 0, 60, 12), (0, 0, 12, 40), (48, 0, 60, 40)],
}


def outline(boxes, standoff_m=8.0, corner_radius_m=3.0, anchor=(6.0, 6.0)):
    heights = np.zeros((160, 240))
    for west, south, east, north in boxes:
        heights[south * 4 : north * 4, west * 4 : east * 4] = 30.0
    solid = solid_distance(Site(HeightMap(heights, 0.25, FRAME, np.zeros(2)), heights > 0), reach_m=20.0)
    cut = solid.slice(10.0, standoff_m)
    return ring(solid, cut, anchor_enu_m=np.array(anchor), corner_radius_m=corner_radius_m)


def box_distance(points, boxes):
    return np.min(
        [
            np.hypot(
                np.maximum(0, np.maximum(w - points[:, 0], points[:, 0] - e)),
                np.maximum(0, np.maximum(s - points[:, 1], points[:, 1] - n)),
            )
            for w, s, e, n in boxes
        ],
        axis=0,
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_a_ring_keeps_the_standoff_to_a_centimetre_except_in_closed_corners(shape):
    boxes = SHAPES[shape]
    points = outline(boxes).points_enu_m
    distance = box_distance(points, boxes)
    assert distance.min() > 8.0 - 0.01
    # Of a closed right corner the middle of the arc is (√2 − 1)·r farther than the kink's sides.
    assert distance.max() < 8.0 + 3.0 * (np.sqrt(2.0) - 1.0) + 0.02
    away = np.linalg.norm(points[:, None] - np.array([[20.0, 20.0], [40.0, 20.0]]), axis=-1).min(axis=1) > 4.5
    assert np.abs(distance[away] - 8.0).max() < 0.01


@pytest.mark.parametrize("radius_m", [1.0, 3.0, 6.0])
def test_no_concave_corner_is_sharper_than_the_ball(radius_m):
    points = outline(SHAPES["L"], corner_radius_m=radius_m).points_enu_m
    step = np.roll(points, -1, axis=0) - points
    heading = np.angle(step[:, 0] + 1j * step[:, 1])
    turn = np.angle(np.exp(1j * (np.roll(heading, -1) - heading)))
    # Averaged over a few points: a chord's own turn is at the mercy of the outline's millimetres.
    mean_turn = np.convolve(np.concatenate([turn, turn[:4]]), np.full(5, 0.2), "valid")
    spacing = np.linalg.norm(step, axis=1).mean()
    assert mean_turn.min() / spacing > -1.3 / radius_m
    assert mean_turn.min() / spacing < -0.7 / radius_m


def test_a_channel_narrower_than_the_ball_is_closed():
    comb = [(0, 0, 60, 12), (0, 0, 20, 40), (38, 0, 60, 40)]  # 18 m wide: 2 m between the outlines
    shallow = outline(comb, corner_radius_m=2.0).points_enu_m
    channel = (shallow[:, 0] > 28.5) & (shallow[:, 0] < 29.5)
    assert shallow[channel, 1].max() > 40.0
    assert shallow[channel & (shallow[:, 1] > 0.0), 1].min() > 40.0


def test_a_ring_is_counter_clockwise_and_even():
    points = outline(SHAPES["U"]).points_enu_m
    x, y = points.T
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0.0
    steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    assert steps.max() / steps.min() < 1.05


def test_a_ring_goes_around_its_anchor_only():
    towers = [(0, 0, 8, 8), (50, 0, 58, 8)]
    assert outline(towers, anchor=(54.0, 4.0)).points_enu_m[:, 0].min() > 40.0
    assert outline(towers, anchor=(4.0, 4.0)).points_enu_m[:, 0].max() < 17.0
    assert outline(towers, anchor=(29.0, 30.0)) is None


def test_rolling_never_moves_an_outline_inward():
    rng = np.random.default_rng(5)
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    for _ in range(5):
        radius = 20.0 + sum(
            rng.normal(0, 6.0 / k) * np.cos(k * angle + rng.uniform(0, 6.28)) for k in range(2, 7)
        )
        start = Ring(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1))
        rolled = corners_closed(start, 4.0).points_enu_m
        around = np.interp(
            np.angle(rolled[:, 0] + 1j * rolled[:, 1]) % (2 * np.pi),
            np.append(angle, 2 * np.pi),
            [*radius, radius[0]],
        )
        assert (np.hypot(*rolled.T) - around).min() > -0.1
