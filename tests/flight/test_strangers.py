"""Vehicles that do what ours do not: what the pilot is told of them, and that the flight ends well."""

import math
from itertools import pairwise

import pytest
from fake_flight import HOME, VEHICLE_ORIGIN, fly, make_session
from fake_px4 import LOITER, TAKEOFF, FakePx4
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega
from pymavlink.dialects.v20 import common as mavlink
from test_ardupilot import Flight
from test_shutter import DUE_S, WithCamera, shooting

from mavspiral.flight.ardupilot import ARDUPILOT
from mavspiral.flight.outcome import SessionConfig, State
from mavspiral.flight.px4 import PX4
from mavspiral.flight.upload import Upload


def words(session, severity="warning"):
    return [event.text for event in session.events if event.severity == severity]


class TellsNoAttitude(FakePx4):
    def _send_attitude(self):
        pass


def test_one_that_tells_no_attitude_is_flown_home_looking_as_it_was_told():
    px4, session = TellsNoAttitude(VEHICLE_ORIGIN, HOME), make_session()
    stops = [lambda: session.path_t_s > 10.0, lambda: session.state is State.HOLD]

    def each(_now_us):
        if stops and stops[0]():
            stops.pop(0)
            session.stop()

    fly(session, px4, each=each)
    assert session.outcome.reason == "landed, disarmed (stopped by the user; flying home)"
    yaws = [message.yaw for _, message in px4.setpoints]
    assert all(map(math.isfinite, yaws))
    turns = [abs((b - a + math.pi) % math.tau - math.pi) for a, b in pairwise(yaws)]
    assert max(turns) < 0.05


class TellsItsOriginAgain(FakePx4):
    """Every second, with the last digit flickering, `creeps_deg` further each time."""

    creeps_deg, told_n = 0.0, 0

    def _stream(self):
        super()._stream()
        self._periodic("GPS_GLOBAL_ORIGIN", 1e6)

    def _send_gps_global_origin(self):
        self.told_n += 1
        lat, lon, alt = self.origin
        north = round((lat + self.creeps_deg * self.told_n) * 1e7) + self.told_n % 2
        where = (north, round(lon * 1e7), round(alt * 1e3))
        self._send(mavlink.MAVLink_gps_global_origin_message(*where, 0))


def test_an_origin_that_flickers_is_no_news():
    px4, session = TellsItsOriginAgain(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4)
    assert session.outcome.ok
    assert words(session) == []


def test_an_origin_that_creeps_is_noticed_by_what_it_has_moved_in_all():
    px4, session = TellsItsOriginAgain(VEHICLE_ORIGIN, HOME), make_session()
    px4.creeps_deg = 4e-7  # 4 cm a second
    fly(session, px4)
    assert "local origin moved by" in session.outcome.reason
    assert "flying home" in session.outcome.reason and not px4.armed


class AnswersSlowly(FakePx4):
    """Tells one parameter every two seconds."""

    def __init__(self, *args):
        super().__init__(*args)
        self.asked, self.answers_us = [], 0.0

    def _on_param_request_read(self, m):
        if all(m.param_id != other.param_id for other in self.asked):
            self.asked.append(m)

    def _stream(self):
        super()._stream()
        known = [m for m in self.asked if m.param_id in self.parameters]
        if known and self._boot_us >= self.answers_us:
            self.answers_us = self._boot_us + 2e6
            self.asked.remove(known[0])
            super()._on_param_request_read(known[0])


def test_one_that_tells_its_parameters_slowly_is_waited_for():
    px4, session = AnswersSlowly(VEHICLE_ORIGIN, HOME), make_session()
    px4.parameters["MPC_Z_VEL_MAX_DN"] = 0.1
    fly(session, px4)
    assert "MPC_Z_VEL_MAX_DN allows 0.10" in session.outcome.reason
    assert session.outcome.state is State.CHECK and not words(session)


def beside(system_id, component_id, *heartbeat):
    """Puts somebody else's heartbeat before the vehicle's own words, twice a second."""
    mav = mavlink.MAVLink(None, system_id, component_id)
    count = iter(range(10**9))

    def down(frames):
        return ([mav.heartbeat_encode(*heartbeat).pack(mav)] if next(count) % 25 == 0 else []) + frames

    return down


GIMBAL, ROVER, QUADROTOR = 26, 10, 2
ARDUPILOTMEGA = 3


