"""Whole flights of a scripted PX4, on a simulated clock."""

import math

import numpy as np
import pymap3d
import pytest
from fake_flight import (
    PLAN_ORIGIN,
    VEHICLE_ORIGIN,
    Air,
    Helix,
    fly,
    make_session,
    make_trajectory,
    parsed,
    streaming_for,
    texts,
)

from mavspiral.errors import InputError
from mavspiral.flight.messages import MessageId
from mavspiral.flight.outcome import SessionConfig, State


def ned_of_plan(position_enu_m):
    """The plan's positions in the vehicle's NED by way of the earth's centre: no code of ours."""
    lat0, lon0, alt0 = PLAN_ORIGIN.lat_deg, PLAN_ORIGIN.lon_deg, PLAN_ORIGIN.alt_amsl_m
    ecef = pymap3d.enu2ecef(*np.moveaxis(np.asarray(position_enu_m), -1, 0), lat0, lon0, alt0)
    return np.stack(pymap3d.ecef2ned(*ecef, *VEHICLE_ORIGIN), axis=-1)


def test_a_warning_of_whoever_drives_it_is_told_with_the_next_step():
    session = make_session()
    session.step(0, b"")
    session.warn("the disk is full")
    assert ("warning", "the disk is full") in [(e.severity, e.text) for e in session.step(20_000, b"").events]
    assert not session.step(40_000, b"").events


def test_a_flight_from_connecting_to_disarming(px4):
    session = make_session()
    fly(session, px4)
    assert session.outcome.ok and session.outcome.exit_code == 0
    states = [event.text for event in session.events if event.text in {s.value for s in State}]
    aside = (
        State.MEASURE,
        State.APPROVE,
        State.CONSENT,
        State.HAND_OVER,
        State.HOLD,
        State.BRAKE,
        State.RETURN,
        State.LEAVE,
        State.OVER,
    )
    assert states == [s.value for s in State if s not in aside]
    assert not px4.armed and px4.armed_height_m == pytest.approx(0.0, abs=0.06)
    assert [t for t in texts(session).split(" | ") if t.startswith("leg")] == [
        "leg approach-1",
        "leg inspection",
        "leg return-1",
    ]


def test_positions_reach_the_vehicle_in_its_own_frame(px4):
    """Plan, vehicle's origin and home are three places at three heights; every setpoint is compared."""
    session = make_session()
    fly(session, px4)
    assert math.dist((0, 0, 0), ned_of_plan([0, 0, 0])) > 40
    begin_s, end_s = session.trajectory.span_s("inspection")
    sent = np.array([(m.x, m.y, m.z, m.vx, m.vy, m.vz, m.yaw) for _, m in px4.setpoints])
    on_helix = ned_of_plan(Helix()(np.linspace(0, Helix.u_end_rad, 20_000)))
    stream = sent[-round(session.trajectory.duration_s * 50) :][int(begin_s * 50) : int(end_s * 50)]
    off_m = np.array([np.linalg.norm(on_helix - p, axis=1).min() for p in stream[100:-100:50, :3]])
    assert off_m.max() < 0.02
    east, north = stream[:, 1], stream[:, 0]
    centre = ned_of_plan([20, 0, 0])
    inward = np.arctan2(centre[1] - east, centre[0] - north)
    assert np.abs(np.angle(np.exp(1j * (stream[:, 6] - inward)))).max() < 0.02, "the nose looks inward"
    finite_difference = np.diff(stream[:, :3], axis=0) / 0.02
    assert np.abs(finite_difference - (stream[1:, 3:6] + stream[:-1, 3:6]) / 2).max() < 0.02


def test_it_takes_off_to_the_first_point_s_height_above_sea_level(px4):
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.PRESTREAM)
    [takeoff] = [m for _, m in px4.commands if m.command == 22]
    first = session.trajectory(0.0).position_enu_m
    assert takeoff.param7 == pytest.approx(PLAN_ORIGIN.alt_amsl_m + first[2], abs=0.01)
    assert first == pytest.approx(session.log().estimate_position_enu_m[0] + [0, 0, 20], abs=0.01)


