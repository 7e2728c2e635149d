"""What can go wrong on a flight of a scripted PX4, and how it ends then; on a simulated clock."""

import math

import numpy as np
import pytest
from fake_flight import (
    HOME,
    VEHICLE_ORIGIN,
    fly,
    make_session,
    parsed,
    split,
    streaming_for,
    texts,
)
from fake_px4 import LAND, LOITER, OFFBOARD, POSCTL, RTL
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.errors import LimitError
from mavspiral.flight.outcome import SessionConfig, State


def test_a_hover_too_far_from_the_first_point_lands(px4):
    session = make_session()
    fly(session, px4, until=lambda: px4.armed_height_m > 5)
    px4.position[0] += 8.0
    fly_on(session, px4)
    assert "it hovers 8.0 m from the first point" in session.outcome.reason and not session.outcome.ok
    assert not px4.armed and not px4.setpoints


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
