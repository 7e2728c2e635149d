"""Whole flights of a scripted PX4, on a simulated clock; and what can go wrong on them."""

import math

import numpy as np
import pymap3d
import pytest
from fake_flight import (
    HOME,
    PLAN_ORIGIN,
    VEHICLE_ORIGIN,
    Air,
    Helix,
    fly,
    make_session,
    make_trajectory,
    split,
)
from fake_px4 import LAND, LOITER, OFFBOARD, POSCTL, RTL
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.errors import InputError, LimitError
from mavspiral.flight.messages import MessageId
from mavspiral.flight.outcome import SessionConfig, State


def texts(session):
    return " | ".join(event.text for event in session.events)


def streaming_for(session, path_s):
    return lambda: session.path_t_s > path_s


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


def test_a_hover_too_far_from_the_first_point_lands(px4):
    session = make_session()
    fly(session, px4, until=lambda: px4.armed_height_m > 5)
    px4.position[0] += 8.0
    fly_on(session, px4)
    assert "it hovers 8.0 m from the first point" in session.outcome.reason and not session.outcome.ok
    assert not px4.armed and not px4.setpoints


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


def test_a_pilot_s_hand_wins_at_once(px4):
    session = make_session()
    fly(session, px4, until=streaming_for(session, 30))
    px4.mode = POSCTL
    end_us = fly_on(session, px4)
    assert (
        not session.outcome.ok
        and session.outcome.reason == "pilot took over: POSCTL; nothing more is sent to the vehicle"
    )
    heard = len(px4.setpoints)
    for k in range(500):
        received = b"".join(px4.step(end_us + k * 10_000, []))
        types = {m.get_type() for m in parsed(session.step(end_us + k * 10_000, received).send)}
        assert types <= {"HEARTBEAT"}
    assert len(px4.setpoints) == heard and px4.mode == POSCTL


def test_a_pilot_s_hand_wins_in_the_climb_and_on_the_way_down(px4):
    px4.mode = POSCTL  # in which it may stand before take-off, but not return to
    session = make_session()
    fly(session, px4, until=lambda: px4.armed_height_m > 5)
    px4.mode = POSCTL
    fly_on(session, px4)
    assert (
        session.outcome.reason == "pilot took over: POSCTL; nothing more is sent to the vehicle"
        and session.outcome.state is State.TAKEOFF
    )

    session, px4 = make_session(), type(px4)(VEHICLE_ORIGIN)
    fly(session, px4, until=lambda: session.state is State.LAND)
    px4.mode = POSCTL  # before our own LAND is seen
    fly_on(session, px4, up=lambda frames: [])
    assert (
        session.outcome.reason == "pilot took over: POSCTL; nothing more is sent to the vehicle"
        and session.outcome.state is State.LAND
    )


def test_the_vehicle_s_own_failsafe_is_told_from_a_pilot(px4):
    session = make_session()
    end_us = fly(session, px4, until=streaming_for(session, 30))
    for k in range(150):  # our packets are lost for a second and a half, its own are not
        received = b"".join(px4.step(end_us + k * 10_000, []))
        session.step(end_us + k * 10_000, received)
    assert px4.mode == RTL
    fly_on(session, px4, begin_us=end_us + 1_500_000)
    assert session.outcome.reason == "the vehicle's own failsafe took over: AUTO.RTL"
    assert px4.mode == RTL, "nor is it snatched back by resumed setpoints"


def test_a_denied_offboard_lands(px4):
    px4.ignores_offboard = True
    session = make_session()
    fly(session, px4)
    assert not session.outcome.ok and session.outcome.exit_code == 1
    assert "OFFBOARD" in session.outcome.reason
    assert px4.mode == LAND and not px4.armed


def test_an_ack_without_a_heartbeat_to_match_counts_for_nothing(px4):
    px4.ignores_arming = True
    session = make_session()
    fly(session, px4)
    assert session.outcome.state is State.ARM
    assert "did not arm" in session.outcome.reason and "ACCEPTED" in session.outcome.reason
    assert not any(m.command == 22 for _, m in px4.commands)


def test_arming_is_asked_again_until_it_is_granted(px4):
    px4.denies_arming_n = 4
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.TAKEOFF)
    assert sum(m.command == 400 for _, m in px4.commands) == 5