@pytest.mark.parametrize(
    "stranger",
    [
        (1, 154, GIMBAL, ARDUPILOTMEGA, 0, 0, 4),  # a gimbal that says it is an ArduPilot
        (2, 1, ROVER, ARDUPILOTMEGA, 0, 0, 4),
        (1, 191, 18, 8, 0, 0, 4),  # a companion of our own component id
        (245, 191, 18, 8, 0, 0, 4),  # ourselves, by an echo
        (255, 190, 6, 8, 0, 0, 4),
        (100, 156, 27, 8, 0, 0, 4),
    ],
)
def test_who_else_speaks_first_is_not_taken_for_the_vehicle(px4, stranger):
    session = make_session(profiles=(PX4, ARDUPILOT))
    fly(session, px4, down=beside(*stranger), until=lambda: session.state is State.TAKEOFF)
    assert px4.armed and words(session) == []


def test_a_second_copter_on_the_link_is_said_and_which_of_them_flies(px4):
    session = make_session(profiles=(PX4, ARDUPILOT))
    down = beside(2, 1, QUADROTOR, ARDUPILOTMEGA, 0, 0, 3)
    fly(session, px4, until=lambda: session.state is State.IDENTIFY)
    fly(session, px4, down=down, until=lambda: session.state is State.ARM)
    assert words(session) == [
        "another copter is on this link (system 2); this flight is system 1's: "
        "if that is the wrong one, --system names the other"
    ]


def test_the_one_of_several_copters_that_is_named_is_flown(px4):
    session = make_session(SessionConfig(system_id=1), profiles=(PX4, ARDUPILOT))
    down = beside(2, 1, QUADROTOR, ARDUPILOTMEGA, 0, 0, 3)
    fly(session, px4, down=down, until=lambda: session.state is State.TAKEOFF)
    assert px4.armed and session.profile is PX4 and words(session) == []


def test_one_that_is_named_and_not_there_is_said_and_who_is(px4):
    session = make_session(SessionConfig(system_id=7))
    fly(session, px4)
    assert session.outcome.exit_code == 3 and not px4.commands
    assert session.outcome.reason == (
        "nobody answers: no heartbeat of system 7 as PX4 in 10 s; system 1 is there: --system names another"
    )


def test_a_plan_is_uploaded_to_the_one_of_several_that_is_named():
    upload = Upload({}, None, system_id=2)
    for number, system in enumerate((1, 3, 2)):
        upload.step(1_000_000 * number, beat_of(mavlink.MAVLink(None, system, 1), QUADROTOR))
        assert upload._link.vehicle == ((2, 1) if system == 2 else None)


def test_a_rover_alone_is_named_as_what_it_is(px4):
    session = make_session(profiles=(PX4, ARDUPILOT))
    rover = beside(2, 1, ROVER, ARDUPILOTMEGA, 0, 0, 4)
    fly(session, px4, down=lambda _: rover([]))
    assert "no multicopter (MAV_TYPE 10)" in session.outcome.reason and session.outcome.exit_code == 3


RENAMED = {  # ArduPilot 4.7: name before, and how many of its units are one of the new
    "WP_SPD": ("WPNAV_SPEED", 100),
    "WP_SPD_UP": ("WPNAV_SPEED_UP", 100),
    "WP_SPD_DN": ("WPNAV_SPEED_DN", 100),
    "WP_ACC": ("WPNAV_ACCEL", 100),
    "RTL_ALT_M": ("RTL_ALT", 100),
    "MAV_GCS_SYSID": ("SYSID_MYGCS", 1),
}
BEFORE = {before: (name, units) for name, (before, units) in RENAMED.items()}


class Renaming:
    """The bundled ArduCopter, with the version and the parameter names of 4.7."""

    def __init__(self, simulator):
        self.simulator, self.values = simulator, {}
        self.to_vehicle, self.to_us = ardupilotmega.MAVLink(None), ardupilotmega.MAVLink(None)
        self.to_vehicle.robust_parsing = self.to_us.robust_parsing = True

    @property
    def truth(self):
        return self.simulator.truth

    def exchange(self, now_us, received):
        ours, others = received
        asked = b"".join(map(self._asked, self.to_vehicle.parse_buffer(ours) or []))
        heard, to_others = self.simulator.exchange(now_us, (asked, others))
        return b"".join(map(self._told, self.to_us.parse_buffer(heard) or [])), to_others

    def _asked(self, m):
        if m.get_type() not in ("PARAM_REQUEST_READ", "PARAM_SET"):
            return bytes(m.get_msgbuf())
        name, units = RENAMED.get(m.param_id, (m.param_id, 1))
        if m.param_id in BEFORE:
            return b""
        if m.get_type() == "PARAM_SET":
            return repacked(m, param_id=name.encode(), param_value=m.param_value * units)
        return repacked(m, param_id=name.encode())

    def _told(self, m):
        if m.get_type() == "AUTOPILOT_VERSION":
            return repacked(m, flight_sw_version=0x040700FF)
        if m.get_type() == "PARAM_VALUE" and m.param_id in BEFORE:
            name, units = BEFORE[m.param_id]
            self.values[name] = m.param_value / units
            return repacked(m, param_id=name.encode(), param_value=self.values[name])
        return bytes(m.get_msgbuf())


