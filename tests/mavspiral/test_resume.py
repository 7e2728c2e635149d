"""Flights that were broken off, then resumed by the user: clear of the building all the time, every wall seen in the end."""

from __future__ import annotations

import numpy as np
import pytest
from lockstep import resumed_until_nothing_is_left, together
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.survey.solids import Solids


def pilot_presses_return(_, session, __):
    """AUTO.RTL, from a ground station."""
    if session.path_t_s > 35.0 and session.outcome is None:
        wanted = mavlink.MAVLink_command_long_message(1, 1, 176, 0, 1.0, 4.0, 5.0, 0, 0, 0, 0)
        return wanted.pack(mavlink.MAVLink(None, 255, 190))
    return b""


def cut_for_good(_, session, airs):
    for air in airs:
        air.cut |= session.path_t_s > 30.0


def camera_is_deaf_for_ten_seconds(_, session, airs):
    airs[0].deaf = 30.0 < session.path_t_s < 40.0


def gap_and_then_return(now_us, session, airs):
    airs[0].deaf = 18.0 < session.path_t_s < 21.0
    return pilot_presses_return(now_us, session, airs)


PX4, ARDUPILOT = "px4", "ardupilot"


@pytest.mark.parametrize(
    ("autopilot", "trouble", "ended"),
    [
        (PX4, {"each": pilot_presses_return}, "pilot took over: AUTO.RTL"),
        (PX4, {"faults": ("battery=12%@45s",)}, "flying home"),
        (PX4, {"faults": ("battery=critical@45s",)}, "failsafe took over"),
        (PX4, {"each": cut_for_good}, "link lost"),
        (PX4, {"faults": ("link_loss@50s+20s",)}, "link lost"),
        (ARDUPILOT, {"faults": ("link_loss@90s+20s",), "set_failsafes": True}, "link lost"),
        (PX4, {"each": camera_is_deaf_for_ten_seconds}, "flown, landed, disarmed"),
        (ARDUPILOT, {"each": camera_is_deaf_for_ten_seconds}, "flown, landed, disarmed"),
        (PX4, {"each": gap_and_then_return}, "pilot took over: AUTO.RTL"),
        (PX4, {"loss": 0.5}, "flown, landed, disarmed"),
    ],
    ids=[
        "pilot",
        "battery-home",
        "battery-failsafe",
        "cut",
        "cut-20-s",
        "ardupilot-cut-20-s",
        "camera",
        "ardupilot-camera",
        "gap-and-pilot",
        "half-lost",
    ],
)
def test_resumed_by_the_user_every_wall_is_seen_in_the_end(planned, autopilot, trouble, ended):
    kiosk = planned("kiosk").flown_by(autopilot)
    sessions, truths_enu_m, shots = resumed_until_nothing_is_left(kiosk, seed=3, **trouble)
    assert ended in sessions[0].outcome.reason
    assert len(sessions) >= 2 and all(session.outcome.ok for session in sessions[1:])
    solids = Solids.of_map(kiosk.site.heights)
    for truth_enu_m in truths_enu_m:
        nearest_m = solids.distance_m(truth_enu_m).min()
        if "failsafe" in sessions[0].outcome.reason and truth_enu_m is truths_enu_m[0]:
            # At 4 % PX4 lands where it is, on its way home or not: it must not touch anything, no more can be asked.
            assert nearest_m > kiosk.mission.vehicle.radius_m
        else:
            assert nearest_m >= kiosk.mission.limits.clearance_m
            assert np.linalg.norm(truth_enu_m[-1] - kiosk.home_enu_m) < 3.0
        assert truth_enu_m[-1][2] == pytest.approx(kiosk.home_enu_m[2], abs=0.1), "on the ground"
    assert len(shots[0]) < len(kiosk.shots)
    if not sessions[0].outcome.ok:
        assert kiosk.coverage_from(shots[0]).walls < kiosk.coverage.walls - 0.005
    both = kiosk.coverage_from(together(tuple(shots)))
    assert both.walls == pytest.approx(kiosk.coverage.walls, abs=0.005)
    assert len(shots[0]) + sum(map(len, shots[1:])) >= len(kiosk.shots)
    assert sum(map(len, shots[1:])) < len(kiosk.shots), "what was there was not flown again"