def test_nobody_there(px4):
    px4.mute_heartbeat = True
    session = make_session()
    end_us = fly(session, px4)
    assert session.outcome.exit_code == 3 and "nobody answers" in session.outcome.reason
    assert end_us - 5_000_000 == pytest.approx(10e6, abs=20_000)


def test_a_ground_station_s_heartbeat_is_nobody(px4):
    gcs = mavlink.MAVLink(None, 255, 190)
    px4.mute_heartbeat = True
    beat = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
    session = make_session()
    fly(session, px4, down=lambda frames: [*frames, beat.pack(gcs)], limit_s=12)
    assert "nobody answers" in session.outcome.reason


def test_garbage_between_the_frames_is_counted_and_harmless(px4):
    session = make_session()
    fly(session, px4, down=lambda frames: [b for f in frames for b in (b"\x00garbage\xfd", f)])
    assert session.outcome.ok
    assert session.garbage_n > 1000


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


def test_a_lost_link_is_told_and_ends_the_stream(px4):
    session = make_session()
    end_us = fly(session, px4, until=streaming_for(session, 30))
    speeds = []
    while session.outcome is None:
        end_us += 10_000
        for m in parsed(session.step(end_us, b"").send):
            if m.get_type() == "SET_POSITION_TARGET_LOCAL_NED":
                speeds.append(math.hypot(m.vx, m.vy, m.vz))
    assert session.outcome.exit_code == 3
    assert session.outcome.reason == (
        "link lost: nothing came for 5 s; the vehicle is on its own: Hold (COM_OBL_RC_ACT = 5)"
    )
    assert speeds[0] > 1.5 and speeds[-1] == 0.0, "blind, it has stopped"
    assert len(speeds) == pytest.approx(5 * 50, abs=5)


def test_telemetry_that_comes_back_in_time_goes_on(px4):
    session = make_session()
    end_us = fly(session, px4, until=streaming_for(session, 30))
    for k in range(300):
        sent = session.step(end_us + k * 10_000, b"").send
        px4.step(end_us + k * 10_000, split(sent))
    fly_on(session, px4, begin_us=end_us + 3_000_000)
    assert session.outcome.ok
    path = session.log().path_t_s
    assert (np.diff(path[np.isfinite(path)]) >= 0).all()


def test_wind_that_blows_it_back_slows_the_path_and_does_not_break_the_flight(px4):
    session = make_session()

    begun_us = []

    def gust(now_us):
        if session.path_t_s > 25 and not begun_us:
            begun_us.append(now_us)
        blows = begun_us and now_us < begun_us[0] + 8e6
        px4.wind_ned_mps = (-1.4, 0.0, 0.0) if blows else (0.0, 0.0, 0.0)

    fly(session, px4, each=gust)
    log = session.log()
    on = np.isfinite(log.path_t_s)
    assert session.outcome.ok
    assert log.governor_rate[on].min() == 0.0 and log.governor_rate[on].max() == 1.0
    assert "waiting: the vehicle is" in texts(session) and "going on" in texts(session)
    late_s = np.ptp(log.vehicle_s[on]) - np.ptp(log.path_t_s[on])
    assert late_s > 1.0, "late rather than wrong"


def test_without_an_origin_message_it_is_worked_out_from_two_positions(px4):
    px4.hides_origin = True
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.ARM)
    east, north, up = session.trajectory(0.0).position_enu_m
    n, e, d = ned_of_plan([east, north, up])
    assert (n, e, d) == pytest.approx((px4.position[0], px4.position[1], px4.position[2] - 20), abs=0.05)


def test_an_origin_that_moves_in_flight_sends_it_home(px4):
    session = make_session()
    fly(session, px4, until=streaming_for(session, 30))
    px4.origin = (VEHICLE_ORIGIN[0] + 5e-5, *VEHICLE_ORIGIN[1:])  # 5.5 m north
    fly_on(session, px4)
    assert not session.outcome.ok and "origin moved by 5.5" in session.outcome.reason
    assert session.outcome.state is State.LAND and not px4.armed
    above_home = np.array([*HOME[:2], HOME[2] - 20.0]) - np.array([5.56, 0, 0])  # seen from the new origin
    last = np.array([px4.setpoints[-1][1].x, px4.setpoints[-1][1].y, px4.setpoints[-1][1].z])
    assert np.allclose(last, above_home, atol=0.1), "it flies home in the frame that the vehicle has now"


