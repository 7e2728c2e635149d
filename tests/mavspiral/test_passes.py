import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.motion.limits import Limits
from mavspiral.motion.trajectory import Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.passes import Piece, flown_in_order, tour_of

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)
CLIMBING_OVER = np.array([0.0, 0.0, 12.0])


def piece(name, start, end, yaw, pitch=0.0):
    return Piece(name, "spiral", LinePath(start, end), TurnGaze(yaw, yaw), 1, 2, TurnGaze(pitch, pitch))


def over(start, end):
    return np.array([start, start + CLIMBING_OVER, end + CLIMBING_OVER, end])


def test_a_lone_pass_is_the_inspection():
    (alone,) = flown_in_order([piece("building", (0, 0, 5), (20, 0, 5), 0.3)], LIMITS)
    assert alone.leg.name == "inspection"
    assert alone.length_m == pytest.approx(20.0)
    assert tour_of([alone], over, LIMITS) == (alone.leg,)


def test_several_passes_are_joined_and_nose_and_camera_turn_on_the_way():
    passes = flown_in_order(
        [
            piece("tower 1", (0, 0, 5), (20, 0, 5), 0.3),
            piece("roof of tower 1", (60, 0, 9), (90, 0, 9), -2.0, -0.7),
        ],
        LIMITS,
    )
    tour = tour_of(passes, over, LIMITS)
    assert [leg.name for leg in tour] == [
        "inspection-tower-1",
        *("transit-1-1", "transit-1-2", "transit-1-3"),
        "inspection-roof-of-tower-1",
    ]
    flight = Trajectory(tour)
    states = flight.sampled(0.01)
    assert np.abs(np.diff(states.gimbal_pitch_rad)).max() < 0.01
    assert np.abs(states.yaw_rate_enu_radps).max() <= LIMITS.yaw_rate_radps * 1.0001
    turning = ~flight.on("inspection", states.t_s)
    assert np.ptp(states.gimbal_pitch_rad[~turning]) == pytest.approx(0.7)
    assert flight(flight.span_s("transit-1-2")[0]).gimbal_pitch_rad == 0.0
    assert flight(flight.span_s("transit-1-2")[1]).gimbal_pitch_rad == pytest.approx(-0.7)


def test_passes_that_touch_turn_above_the_place():
    passes = flown_in_order(
        [piece("a", (0, 0, 5), (20, 0, 5), 0.3), piece("b", (20, 0, 5), (40, 0, 5), 2.3)], LIMITS
    )
    tour = tour_of(passes, lambda start, end: np.array([start, end]), LIMITS)
    assert [leg.name for leg in tour] == ["inspection-a", "transit-1-1", "transit-1-2", "inspection-b"]
    assert Trajectory(tour).sampled(0.05).position_enu_m[:, 2].max() == pytest.approx(6.0, abs=1e-3)