def repacked(m, **instead):
    """The message with other values, under its own sender and number."""
    mav = ardupilotmega.MAVLink(None, m.get_srcSystem(), m.get_srcComponent())
    mav.seq = m.get_seq()
    fields = [instead.get(name, getattr(m, name)) for name in m.get_fieldnames()]
    return type(m)(*fields).pack(mav)


def on_4_7(*parameters, **config):
    flight = Flight(SessionConfig(safe_height_enu_m=40.0, **config))
    for name, value in parameters:
        flight.say(ardupilotmega.MAVLink_param_set_message(1, 1, name, value, 9))
    flight.simulator = Renaming(flight.simulator)
    return flight


def test_the_parameters_of_ardupilot_4_7_are_read_in_their_own_units():
    flight = on_4_7((b"FS_GCS_ENABLE", 1), dry_run=True).fly(30.0)
    assert flight.session.outcome.ok and flight.told("ArduPilot 4.7.0")
    assert flight.told("15 m (RTL_ALT_M), maybe through the building; set it to 44 or more")
    assert flight.told("FS_GCS_ENABLE waits for the heartbeat of system 255")
    assert not flight.told("could not be read")


def test_a_plan_too_fast_for_4_7_is_refused():
    flight = on_4_7((b"WPNAV_SPEED", 100), dry_run=True).fly(30.0)
    assert "WP_SPD allows 1.00" in flight.session.outcome.reason


def test_on_4_7_too_what_makes_a_lost_link_safe_is_set():
    flight = on_4_7(set_failsafes=True)
    flight.until(flight.states(State.ARM))
    assert flight.simulator.values["RTL_ALT_M"] == 44.0
    assert flight.simulator.values["MAV_GCS_SYSID"] == 245.0


class TellsTheTimeOfDay(WithCamera):
    """Its pictures have the GPS's time, not the one since it booted: as ArduPilot's CAMERA_FEEDBACK."""

    def _tell(self, index):
        told = ardupilotmega.MAVLink_camera_feedback_message(
            1_790_000_000_000_000 + int(self.shots[index][1] * 1e6), 1, 0, index, 0, 0, *[0.0] * 6, 0
        )
        self._send(told)


@pytest.mark.parametrize("trigger", ["camera", "digicam"])
def test_pictures_in_the_time_of_day_are_placed_when_they_were_commanded(trigger):
    px4, session = TellsTheTimeOfDay(VEHICLE_ORIGIN, HOME), shooting(trigger)
    fly(session, px4)
    taken_s = [at_s for _, at_s in px4.shots]
    assert [picture.shot for picture in session.pictures] == list(range(len(DUE_S)))
    assert [picture.vehicle_s for picture in session.pictures] == pytest.approx(taken_s, abs=0.05)


def test_no_camera_is_said_in_flight(px4):
    session = shooting("camera")
    fly(session, px4)
    assert [text for text in words(session) if "no camera has answered to 3 shots" in text]
    assert session.missed_shots == tuple(range(len(DUE_S)))


def test_a_camera_and_a_gimbal_that_refuse_are_said_once(px4):
    session = shooting("digicam", gimbal=True)
    fly(session, px4)  # UNSUPPORTED is what it answers to all that it does not know
    assert words(session) == [
        "the gimbal refuses to tilt: UNSUPPORTED",
        "the camera refuses to be told to take pictures: UNSUPPORTED",
    ]


class Signs(FakePx4):
    """With a key of its own, deaf to whatever is not signed with it."""

    def __init__(self, *args):
        super().__init__(*args)
        self._mav.signing.secret_key, self._mav.signing.sign_outgoing = b"k" * 32, True

    def step(self, now_us, frames):
        return super().step(now_us, [])


def test_one_that_signs_is_said_to_want_its_key():
    px4, session = Signs(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4, until=lambda: session.state is State.TELEMETRY)
    assert words(session)[0].startswith("the vehicle signs what it says")
    assert len([text for text in words(session) if "--signing" in text]) == 1