def test_the_join_is_smooth_and_no_setpoint_is_a_placeholder(px4):
    px4.wind_ned_mps = (0.12, -0.1, 0.0)  # carries the hover away from above home
    session = make_session()
    fly(session, px4, until=streaming_for(session, 5))
    sent = np.array([(m.x, m.y, m.z, m.vx, m.vy, m.vz) for _, m in px4.setpoints])
    steps = np.linalg.norm(np.diff(sent[:, :3], axis=0), axis=1)
    assert steps.max() < 0.06
    assert np.linalg.norm(sent[0, :3] - px4.track[0][1]) > 15, "the first is where it hovers"
    assert np.abs(np.diff(sent[:, 3:], axis=0)).max() < 0.1
    assert all(m.type_mask == 0 and m.coordinate_frame == 1 for _, m in px4.setpoints)


def test_the_first_setpoint_is_where_it_hovers_as_it_looks(px4):
    px4.wind_ned_mps = (0.12, -0.1, 0.0)
    session = make_session()
    fly(session, px4, until=lambda: px4.setpoints)
    first = px4.setpoints[0][1]
    assert (first.x, first.y, first.z) == pytest.approx(tuple(px4.position), abs=0.02)
    assert first.yaw == pytest.approx(px4.yaw, abs=1e-6)


def test_setpoints_flow_a_second_before_offboard_and_at_fifty_hertz(px4):
    session = make_session()
    fly(session, px4)
    first_us = px4.setpoints[0][0]
    asked_us = next(t for t, m in px4.commands if m.command == 176 and m.param2 == 6)
    assert asked_us - first_us >= 0.98e6
    assert session.figures.rate_hz == pytest.approx(50.0)
    assert session.figures.worst_gap_s == pytest.approx(0.02)
    assert session.figures.sent_n == len(px4.setpoints)


NEEDED = {"LOCAL_POSITION_NED", "ATTITUDE", "EXTENDED_SYS_STATE", "GPS_RAW_INT", "SYS_STATUS"}


def test_only_the_telemetry_that_is_needed_remains(px4):
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.ARM)
    assert px4.intervals_us.keys() == NEEDED
    assert px4.intervals_us["LOCAL_POSITION_NED"] == pytest.approx(20_000)


@pytest.mark.parametrize("seed", [4, 5])
def test_telemetry_is_asked_for_until_it_has_taken(px4, seed):
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.ARM, up=Air(seed, loss=0.5))
    assert px4.intervals_us.keys() == NEEDED


def test_path_time_is_the_vehicle_s_time_when_it_keeps_up(px4):
    session = make_session()
    fly(session, px4)
    log = session.log()
    on = np.isfinite(log.path_t_s) & (log.path_t_s < session.trajectory.duration_s)
    assert (log.governor_rate[on] == 1.0).all()
    assert np.ptp(log.vehicle_s[on] - log.path_t_s[on]) < 1e-6
    row = np.flatnonzero(log.on_leg("inspection"))[500]
    want = session.trajectory(log.path_t_s[row])
    assert log.reference_position_enu_m[row] == pytest.approx(want.position_enu_m, abs=1e-4)
    assert log.reference_velocity_enu_mps[row] == pytest.approx(want.velocity_enu_mps, abs=1e-3)
    assert math.remainder(log.reference_yaw_enu_rad[row] - want.yaw_enu_rad, math.tau) == pytest.approx(
        0, abs=1e-4
    )


