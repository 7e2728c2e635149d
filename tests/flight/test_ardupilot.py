"""The session on ArduPilot: the profile's rules, and whole flights against the bundled vehicle's ArduPilot dialect."""

import math

import numpy as np
import pytest
from fake_flight import PLAN_ORIGIN, make_session, make_trajectory
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from mavspiral.flight.autopilots import PROFILES
from mavspiral.flight.outcome import SessionConfig, State
from mavspiral.frames import GeoPoint, LocalFrame
from sitl.airframe import load_airframe
from sitl.params import Params
from sitl.signals import GeoPoint as VehiclePoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

HOME_ENU_M = np.array([-49.0, -69.0, -3.0])  # on ground 3 m below the plan's
BOTH = tuple(PROFILES.values())
GUIDED, LOITER, LAND, RTL = 4, 5, 9, 6


def gentle(home_enu_m):
    """Below 2.5 m/s², which is as much as WPNAV_ACCEL allows."""
    return make_trajectory(home_enu_m, helix_s=50.0)


class Flight:
    """The session on the vehicle's first port and somebody else on its second, on one simulated clock."""

    def __init__(self, config=None, autopilot="ardupilot", profiles=BOTH, home_enu_m=HOME_ENU_M, **vehicle):
        frame = LocalFrame(PLAN_ORIGIN)
        self.to_enu = frame.to_vehicle(frame.geo_point(home_enu_m)).position_enu_m
        point = frame.geo_point(home_enu_m)
        airframe = load_airframe("x500")
        vehicle = {"origin_offset_ned_m": (61.0, -38.0, 9.0), "heading_ned_rad": 0.7} | vehicle
        place = VehiclePoint(point.lat_deg, point.lon_deg, point.alt_amsl_m)
        self.simulator = Simulator(
            SimulatorConfig(VehicleConfig(airframe, Params(airframe.params), place, **vehicle), autopilot)
        )
        self.session = make_session(config, route=gentle, profiles=profiles)
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.now_us, self.said, self.other = 0, b"", b""
        self.events, self.commands, self.setpoints = [], [], []
        self.truth = []
        self.ears = mavlink.MAVLink(None)
        self.ears.robust_parsing = True

    def say(self, message):
        self.other += message.pack(self.mav)

    def command(self, number, *params):
        self.say(mavlink.MAVLink_command_long_message(1, 1, number, 0, *params, *(0.0,) * (7 - len(params))))

    def step(self):
        received, self.said, self.other = (self.said, self.other), b"", b""
        heard, _ = self.simulator.exchange(self.now_us, received)
        step = self.session.step(self.now_us, heard)
        self.events += step.events
        for message in self.ears.parse_buffer(step.send) or []:
            if message.get_type() == "COMMAND_LONG":
                self.commands.append((self.session.state, message.command, message))
            elif message.get_type() == "SET_POSITION_TARGET_LOCAL_NED":
                self.setpoints.append((self.session.state, message))
        self.truth.append((self.now_us, *self.to_enu(self.simulator.truth.position_ned_m)))
        self.said, self.now_us = step.send, step.next_due_us

    def hears(self, holds, for_s=0.5, *, deaf=False):
        """What the second port hears; `deaf`: with the session hung, and nothing sent in its place."""
        ears, heard, until_us = mavlink.MAVLink(None), [], self.now_us + for_s * 1e6
        ears.robust_parsing = True
        while self.now_us < until_us:
            received, self.said, self.other = (b"" if deaf else self.said, self.other), b"", b""
            own, others = self.simulator.exchange(self.now_us, received)
            heard += [message for message in ears.parse_buffer(others) or [] if holds(message)]
            if deaf:
                self.truth.append((self.now_us, *self.to_enu(self.simulator.truth.position_ned_m)))
                self.now_us += 10_000
                continue
            step = self.session.step(self.now_us, own)
            self.events += step.events
            self.said, self.now_us = step.send, step.next_due_us
        return heard

    def until(self, holds, limit_s=300.0):
        while not holds():
            assert self.now_us < limit_s * 1e6, [event.text for event in self.events]
            self.step()
        return self

    def fly(self, limit_s=300.0):
        return self.until(lambda: self.session.outcome is not None, limit_s)

    def states(self, state):
        return lambda: self.session.state is state

    def told(self, words):
        return any(words in event.text for event in self.events)


def worst_off_the_plan_m(flight):
    """By truth, on the inspection."""
    log = flight.session.log()
    truth = np.array(flight.truth)
    at = np.searchsorted(truth[:, 0], log.t_us)
    inspecting = log.on_leg("inspection")
    assert inspecting.any()
    off_m = truth[at, 1:] - log.reference_position_enu_m
    return float(np.linalg.norm(off_m[inspecting], axis=1).max())


@pytest.fixture(scope="module")
def flown():
    return Flight().fly()