class SaysWhy(FakePx4):
    """Denies arming for two reasons, twenty times."""

    denied_n = 0

    def _command_400(self, m):
        self.denied_n += 1
        if self.denied_n > 20:
            return super()._command_400(m)
        for text in (b"Arming denied: Resolve system health failures", b"Preflight Fail: Compass 1 missing"):
            self._send(mavlink.MAVLink_statustext_message(2, text))
        return (
            mavlink.MAV_RESULT_IN_PROGRESS if self.denied_n % 2 else mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        )


def test_each_reason_not_to_arm_is_told_once_and_arming_is_asked_for_until_it_is_granted():
    px4, session = SaysWhy(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4, until=lambda: session.state is State.TAKEOFF)
    assert words(session) == [
        "vehicle: Arming denied: Resolve system health failures",
        "vehicle: Preflight Fail: Compass 1 missing",
    ]


def test_whatever_mode_a_pilot_takes_an_arducopter_is_named():
    nobody_flies_in = {"POSITION", "OF_LOITER", "SYSTEMID", "AUTOROTATE", "TURTLE", "RATE_ACRO"}
    known = {number: name for number, name in mavutil.mode_mapping_acm.items() if name not in nobody_flies_in}
    assert {number: ARDUPILOT.mode_name(number) for number in known} == known


class TellsItsPlaceSeldom(FakePx4):
    """Whatever is asked of it, as on a radio that carries no more."""

    position_hz = 2.0

    def _stream(self):
        self.intervals_us["LOCAL_POSITION_NED"] = 1e6 / self.position_hz
        super()._stream()


def test_one_that_tells_its_place_too_seldom_stays_on_the_ground():
    px4, session = TellsItsPlaceSeldom(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4)
    assert session.outcome.state is State.CHECK and not px4.armed
    assert "its position comes every 0.50 s, less often than every 0.3 s" in session.outcome.reason


def test_five_positions_a_second_are_enough_to_be_flown_by():
    px4, session = TellsItsPlaceSeldom(VEHICLE_ORIGIN, HOME), make_session()
    px4.position_hz = 5.0
    fly(session, px4)
    assert session.outcome.ok
    assert words(session) == ["the vehicle did not switch its telemetry as asked"]


class FindsItsPlaceLate(FakePx4):
    """Half a minute after it has booted."""

    def _send_local_position_ned(self):
        if self._boot_us > 30e6:
            super()._send_local_position_ned()


def test_one_that_finds_its_place_late_is_waited_for():
    px4, session = FindsItsPlaceLate(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4, until=lambda: session.state is State.TAKEOFF)
    assert px4.armed


@pytest.mark.parametrize(("vehicle_type", "component"), [(mavlink.MAV_TYPE_FIXED_WING, 1), (19, 1), (2, 5)])
def test_a_plan_is_uploaded_to_any_vehicle_and_to_no_gimbal(vehicle_type, component):
    """Anybody's plan, for an aeroplane too; a gimbal may speak first, with an autopilot's number."""
    upload = Upload({}, None)
    gimbal, vehicle = mavlink.MAVLink(None, 1, 154), mavlink.MAVLink(None, 1, component)
    upload.step(0, beat_of(gimbal, mavlink.MAV_TYPE_GIMBAL))
    assert upload._link.vehicle is None
    upload.step(1_000_000, beat_of(vehicle, vehicle_type))
    assert upload._link.vehicle == (1, component)


def beat_of(sender, vehicle_type):
    return mavlink.MAVLink_heartbeat_message(vehicle_type, mavlink.MAV_AUTOPILOT_PX4, 0, 0, 4, 3).pack(sender)


class FliesOnAfterTakeOff(FakePx4):
    """COM_TAKEOFF_ACT 1: into the mission that it holds."""

    def __init__(self, *args):
        super().__init__(*args)
        self.parameters |= {"COM_TAKEOFF_ACT": 1, "COM_RCL_EXCEPT": 4, "RTL_CONE_ANG": 0, "RTL_TYPE": 0}
        self.parameters |= {"RTL_RETURN_ALT": 60.0, "COM_LOW_BAT_ACT": 3}

    def _move(self, dt):
        before = self.mode
        super()._move(dt)
        if self.parameters["COM_TAKEOFF_ACT"] and (before, self.mode) == (TAKEOFF, LOITER):
            self.mode = 4 << 16 | 4 << 24


def test_one_that_would_fly_a_mission_of_its_own_after_take_off_stays_on_the_ground():
    px4, session = FliesOnAfterTakeOff(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4)
    assert session.outcome.state is State.CHECK and not px4.armed
    assert (
        "COM_TAKEOFF_ACT = 1: after its take-off it flies a mission that it still holds"
        in session.outcome.reason
    )


