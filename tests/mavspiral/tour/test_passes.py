import re
from dataclasses import replace

import numpy as np
import pytest

from mavspiral.curve.line import LinePath
from mavspiral.errors import LimitError
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.motion.limits import Limits
from mavspiral.motion.trajectory import Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.survey.solids import Solids
from mavspiral.tour.passes import Piece, flown_in_order, tour_of
from mavspiral.tour.transit import Ways

LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, 0.8, 1.0)
FRAME = LocalFrame(GeoPoint(40.05, -1.93, 1000.0))


def piece(name, start, end, yaw, pitch=0.0):
    return Piece(
        name, "spiral", LinePath(start, end), TurnGaze(yaw, yaw), 1, 2, 8.0, LIMITS, TurnGaze(pitch, pitch)
    )


def ways(wall_m=0.0):
    """Over a field 100 m wide with a wall across it, 40 m east."""
    heights = np.zeros((60, 100))
    heights[:, 40] = wall_m
    solids = Solids.of(heights, 1.0, (0.0, -30.0))
    return Ways(
        solids,
        FRAME,
        wall_m,
        LIMITS,
        3.0,
        60.0,
        radius_m=0.4,
        named=lambda place, sweep: "a wall",
        smaller=lambda m: f"{m:.2f} m",
    )


def test_a_lone_pass_is_the_inspection():
    (alone,) = flown_in_order([piece("building", (0, 0, 5), (20, 0, 5), 0.3)])
    assert alone.leg.name == "inspection"
    assert alone.length_m == pytest.approx(20.0)
    assert tour_of([alone], ways()) == (alone.leg,)


def test_several_passes_are_joined_and_nose_and_camera_turn_on_the_way():
    passes = flown_in_order(
        [
            piece("tower 1", (0, 0, 5), (20, 0, 5), 0.3),
            piece("roof of tower 1", (60, 0, 9), (90, 0, 9), -2.0, -0.7),
        ]
    )
    tour = tour_of(passes, ways(wall_m=12.0))
    assert [leg.name for leg in tour] == [
        "inspection-tower-1",
        *("transit-1-1", "transit-1-2", "transit-1-3"),
        "inspection-roof-of-tower-1",
    ]
    flight = Trajectory(tour)
    states = flight.sampled(0.01)
    assert np.abs(np.diff(states.gimbal_pitch_rad)).max() < 0.01
    assert np.abs(states.yaw_rate_enu_radps).max() <= LIMITS.yaw_rate_radps * 1.0001
    crossing = states.position_enu_m[np.abs(states.position_enu_m[:, 0] - 40.5) < 3.0]
    assert 15.5 <= crossing[:, 2].min() < 17.6
    turning = ~flight.on("inspection", states.t_s)
    assert np.ptp(states.gimbal_pitch_rad[~turning]) == pytest.approx(0.7)
    assert flight(flight.span_s("transit-1-2")[0]).gimbal_pitch_rad == 0.0
    assert flight(flight.span_s("transit-1-2")[1]).gimbal_pitch_rad == pytest.approx(-0.7)


def test_passes_that_touch_turn_above_the_place():
    passes = flown_in_order([piece("a", (0, 0, 5), (20, 0, 5), 0.3), piece("b", (20, 0, 5), (40, 0, 5), 2.3)])
    tour = tour_of(passes, ways())
    assert [leg.name for leg in tour] == ["inspection-a", "transit-1-1", "transit-1-2", "inspection-b"]
    assert Trajectory(tour).sampled(0.05).position_enu_m[:, 2].max() == pytest.approx(6.0, abs=1e-3)


def test_a_leg_that_ends_before_a_wall_is_slow_enough_to_stop():
    (before, after) = flown_in_order(
        [piece("a", (0, 0, 5), (10, 0, 5), 0.3), piece("b", (36, 0, 5), (36, 9, 5), 0.3)]
    )

    def overshoot_m(towards):
        states = Trajectory(tour_of([before, after], towards)).sampled(0.01)
        speed = states.velocity_enu_mps[:, 0]
        return (states.position_enu_m[:, 0] + speed * 1.0 + speed**2 / 4.0).max() - 36.0

    assert overshoot_m(ways()) > 3.4
    assert overshoot_m(ways(wall_m=12.0)) < 3.2


def test_two_passes_that_no_way_joins_are_named():
    passes = flown_in_order(
        [piece("tower 1", (0, 0, 5), (10, 0, 5), 0.3), piece("tower 2", (60, 0, 5), (70, 0, 5), 0.3)]
    )
    with pytest.raises(LimitError, match="no way between tower 1 and tower 2 keeps"):
        tour_of(passes, ways(wall_m=58.0))


def apart(end_m, begin_m):
    return flown_in_order([piece("a", (0, 0, 5), end_m, 0.3), piece("b", begin_m, (70, 0, begin_m[2]), 0.3)])


def test_a_pass_that_ends_too_near_for_a_way_is_told_so_and_not_the_ceiling():
    """However high the ceiling: what is too near at its end is so for every way."""
    for ceiling_m in (60.0, 600.0):
        ways_below = replace(ways(wall_m=12.0), ceiling_m=ceiling_m)
        with pytest.raises(LimitError) as refusal:
            tour_of(apart((36.8, 0, 5), (60, 0, 5)), ways_below)
        assert "the pass of a ends 3.20 m from a wall" in str(refusal.value)
        assert str(refusal.value).endswith("Fix: another standoff_m, or 2.60 m")
    tour_of(apart((36.8 - 0.4, 0, 5), (60, 0, 5)), ways_below)


def test_of_the_building_the_pass_is_to_keep_more():
    building = replace(ways(wall_m=12.0), named=lambda place, sweep: "the building")
    with pytest.raises(LimitError, match=r"Fix: a standoff_m larger by 0\.4 m, or"):
        tour_of(apart((36.8, 0, 5), (60, 0, 5)), building)


@pytest.mark.parametrize("begin_up_m", [5.0, 61.5])
def test_the_ceiling_that_is_asked_for_is_high_enough_and_not_much_too_high(begin_up_m):
    passes = apart((10, 0, 5), (60, 0, begin_up_m))
    with pytest.raises(LimitError) as refusal:
        tour_of(passes, ways(58.0))
    asked_m = int(re.search(r"ceiling_m ≥ (\d+)", str(refusal.value))[1])
    tour_of(passes, replace(ways(58.0), ceiling_m=asked_m))
    with pytest.raises(LimitError):
        tour_of(passes, replace(ways(58.0), ceiling_m=asked_m - 1.5))
    assert ("the pass of b is 61.5 m above ground there" in str(refusal.value)) == (begin_up_m > 60.0)