def test_it_flies_where_the_plan_says_though_origin_home_ground_and_plan_all_differ(flown):
    assert flown.session.outcome.ok, flown.session.outcome
    origin = flown.simulator.report.origin
    apart_m = LocalFrame(PLAN_ORIGIN).point_enu_m(GeoPoint(origin.lat_deg, origin.lon_deg, origin.alt_amsl_m))
    assert np.linalg.norm(apart_m[:2]) > 20.0
    assert np.linalg.norm(apart_m[:2] - HOME_ENU_M[:2]) > 60.0
    assert abs(apart_m[2] - HOME_ENU_M[2]) > 5.0
    assert worst_off_the_plan_m(flown) < 0.6


def test_which_autopilot_it_is_is_told_by_its_heartbeat(flown):
    assert flown.session.profile is PROFILES["ardupilot"]
    assert flown.told("ArduPilot 4.6.3")
    px4 = Flight(autopilot="px4")
    px4.until(px4.states(State.TELEMETRY), 10.0)
    assert px4.session.profile is PROFILES["px4"]


def test_guided_comes_before_arming_and_arming_is_asked_for_until_it_is_granted(flown):
    arming = [message.command for state, _, message in flown.commands if state is State.ARM]
    assert arming[0] == 176
    assert arming.count(400) > 10  # half a minute of "Need Position Estimate"
    assert not [state for state, number, _ in flown.commands if number == 400 and state is not State.ARM]


def test_the_same_refusal_again_and_again_is_told_once(flown):
    refusals = [event for event in flown.events if "Need Position Estimate" in event.text]
    assert len(refusals) == 1


def test_take_off_is_asked_for_above_home_and_no_position_is_streamed_meanwhile(flown):
    (takeoff, *_) = [message for _, number, message in flown.commands if number == 22]
    assert takeoff.param7 == pytest.approx(20.0, abs=0.3)
    assert {state for state, _ in flown.setpoints} <= {
        State.PRESTREAM,
        State.OFFBOARD,
        State.ALIGN,
        State.STREAM,
        State.LAND,
    }


def test_every_setpoint_holds_position_velocity_acceleration_yaw_and_yaw_rate(flown):
    assert {message.type_mask for _, message in flown.setpoints} == {0}
    streamed = [message for state, message in flown.setpoints if state is State.STREAM]
    assert max(abs(message.yaw_rate) for message in streamed) > 0.1
    assert max(math.hypot(message.afx, message.afy) for message in streamed) > 0.3


def test_the_acceleration_is_the_motions_own_without_what_the_air_takes(flown):
    """ArduPilot would move its target by it."""
    streamed = [message for state, message in flown.setpoints if state is State.STREAM]
    v = np.array([(m.vx, m.vy) for m in streamed])
    a = np.array([(m.afx, m.afy) for m in streamed])
    slope = np.gradient(v, 0.02, axis=0)
    fast = np.linalg.norm(v, axis=1) > 2.0
    along = ((a - slope)[fast] * v[fast]).sum(axis=1) / (v[fast] ** 2).sum(axis=1)
    assert np.quantile(np.abs(along), 0.99) < 0.02


def test_it_lands_in_land_mode_and_disarms(flown):
    landing = [message for state, number, message in flown.commands if state is State.LAND and number == 176]
    assert {message.param2 for message in landing} == {LAND}
    assert not flown.simulator.report.flight.armed


def test_a_home_that_somebody_set_elsewhere_changes_nothing_of_where_it_flies():
    """Heights of a take-off count from home, and home lies 6 m below the ground here."""
    flight = Flight()
    flight.until(lambda: flight.simulator.report.flight.home is not None)
    point = flight.simulator.report.flight.home.point
    flight.command(179, 0, 0, 0, 0, point.lat_deg, point.lon_deg + 2e-4, point.alt_amsl_m - 6.0)
    flight.fly()
    assert flight.session.outcome.ok, flight.session.outcome
    (takeoff, *_) = [message for _, number, message in flight.commands if number == 22]
    assert takeoff.param7 == pytest.approx(26.0, abs=0.3)
    assert worst_off_the_plan_m(flight) < 0.6


def test_telemetry_asked_for_before_it_has_booted_is_asked_for_again():
    flight = Flight()
    flight.until(flight.states(State.ORIGIN), 12.0)
    asked = [message.param1 for _, number, message in flight.commands if number == 511]
    assert asked.count(32) >= 2  # LOCAL_POSITION_NED
    assert not flight.told("did not switch its telemetry")


def test_a_pilot_who_takes_loiter_is_left_alone():
    flight = Flight()
    flight.until(lambda: flight.session.state is State.STREAM and flight.session.path_t_s > 12.0)
    flight.command(176, 1, LOITER)
    flight.fly()
    assert "pilot took over: LOITER" in flight.session.outcome.reason
    sent = len(flight.setpoints)
    for _ in range(100):
        flight.step()
    assert len(flight.setpoints) == sent


def test_the_failsafe_of_a_lost_ground_station_is_told_from_a_pilot():
    flight = Flight()
    flight.say(mavlink.MAVLink_param_set_message(1, 1, b"FS_GCS_ENABLE", 1, 9))
    flight.until(lambda: flight.session.state is State.STREAM and flight.session.path_t_s > 12.0)
    flight.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    flight.fly()
    assert "failsafe took over: RTL" in flight.session.outcome.reason


