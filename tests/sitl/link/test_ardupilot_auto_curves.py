"""AUTO by ArduPilot's rules beyond straight legs: splines, turns, heights, a home that moves, a mission that begins anew."""

import math

import numpy as np
import pytest
from copter_client import AUTO, mavlink
from test_ardupilot_missions import HOME, RETURN, TAKEOFF, do, fly, place, waypoint

from sitl.autopilot.curves import spline_between
from sitl.autopilot.scurve import leg_between, reaches_within, stops_within


def spline(north_m, east_m, alt_m=10.0):
    return waypoint(north_m, east_m, alt_m, command=82)


def hermite(begin, end, first, last):
    """The curve as textbooks write it; end vectors longer than four chords together are shortened."""
    long_m, chord_m = np.linalg.norm(first) + np.linalg.norm(last), np.linalg.norm(end - begin)
    scale = min(1.0, 4.0 * chord_m / long_m) if long_m else 1.0
    u = np.linspace(0.0, 1.0, 400)[:, None]
    return (
        (2 * u**3 - 3 * u**2 + 1) * begin
        + (u**3 - 2 * u**2 + u) * first * scale
        + (-2 * u**3 + 3 * u**2) * end
        + (u**3 - u**2) * last * scale
    )


def off_m(rows, curve):
    """The greatest distance of the flown places from a curve, both in plan."""
    return max(np.linalg.norm(curve[:, :2] - row, axis=1).min() for row in rows)


def test_splines_are_hermite_curves_with_ardupilots_end_vectors_and_are_passed_at_speed(copter):
    points = [np.array(p) for p in ((0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0), (-20.0, 40.0))]
    b, c, d, e = points[1:]
    rows, _ = fly(
        copter,
        *(TAKEOFF, do(178, 1, 4.0)),
        *(waypoint(*b), spline(*c), spline(*d), waypoint(*e)),
    )
    begin = rows[rows[:, 1] == 1][-1, 2:4]
    # Straight to b; from there along that leg, parallel to b–d at c; then parallel to d–e at d.
    expected = {
        3: np.linspace(begin, b, 200),
        4: hermite(b, c, b - begin, d - b),
        5: hermite(c, d, d - b, e - d),
        6: np.linspace(d, e, 200),
    }
    for seq, curve in expected.items():
        assert off_m(rows[rows[:, 1] == seq][:, 2:4], curve) < 1.0, seq
    for corner in (b, c, d):
        near = np.linalg.norm(rows[:, 2:4] - corner, axis=1) < 2.0
        assert rows[near, 6].min() > 1.5
    assert rows[:, 6].max() < 4.4


def test_a_spline_turns_the_nose_along_the_curve(copter):
    rows, _ = fly(copter, TAKEOFF, do(178, 1, 3.0), spline(40.0, 0.0), spline(40.0, 40.0), spline(0.0, 40.0))
    moving = rows[rows[:, 6] > 1.5]
    course = np.degrees(np.arctan2(np.gradient(moving[:, 3]), np.gradient(moving[:, 2])))
    off = (moving[:, 5] - course + 180.0) % 360.0 - 180.0
    assert np.percentile(np.abs(off), 90) < 15.0


def test_a_spline_with_a_delay_stops(copter):
    rows, _ = fly(copter, TAKEOFF, waypoint(30.0, 0.0, delay_s=2.0, command=82), spline(30.0, 30.0))
    near = np.linalg.norm(rows[:, 2:4] - (30.0, 0.0), axis=1) < 2.0
    assert rows[near, 6].min() < 0.3


def test_along_a_spline_speed_and_acceleration_keep_their_limits_and_place_is_their_integral():
    begin, end = np.array((0.0, 0.0, -10.0)), np.array((30.0, 10.0, -25.0))
    vectors = np.array((30.0, -30.0, 0.0)), np.array((0.0, 40.0, 0.0))
    leg = spline_between(begin, end, vectors, (6.0, 2.0, 1.5), (2.5, 1.0), (2.0, 1.0))
    t = np.arange(0.0, leg.duration_s, 0.01)
    motions = [leg.motion(x) for x in t]
    place_m = np.array([(m.place_m.real, m.place_m.imag, m.down_m) for m in motions])
    velocity = np.array([(m.velocity_mps.real, m.velocity_mps.imag, m.down_speed_mps) for m in motions])
    assert np.hypot(velocity[:, 0], velocity[:, 1]).max() < 6.001  # between two samples
    assert -velocity[:, 2].min() < 2.001
    assert np.diff(place_m, axis=0) / 0.01 == pytest.approx(velocity[:-1], abs=0.06)
    across = [abs(m.acceleration_mps2) for m in motions]
    assert max(across) < 1.1 * math.hypot(2.5, 2.5)
    assert np.linalg.norm(velocity[0]) <= 2.0 + 1e-9
    assert leg.end_mps <= 1.0