def test_stop_holds_and_stop_again_flies_home(px4):
    session = make_session()
    end_us = fly(session, px4, until=streaming_for(session, 30))
    session.stop()
    fly_on(session, px4, until=lambda: px4.track[-1][0] > end_us + 10e6)
    assert session.state is State.HOLD and px4.mode == OFFBOARD
    held = np.array([(m.x, m.y, m.z) for _, m in px4.setpoints[-300:]])
    assert np.ptp(held, axis=0).max() == 0.0
    accelerations = [math.hypot(m.afx, m.afy, m.afz) for _, m in px4.setpoints[-600:]]
    assert max(accelerations) < 4.0, "it brakes, it does not jerk to a halt"
    session.stop()
    fly_on(session, px4)
    assert session.outcome.exit_code == 1 and "stopped by the user" in session.outcome.reason
    assert not px4.armed
    last = px4.setpoints[-1][1]
    assert np.allclose((last.x, last.y, last.z), (*HOME[:2], HOME[2] - 20.0), atol=0.2), (
        "by setpoints, above home"
    )
    assert RTL not in px4.modes, "never in a straight line of the autopilot's own"


def test_without_a_safe_way_home_it_lands_where_it_is(px4):
    def refuse(start_enu_m, end_enu_m, yaw_enu_rad):
        raise LimitError("walls all round")

    session = make_session(way_home=refuse)
    fly(session, px4, until=streaming_for(session, 30))
    session.stop()
    fly_on(session, px4, until=lambda: session.state is State.HOLD)
    session.stop()
    fly_on(session, px4)
    assert (
        session.outcome.reason
        == "landed, disarmed (stopped by the user; flying home; walls all round; landing)"
    )
    assert not px4.armed


def test_a_vehicle_that_does_not_follow_is_landed(px4):
    session = make_session(SessionConfig(follow_within_s=5.0))
    fly(session, px4, until=streaming_for(session, 30))
    px4.stuck = True
    fly_on(session, px4)
    assert session.outcome.state is State.LAND and "off its path" in session.outcome.reason
    assert not px4.armed


def test_stop_on_the_ground_and_in_the_climb(px4):
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.ORIGIN)
    session.stop()
    fly_on(session, px4)
    assert session.outcome.reason == "stopped before take-off"
    session, px4 = make_session(), type(px4)(VEHICLE_ORIGIN, (0, 0, 0))
    fly(session, px4, until=lambda: px4.armed_height_m > 5)
    session.stop()
    fly_on(session, px4)
    assert session.outcome.state is State.LAND and not session.outcome.ok
    assert not px4.setpoints and not px4.armed


def test_stop_while_arming_leaves_no_armed_vehicle_behind(px4):
    session = make_session()
    fly(session, px4, until=lambda: px4.armed)
    session.stop()
    end_us = fly_on(session, px4)
    assert session.outcome.state is State.ARM
    px4.step(end_us + 20_000, split(session.step(end_us + 20_000, b"").send))
    assert not px4.armed


@pytest.mark.parametrize("rate_hz", [0.0, 5.0, 200.0, math.nan])
def test_a_rate_out_of_range_is_bad_input(rate_hz):
    with pytest.raises(InputError, match="10 to 100"):
        SessionConfig(rate_hz=rate_hz)


def test_other_rates_are_kept(px4):
    session = make_session(SessionConfig(rate_hz=25.0))
    fly(session, px4)
    assert session.outcome.ok and session.figures.rate_hz == pytest.approx(25.0)


def test_a_refused_route_is_told_in_its_own_words(px4):
    def refuse(home_enu_m):
        raise LimitError("the approach passes 1.2 m from the tower; move home east")

    session = make_session(route=refuse)
    fly(session, px4)
    assert session.outcome.reason == "the approach passes 1.2 m from the tower; move home east"
    assert session.outcome.exit_code == 1 and not px4.armed


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda p: p.parameters.update(MPC_XY_VEL_MAX=1.0), "MPC_XY_VEL_MAX allows 1.00"),
        (lambda p: setattr(p, "battery_pct", 12), "battery at 12 %"),
        (lambda p: setattr(p, "armed", True), "armed already"),
        (
            lambda p: (setattr(p, "armed", True), p.position.__setitem__(2, -10.0)),
            "change its mode to RTL or LAND",
        ),
    ],
)
def test_what_stands_against_the_flight_is_refused_on_the_ground(px4, spoil, words):
    spoil(px4)
    session = make_session()
    fly(session, px4)
    assert words in session.outcome.reason and session.outcome.state is State.CHECK
    assert not any(m.command == 400 for _, m in px4.commands)


