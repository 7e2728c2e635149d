"""Setpoints that pass waypoints: within their limits, without a stop, and still where it ends."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.autopilot.glide import Glide, GlideLimits
from sitl.autopilot.modes import Waypoint
from sitl.autopilot.passage import Leg, Passage, step_passage, turned

LIMITS = GlideLimits(5.0, 3.0, 1.5, 3.0, 4.0, math.radians(60.0))
PARAMETERS = {
    "MPC_XY_TRAJ_P": 0.5,
    "MPC_XY_ERR_MAX": 2.0,
    "MPC_YAWRAUTO_MAX": 60.0,
    "MPC_YAWRAUTO_ACC": 20.0,
}
DT_S = 0.01
REST = Glide(0j, 0j, 0j, 0.0, 0.0, 0.0, 0.0, 0.0)


def fly(places, radius_m=2.0, seconds=120.0, behind_m=0j):
    """The setpoint along the places, which a perfect vehicle follows."""
    points = [Waypoint(0j, 0.0), *(Waypoint(complex(n, e), d) for n, e, d in places)]
    passage, at, glides = Passage(REST), 1, []
    for _ in range(round(seconds / DT_S)):
        after = points[at + 1] if at + 1 < len(points) else None
        leg = Leg(points[at - 1], points[at], after, radius_m)
        passage = step_passage(passage, leg, 0.0, LIMITS, PARAMETERS, behind_m, DT_S)
        glides.append(passage.glide)
        end = points[at]
        near = abs(end.place_m - passage.glide.position_m) < radius_m
        if after is not None and near and abs(end.down_m - passage.glide.down_m) < 0.8:
            at += 1
    assert at == len(points) - 1
    return glides


PLACES = st.lists(
    st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(-20, 0)), min_size=1, max_size=5
)


@given(PLACES)
@settings(max_examples=12, deadline=None)
def test_it_keeps_its_limits_and_comes_to_rest_at_the_end(places):
    glides = fly(places)
    before = REST
    for glide in glides:
        assert abs(glide.velocity_mps) <= 5.0 * 1.02
        assert -3.0 * 1.02 <= glide.down_speed_mps <= 1.5 * 1.02
        assert abs(glide.acceleration_mps2) <= 3.0 + 1e-9
        assert abs(glide.acceleration_mps2 - before.acceleration_mps2) <= 4.0 * DT_S + 1e-9
        before = glide
    north_m, east_m, down_m = places[-1]
    assert before.position_m == pytest.approx(complex(north_m, east_m), abs=0.02)
    assert before.down_m == pytest.approx(down_m, abs=0.02)


def test_a_climb_along_a_line_stays_near_the_line():
    """While speeding up the axes part by less than a metre: PX4 synchronises them, this does not."""
    for glide in fly([(30.0, 0.0, -15.0)], seconds=40.0):
        assert abs(-glide.down_m - 0.5 * glide.position_m.real) < 1.0


def test_the_speed_between_close_waypoints_is_what_still_stops_at_the_one_after():
    glides = fly([(2.0 * k, 0.0, 0.0) for k in range(1, 20)], radius_m=1.0)
    speeds = [abs(g.velocity_mps) for g in glides if 8.0 < g.position_m.real < 30.0]
    exit_mps = 0.5 * (math.sqrt(81.0 + 24.0 * 2.0) - 9.0)  # PX4's formula, 2 m ahead
    assert exit_mps < np.mean(speeds) < 1.8 * exit_mps


def test_it_waits_for_a_vehicle_that_is_left_behind():
    ahead = fly([(40.0, 0.0, 0.0)], seconds=5.0)[-1].position_m.real
    waiting = fly([(40.0, 0.0, 0.0)], seconds=5.0, behind_m=1.0 + 0j)[-1].position_m.real
    assert waiting < 0.7 * ahead
    assert fly([(40.0, 0.0, 0.0)], seconds=5.0, behind_m=3.0 + 0j)[-1].position_m.real < 0.1


@pytest.mark.parametrize("wanted_deg", [2.0, 30.0, 175.0, -90.0])
def test_a_turn_keeps_its_rate_and_acceleration_and_does_not_overshoot(wanted_deg):
    yaw, rate, wanted = 0.0, 0.0, math.radians(wanted_deg)
    for _ in range(1500):
        before = rate
        yaw, rate = turned(yaw, rate, wanted, PARAMETERS, DT_S)
        assert abs(rate) <= math.radians(60.0) + 1e-9
        assert abs(rate - before) <= math.radians(20.0) * DT_S + 1e-9
        assert math.copysign(1.0, wanted) * (yaw - wanted) < math.radians(1.0)
    assert yaw == pytest.approx(wanted, abs=1e-3)