def test_a_leg_that_begins_and_ends_at_speed_covers_its_length_within_its_limits():
    from dataclasses import replace

    bare = leg_between(0j, 0.0, 20.0 + 0j, 0.0, (5.0, 2.0, 2.0), (2.0, 1.0), 2.0)
    for begin_mps, end_mps in ((0.0, 3.0), (3.0, 0.0), (4.0, 2.0), (1.0, 5.0)):
        begin_mps = min(begin_mps, stops_within(bare))
        leg = replace(bare, begin_mps=begin_mps, end_mps=reaches_within(bare, begin_mps, end_mps))
        rows = np.array([leg.along(t) for t in np.linspace(0.0, leg.duration_s, 500)])
        assert rows[-1, 0] == pytest.approx(20.0, abs=1e-6)
        assert rows[-1, 1] == pytest.approx(leg.end_mps, abs=1e-6)
        assert rows[:, 1].max() < 5.0 + 1e-6
        assert np.abs(rows[:, 2]).max() < 2.0 + 1e-6


@pytest.mark.parametrize(("radius_m", "turn"), [(12.0, 1), (-12.0, -1), (0.0, 1)])
def test_loiter_turns_flies_to_the_edge_and_round_and_looks_at_the_centre(copter, radius_m, turn):
    lat, lon, _ = place(40.0, 0.0, 0.0)
    turns = 1.5
    rows, heard = fly(
        copter,
        TAKEOFF,
        (18, 3, (turns, 0, radius_m, 0, lat, lon, 10.0)),
        waypoint(40.0, 40.0),
        parameters=((b"CIRCLE_RADIUS", 800.0),),
    )
    to = rows[:, 2:4] - (40.0, 0.0)
    wanted_m = abs(radius_m) or 8.0
    circling = (rows[:, 1] == 2) & (np.abs(np.hypot(*to.T) - wanted_m) < 1.0)
    angle = np.unwrap(np.arctan2(to[circling, 1], to[circling, 0]))
    assert angle[-1] - angle[0] == pytest.approx(turn * turns * math.tau, abs=0.3)
    inwards = np.degrees(np.arctan2(-to[circling, 1], -to[circling, 0]))
    off = (rows[circling, 5] - inwards + 180.0) % 360.0 - 180.0
    assert np.median(np.abs(off)) < 12.0
    assert [m.seq for m in heard if m.get_type() == "MISSION_ITEM_REACHED"][:2] == [1, 2]


def test_loiter_to_alt_goes_there_first_and_then_up(copter):
    lat, lon, _ = place(25.0, 0.0, 0.0)
    rows, _ = fly(copter, TAKEOFF, (31, 3, (0, 0, 0, 0, lat, lon, 20.0)), waypoint(25.0, 10.0, 20.0))
    assert -rows[rows[:, 2] < 22.0, 4].min() < 11.5
    assert -rows[:, 4].min() == pytest.approx(20.0, abs=0.7)


def test_do_set_home_moves_home_in_mid_mission(copter):
    lat, lon, _ = place(30.0, 0.0, 0.0)
    fly(
        copter,
        *(
            TAKEOFF,
            waypoint(30.0, 0.0),
            (179, 0, (0, 0, 0, 0, lat, lon, HOME.alt_amsl_m)),
            waypoint(30, 30),
            RETURN,
        ),
        limit_s=240.0,
    )
    assert np.linalg.norm(copter.here[:2] - copter.flight.home.position_ned_m[:2]) < 1.0
    assert copter.flight.home.point.lat_deg == pytest.approx(lat, abs=1e-6)


@pytest.mark.parametrize(("restart", "seq"), [(0, 3), (1, 2)])
def test_mis_restart_begins_the_mission_anew(copter, restart, seq):
    copter.airborne()
    copter.say(mavlink.MAVLink_param_set_message(1, 1, b"MIS_RESTART", restart, 9))
    assert copter.upload([do(178, 1, 5.0), waypoint(30.0, 0.0), waypoint(30.0, 80.0)]) == 0
    copter.ask(176, 1, AUTO)
    copter.until(lambda: copter.flight.run.seq == 3, 30.0)
    copter.ask(176, 1, 5)
    copter.live(1.0)
    copter.ask(176, 1, AUTO)
    copter.live(0.1)
    assert copter.flight.run.seq == seq