def test_that_is_set_for_a_flight_that_sets_failsafes_and_put_back():
    px4, session = (
        FliesOnAfterTakeOff(VEHICLE_ORIGIN, HOME),
        make_session(SessionConfig(set_failsafes=True, safe_height_enu_m=40.0)),
    )
    fly(session, px4)
    assert session.outcome.ok
    assert px4.set_parameters == [("COM_TAKEOFF_ACT", 0), ("COM_TAKEOFF_ACT", 1)]


class TakesOffHigher(FakePx4):
    """To MIS_TAKEOFF_ALT, whatever less it is told."""

    least_m = 0.0

    def _command_22(self, m):
        m.param7 = max(m.param7, self.origin[2] - self.ground_down_m + self.least_m)
        return super()._command_22(m)


@pytest.mark.parametrize(("higher_m", "flies"), [(3.0, True), (9.0, False)])
def test_one_that_takes_off_higher_than_it_is_told_is_joined_from_there_or_landed(higher_m, flies):
    px4, session = TakesOffHigher(VEHICLE_ORIGIN, HOME), make_session()
    px4.least_m = 20.0 + higher_m
    end_us = fly(session, px4)
    assert session.outcome.ok is flies and end_us < 150e6
    if not flies:
        assert "it hovers 8." in session.outcome.reason or "it hovers 9." in session.outcome.reason


def test_a_patience_shorter_than_a_links_hiccup_is_said(px4):
    px4.parameters["COM_OF_LOSS_T"] = 0.1
    session = make_session(SessionConfig(dry_run=True))
    fly(session, px4)
    assert [
        text
        for text in words(session)
        if text.startswith("COM_OF_LOSS_T = 0.1 s: a setpoint that is so late")
    ]


class SpeaksVersion1(FakePx4):
    """In MAVLink 1 only; what is said to it in MAVLink 2 it may not understand."""

    deaf = False

    def _send(self, message):
        self._out.append(message.pack(self._mav, force_mavlink1=True))
        self._mav.seq = (self._mav.seq + 1) % 256

    def step(self, now_us, frames):
        return super().step(now_us, [] if self.deaf else frames)


def test_one_that_speaks_mavlink_1_is_flown():
    px4, session = SpeaksVersion1(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4)
    assert session.outcome.ok and not [text for text in words(session) if "could not be read" not in text]


def test_one_that_answers_nothing_is_said_so_before_it_is_asked_to_arm():
    px4, session = SpeaksVersion1(VEHICLE_ORIGIN, HOME), make_session()
    px4.deaf = True
    end_us = fly(session, px4)
    assert session.outcome.state is State.CHECK and session.outcome.exit_code == 3
    assert "answers nothing that it is asked" in session.outcome.reason
    assert end_us < 35e6


@pytest.mark.parametrize(
    ("home_m", "severity"), [(27.0, "error"), (-33.0, "error"), (-9.0, "warning"), (-3.5, None)]
)
def test_a_home_at_another_height_than_the_mission_has_it_is_told(px4, home_m, severity):
    """It stands 3 m below the plan's ground, and says so: by a datum that is not the plan's."""
    session = make_session(SessionConfig(home_height_enu_m=home_m, dry_run=True))
    fly(session, px4)
    if severity == "error":
        told = [session.outcome.reason]
    else:
        told = [text for text in words(session) if "where the mission has its home" in text]
    assert len(told) == (severity is not None)
    if severity:
        off_m = -3.0 - home_m
        assert f"flown {abs(off_m):.0f} m too {'low' if off_m > 0 else 'high'}" in told[0]
    assert session.outcome.ok is (severity != "error")


@pytest.mark.parametrize(("share", "severity"), [(1.01, None), (0.95, "warning"), (0.8, "error")])
def test_a_flight_that_takes_longer_from_here_than_a_battery_lasts_is_told(px4, share, severity):
    calm = make_session(SessionConfig(dry_run=True))
    fly(calm, px4)
    flight_s = calm.trajectory.duration_s
    session = make_session(SessionConfig(endurance_s=share * flight_s, dry_run=True))
    fly(session, FakePx4(VEHICLE_ORIGIN, HOME))
    told = [session.outcome.reason] if severity == "error" else words(session)
    assert any(f"from here the flight takes {flight_s:.0f} s" in text for text in told) is (
        severity is not None
    )
    assert session.outcome.ok is (severity != "error")


def test_one_that_stands_in_another_country_is_told_so_at_once():
    px4, session = FakePx4((40.05, -1.93, 900.0), HOME), make_session()
    fly(session, px4)
    assert session.outcome.state is State.ORIGIN or session.outcome.state is State.ROUTE
    assert "km away from the building: the wrong mission, or a wrong position" in session.outcome.reason