@pytest.mark.parametrize("rate", [0.9, 4.0])
def test_a_vehicle_that_runs_slow_or_fast_is_followed_on_its_own_clock(px4, rate):
    px4.clock_rate = rate
    session = make_session()
    fly(session, px4)
    assert session.outcome.ok
    log = session.log()
    on = np.flatnonzero(log.on_leg("inspection"))[10:-10]
    elapsed_vehicle_s = log.vehicle_s[on[-1]] - log.vehicle_s[on[0]]
    assert log.path_t_s[on[-1]] - log.path_t_s[on[0]] == pytest.approx(elapsed_vehicle_s, rel=0.01)


def test_arming_is_asked_again_until_it_is_granted(px4):
    px4.denies_arming_n = 4
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.TAKEOFF)
    assert sum(m.command == 400 for _, m in px4.commands) == 5


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_third_of_the_packets_lost_doubled_and_overtaken(px4, seed):
    session = make_session()
    down, up = (
        Air(seed, loss=0.3, double=0.3, overtake=0.3),
        Air(seed + 9, loss=0.3, double=0.3, overtake=0.3),
    )
    fly(session, px4, down=down, up=up)
    assert session.outcome.ok, session.outcome
    log = session.log()
    on = log.on_leg("inspection")
    truth = dict(px4.track)
    wanted = ned_of_plan(log.reference_position_enu_m[on])
    error = np.linalg.norm(wanted - [truth[t] for t in log.t_us[on]], axis=1)
    assert error.max() < 0.5


def test_without_an_origin_message_it_is_worked_out_from_two_positions(px4):
    px4.hides_origin = True
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.ARM)
    east, north, up = session.trajectory(0.0).position_enu_m
    n, e, d = ned_of_plan([east, north, up])
    assert (n, e, d) == pytest.approx((px4.position[0], px4.position[1], px4.position[2] - 20), abs=0.05)


@pytest.mark.parametrize("rate_hz", [0.0, 5.0, 200.0, math.nan])
def test_a_rate_out_of_range_is_bad_input(rate_hz):
    with pytest.raises(InputError, match="10 to 100"):
        SessionConfig(rate_hz=rate_hz)


def test_other_rates_are_kept(px4):
    session = make_session(SessionConfig(rate_hz=25.0))
    fly(session, px4)
    assert session.outcome.ok and session.figures.rate_hz == pytest.approx(25.0)


def test_a_dry_run_does_all_but_arm(px4):
    session = make_session(SessionConfig(dry_run=True))
    fly(session, px4)
    assert session.outcome.ok and "dry run" in session.outcome.reason
    assert not px4.armed and not px4.setpoints


def test_the_same_flight_twice_is_equal_to_the_bit(px4):
    taps = []
    for _ in range(2):
        tap = []
        session = make_session(
            route=lambda home: make_trajectory(home, 30.0), tap=lambda *packet, tap=tap: tap.append(packet)
        )
        fly(session, type(px4)(VEHICLE_ORIGIN, (3, 4, 5)))
        taps.append(tap)
    assert taps[0] == taps[1] and len(taps[0]) > 5000


def test_every_wish_is_within_its_own_deadline(px4):
    session = make_session()
    step = session.step(1_000_000, b"")
    assert step.next_due_us <= 1_020_000
    [beat] = parsed(step.send)
    assert beat.get_type() == "HEARTBEAT"


def test_our_heartbeat_is_sent_once_a_second(px4):
    times = []
    session = make_session(
        tap=lambda t, f: times.append(t) if f[5] == 245 and f[7] == MessageId.HEARTBEAT else None
    )
    fly(session, px4)
    assert set(np.diff(times)) == {1_000_000}


def test_a_vehicle_whose_clock_runs_faster_hears_us_once_a_second_of_its_own(px4):
    px4.clock_rate = 8.0
    times = []
    session = make_session(
        tap=lambda t, f: times.append(t) if f[5] == 245 and f[7] == MessageId.HEARTBEAT else None
    )
    fly(session, px4, until=lambda: len(times) > 30)
    assert np.diff(times[10:]).max() <= 140_000  # 1 s / 8, in steps of 20 ms