def checked(*parameters):
    """A flight up to arming on a vehicle with those parameters."""
    flight = Flight(SessionConfig(dry_run=True, safe_height_enu_m=40.0))
    for name, value in parameters:
        flight.say(mavlink.MAVLink_param_set_message(1, 1, name, value, 9))
    return flight.fly(30.0)


def test_what_loss_would_do_is_said_and_so_is_a_return_below_the_building():
    flight = checked()
    assert flight.session.outcome.ok
    assert flight.told("if the link is lost: nothing, it holds where it is")
    assert flight.told("GUID_TIMEOUT = 3 s")
    assert flight.told("RTL_ALT), maybe through the building; set it to 44 or more")


def test_with_safe_parameters_nothing_is_warned_of():
    flight = checked(
        (b"FS_GCS_ENABLE", 1),
        (b"SYSID_MYGCS", 245),
        (b"GUID_TIMEOUT", 0.5),
        (b"RTL_ALT", 6000),
        (b"RTL_CONE_SLOPE", 0),
    )
    assert flight.session.outcome.ok
    assert [event.text for event in flight.events if event.severity == "warning"] == []


# As it boots.
UNSAFE = {
    "GUID_TIMEOUT": 3.0,
    "FS_GCS_ENABLE": 0.0,
    "SYSID_MYGCS": 255.0,
    "RTL_ALT": 1500.0,
    "RTL_CONE_SLOPE": 3.0,
}
SAFE = {
    "GUID_TIMEOUT": 1.0,
    "FS_GCS_ENABLE": 1.0,
    "SYSID_MYGCS": 245.0,
    "RTL_ALT": 4400.0,
    "RTL_CONE_SLOPE": 0.0,
}


def parameters_of(flight):
    """Those that make a lost link safe, as another ground station reads them."""
    for name in SAFE:
        flight.say(mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), -1))
    values = flight.hears(lambda message: message.get_type() == "PARAM_VALUE")
    return {value.param_id: value.param_value for value in values if value.param_id in SAFE}


def test_asked_to_it_sets_what_makes_a_lost_link_safe_and_puts_it_back():
    flight = Flight(SessionConfig(set_failsafes=True, safe_height_enu_m=40.0))
    flight.until(lambda: flight.session.state is State.STREAM and flight.session.path_t_s > 3.0)
    assert parameters_of(flight) == SAFE
    assert not flight.told("if the link is lost: nothing") and not flight.told("maybe through the building")
    flight.fly()
    assert flight.session.outcome.ok
    assert parameters_of(flight) == UNSAFE


def test_with_the_failsafes_set_a_silent_planner_means_return_above_the_building():
    flight = Flight(SessionConfig(set_failsafes=True, safe_height_enu_m=40.0))
    flight.until(lambda: flight.session.state is State.STREAM and flight.session.path_t_s > 12.0)
    began = len(flight.truth)
    messages = flight.hears(lambda message: message.get_type() == "HEARTBEAT", 90.0, deaf=True)
    assert [message.custom_mode for message in messages][-1] == 6
    heights_m = [row[3] for row in flight.truth[began:]]
    assert max(heights_m) > 39.5
    low = np.array([row[1:] for row in flight.truth[began:]])
    over_home_m = np.linalg.norm(low[-1, :2] - HOME_ENU_M[:2])
    assert over_home_m < 1.0 and heights_m[-1] < max(heights_m) - 5.0


def test_a_failsafe_that_listens_to_another_system_is_said():
    assert checked((b"FS_GCS_ENABLE", 1)).told("FS_GCS_ENABLE waits for the heartbeat of system 255")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        (b"WPNAV_SPEED", 100, "WPNAV_SPEED allows 1.00"),
        (b"WPNAV_SPEED_UP", 10, "WPNAV_SPEED_UP allows 0.10"),
        (b"WPNAV_SPEED_DN", 10, "WPNAV_SPEED_DN allows 0.10"),
        (b"WPNAV_ACCEL", 20, "WPNAV_ACCEL allows 0.20"),
    ],
)
def test_a_plan_beyond_the_vehicles_own_limits_is_refused_in_si_units(name, value, words):
    flight = checked((name, value))
    assert not flight.session.outcome.ok
    assert words in flight.session.outcome.reason


def test_another_autopilot_than_the_mission_names_is_said():
    flight = Flight(SessionConfig(dry_run=True, planned_for="PX4")).fly(30.0)
    assert flight.told("the mission was planned for PX4; this is ArduPilot, flown as such")
    assert not Flight(SessionConfig(dry_run=True, planned_for="ArduPilot")).fly(30.0).told("was planned for")


def test_only_the_autopilot_that_was_asked_for_is_flown():
    flight = Flight(profiles=(PROFILES["px4"],)).fly(30.0)
    assert flight.session.outcome.exit_code == 3
    assert "no heartbeat of PX4 in 10 s; an ArduPilot is there" in flight.session.outcome.reason
