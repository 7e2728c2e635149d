"""Vehicles that do what ours do not: what the pilot is told of them, and that the flight ends well."""

import math
from itertools import pairwise

import pytest
from fake_flight import HOME, VEHICLE_ORIGIN, fly, make_session
from fake_px4 import FakePx4
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.ardupilot import ARDUPILOT
from mavspiral.flight.outcome import State
from mavspiral.flight.px4 import PX4


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
        "if that is the wrong one, connect to the other alone"
    ]


def test_a_rover_alone_is_named_as_what_it_is(px4):
    session = make_session(profiles=(PX4, ARDUPILOT))
    rover = beside(2, 1, ROVER, ARDUPILOTMEGA, 0, 0, 4)
    fly(session, px4, down=lambda _: rover([]))
    assert "no multicopter (MAV_TYPE 10)" in session.outcome.reason and session.outcome.exit_code == 3
