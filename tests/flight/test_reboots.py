"""A vehicle whose clock jumps, or begins anew with all the rest of it."""

import pytest
from fake_flight import HOME, VEHICLE_ORIGIN, fly, make_session
from fake_px4 import LOITER, FakePx4
from pymavlink.dialects.v20 import common as mavlink
from test_doubts import fly_on, until_path

from mavspiral.flight.outcome import SessionConfig, State


class Reboots(FakePx4):
    """When it is told to, at once; what it says then is all that it says by itself."""

    boots = True  # and says so

    def reboot(self):
        self._boot_us, self._due_us, self.setpoints = 0.0, {}, []
        self.mode, self.armed = LOITER, False
        self.status = mavlink.MAV_STATE_BOOT if self.boots else mavlink.MAV_STATE_STANDBY


@pytest.fixture
def vehicle():
    return Reboots(VEHICLE_ORIGIN, HOME)


def told(session, words):
    return [event.text for event in session.events if words in event.text]


@pytest.mark.parametrize("boots", [True, False])
@pytest.mark.parametrize("state", [State.TAKEOFF, State.STREAM, State.LAND])
def test_a_reboot_in_the_air_is_said_and_is_no_landing(vehicle, state, boots):
    vehicle.boots = boots
    session = make_session()
    fly(session, vehicle, until=lambda: session.state is state and vehicle.armed_height_m > 3.0)
    vehicle.reboot()
    if not boots:
        vehicle._due_us["HEARTBEAT"] = 0.5e6
    setpoints_n, begin_us = len(vehicle.setpoints), vehicle.track[-1][0]
    fly_on(session, vehicle)
    assert "the vehicle has rebooted in flight" in session.outcome.reason
    assert session.outcome.exit_code == 1 and not session.outcome.ok
    assert vehicle.track[-1][0] - begin_us < 0.3e6
    assert len(vehicle.setpoints) - setpoints_n < 10


def test_a_reboot_while_a_word_is_awaited_ends_it_on_the_ground(vehicle):
    session = make_session(SessionConfig(question="arm it"))
    fly(session, vehicle, until=lambda: session.state is State.CONSENT and vehicle._boot_us > 8e6)
    vehicle.reboot()
    fly_on(session, vehicle)
    assert session.outcome.reason == (
        "the vehicle has rebooted (its clock went back by 8 s); begin again once it is ready"
    )


def test_a_clock_that_jumps_forward_is_said_and_moves_no_path_time(vehicle):
    session = make_session()
    fly(session, vehicle, until=until_path(session, 20))
    before_s = session.path_t_s
    vehicle._boot_us += 3600e6
    now_us = vehicle.track[-1][0]
    fly_on(session, vehicle, until=lambda: vehicle.track[-1][0] > now_us + 1e6)
    assert session.path_t_s - before_s == pytest.approx(1.0, abs=0.15)
    fly_on(session, vehicle)
    assert session.outcome.ok
    assert told(session, "clock") == ["the vehicle's clock jumped by 3600.0 s; the flight goes on as it was"]