def test_unsafe_or_unknown_loss_behaviour_is_a_warning(px4):
    px4.parameters["COM_OBL_RC_ACT"] = 0
    del px4.parameters["MPC_Z_VEL_MAX_DN"]  # met with silence
    session = make_session()
    fly(session, px4, until=lambda: session.state is State.ARM)
    warnings = [event.text for event in session.events if event.severity == "warning"]
    assert any("Position mode" in text and "COM_OBL_RC_ACT = 0" in text for text in warnings)
    assert any("MPC_Z_VEL_MAX_DN could not be read" in text for text in warnings)


def test_a_dry_run_does_all_but_arm(px4):
    session = make_session(SessionConfig(dry_run=True))
    fly(session, px4)
    assert session.outcome.ok and "dry run" in session.outcome.reason
    assert not px4.armed and not px4.setpoints


def test_a_vehicle_that_disarms_in_flight_is_not_called_a_success(px4):
    session = make_session()
    fly(session, px4, until=streaming_for(session, 30))
    px4.armed = False
    fly_on(session, px4)
    assert session.outcome.reason == "the vehicle disarmed by itself"


def test_a_stall_of_ours_makes_no_burst_and_no_leap(px4):
    session = make_session()
    end_us = fly(session, px4, until=streaming_for(session, 30))
    before_s = session.path_t_s
    px4.step(end_us + 700_000, [])
    sent = parsed(session.step(end_us + 700_000, b"".join(px4.step(end_us + 700_000, []))).send)
    assert [m.get_type() for m in sent].count("SET_POSITION_TARGET_LOCAL_NED") == 1
    assert session.path_t_s - before_s <= 0.101
    assert session.figures.worst_gap_s == pytest.approx(0.7, abs=0.03)
    assert "no setpoint went out for 0.7" in texts(session)


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


def test_the_mode_it_stood_in_before_take_off_is_no_pilot(px4):
    px4.mode = POSCTL
    session = make_session()
    fly(session, px4)
    assert session.outcome.ok
    assert LOITER not in (px4.mode,)


def fly_on(session, px4, begin_us=None, until=None, up=lambda frames: frames):
    """Go on flying from where `px4` is."""
    now_us, received = begin_us or px4.track[-1][0], b""
    limit_us = now_us + 300e6
    while now_us < limit_us:
        now_us += 10_000
        received = b"".join(px4.step(now_us, up(split(session.step(now_us, received).send))))
        if session.outcome or (until and until()):
            return now_us
    raise AssertionError(f"still in {session.state}: {session.events[-5:]}")


def parsed(stream):
    return mavlink.MAVLink(None).parse_buffer(stream) or []


def test_a_battery_that_would_not_last_for_the_way_home_ends_the_inspection(px4):
    session = make_session(SessionConfig(safe_height_enu_m=45.0))

    def drains(now_us):
        if session.path_t_s > 0:
            px4.battery_pct = round(90 - 1.5 * session.path_t_s)

    fly(session, px4, each=drains)
    _, end_s = session.trajectory.span_s("inspection")
    told = next(event for event in session.events if "battery at" in event.text)
    assert "flying home" in told.text and not session.outcome.ok and not px4.armed
    left_pct = int(told.text.split(" %")[0].split()[-1])
    assert 7 < left_pct < 85
    assert session.log().path_t_s[np.isfinite(session.log().path_t_s)].max() < end_s


def test_a_battery_that_lasts_is_no_reason_to_return(px4):
    session = make_session(SessionConfig(safe_height_enu_m=45.0))

    def drains(now_us):
        if session.path_t_s > 0:
            px4.battery_pct = round(90 - 0.3 * session.path_t_s)

    fly(session, px4, each=drains)
    assert session.outcome.ok and px4.battery_pct < 80
