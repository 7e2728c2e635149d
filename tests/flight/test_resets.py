"""An estimator that resets itself in flight: its position jumps, and the vehicle has not moved."""

import math

import numpy as np
import pymap3d
import pytest
from fake_flight import HOME, VEHICLE_ORIGIN, fly, leaving_first, make_session
from fake_px4 import FakePx4
from pymavlink.dialects.v20 import common as mavlink
from test_doubts import fly_on

from mavspiral.flight.outcome import State
from mavspiral.flight.wishes import Wish

STILL = (0.0, 0.0, 0.0)


class Resets(FakePx4):
    """What it says of its position is `jump_ned_m` beside where it is, and so is where it flies.

    With `frame` that is because its local frame is another, which its origin shows; else it believes it.
    """

    jumps_ned_m, frame, jumps_us, tells_us = STILL, True, 0.0, 0.0

    def reset(self, jump_ned_m, *, frame=True, late_s=0.0, origin_late_s=0.0):
        """The one so much later than the other."""
        self.jumps_ned_m, self.frame = jump_ned_m, frame
        self.jumps_us, self.tells_us = self._boot_us + 1e6 * late_s, self._boot_us + 1e6 * origin_late_s

    @property
    def jump_ned_m(self):
        return self.jumps_ned_m if self._boot_us >= self.jumps_us else STILL

    def _on_set_position_target_local_ned(self, m):
        for axis, jump_m in zip("xyz", self.jump_ned_m, strict=True):
            setattr(m, axis, getattr(m, axis) - jump_m)
        super()._on_set_position_target_local_ned(m)

    def _send_local_position_ned(self):
        is_m, self.position = (
            self.position,
            [a + b for a, b in zip(self.position, self.jump_ned_m, strict=True)],
        )
        super()._send_local_position_ned()
        self.position = is_m

    def _send_gps_global_origin(self):
        lat, lon, alt = self.origin
        if self.frame and self._boot_us >= self.tells_us:
            lat, lon, alt = pymap3d.ned2geodetic(*(-j for j in self.jumps_ned_m), *self.origin)
        self._send(
            mavlink.MAVLink_gps_global_origin_message(round(lat * 1e7), round(lon * 1e7), round(alt * 1e3), 0)
        )


@pytest.fixture
def px4():
    return Resets(VEHICLE_ORIGIN, HOME)


def warned(session):
    return [event.text for event in session.events if event.severity != "info"]


def in_state(session, state):
    """In the middle of it."""
    return lambda: session.state is state and (state is not State.STREAM or session.path_t_s > 20.0)


def flown(px4, session):
    fly_on(session, px4)
    return np.array([place for _, place in px4.track])


def beside_m(track, other):
    """How far a track was from the nearest of another at the most."""
    return max(np.linalg.norm(other - place, axis=1).min() for place in track[::10])


@pytest.fixture(scope="module")
def calm():
    px4, session = Resets(VEHICLE_ORIGIN, HOME), make_session()
    fly(session, px4)
    return np.array([place for _, place in px4.track])


@pytest.mark.parametrize("jump_ned_m", [(0.0, 0.0, 2.0), (0.0, 0.0, -2.0), (-9.0, 6.0, 4.0)])
@pytest.mark.parametrize("origin_late_s", [-0.2, 0.0])
def test_a_frame_that_moves_moves_no_vehicle(px4, calm, jump_ned_m, origin_late_s):
    session = make_session()
    fly(session, px4, until=in_state(session, State.STREAM))
    px4.reset(jump_ned_m, late_s=0.2 if origin_late_s < 0 else 0.0, origin_late_s=max(0.0, origin_late_s))
    px4._send_gps_global_origin()
    track = flown(px4, session)
    assert session.outcome.ok
    moved_m = math.hypot(*jump_ned_m)
    assert warned(session) == [
        f"the vehicle's local frame has moved by {moved_m:.1f} m, not the vehicle; the flight goes on where it was"
    ]
    assert beside_m(track, calm) < 0.6
    assert beside_m(calm, track) < 0.6, "nothing is left out"
    log = session.log()
    assert np.nanmax(np.linalg.norm(np.diff(log.estimate_position_enu_m, axis=0), axis=1)) < 1.0


@pytest.mark.parametrize("state", [State.TAKEOFF, State.HOLD, State.RETURN])
def test_a_frame_that_moves_in_another_part_of_the_flight_moves_no_vehicle_either(px4, calm, state):
    session = make_session()
    if state is not State.TAKEOFF:
        fly(session, px4, until=in_state(session, State.STREAM))
        session.stop()
        fly_on(session, px4, until=lambda: session.state is State.HOLD)
        if state is State.RETURN:
            session.stop()
    else:
        fly(session, px4, until=in_state(session, State.TAKEOFF))
    fly_on(session, px4, until=lambda: session.state is state)
    px4.reset((2.0, -1.0, 2.0))
    now_us = px4.track[-1][0]
    fly_on(session, px4, until=lambda: px4.track[-1][0] > now_us + 3e6)
    session.wish(Wish.GO_ON)
    track = flown(px4, session)
    assert len([text for text in warned(session) if "local frame has moved by 3.0 m" in text]) == 1
    if state is State.RETURN:
        assert session.outcome.reason == "landed, disarmed (stopped by the user; flying home)"
        assert math.dist(track[-1], HOME) < 1.0
    else:
        assert session.outcome.ok
        assert beside_m(track, calm) < 0.6


@pytest.mark.parametrize("down_m", [2.0, -2.0])
def test_a_height_that_is_believed_anew_is_said_so_and_flown_home_with(px4, down_m):
    session = make_session(way_home=leaving_first)
    fly(session, px4, until=in_state(session, State.STREAM))
    begin_us = px4.track[-1][0]
    px4.reset((0.0, 0.0, down_m), frame=False)
    fly_on(session, px4, until=lambda: session.state is State.RETURN)
    assert px4.track[-1][0] - begin_us < 1e6
    track = flown(px4, session)
    assert session.outcome.reason == (
        f"landed, disarmed (its height jumped by {-down_m:+.1f} m: away from the wall and home)"
    )
    assert np.linalg.norm(np.diff(track, axis=0), axis=1).max() < 0.15, "it was not flown after"


def test_a_height_that_jumps_within_the_reserve_is_flown_back(px4):
    session = make_session()
    fly(session, px4, until=in_state(session, State.STREAM))
    px4.reset((0.0, 0.0, 1.3), frame=False)
    flown(px4, session)
    assert session.outcome.ok and not [text for text in warned(session) if "sinks" in text]


def test_a_small_shift_of_the_frame_is_within_the_reserve(px4, calm):
    session = make_session()
    fly(session, px4, until=in_state(session, State.STREAM))
    px4.reset((0.6, 0.0, 0.0))
    px4._send_gps_global_origin()
    track = flown(px4, session)
    assert session.outcome.ok and beside_m(track, calm) < 1.2
    assert warned(session) == ["the vehicle's local origin moved by 0.60 m in flight"]


def test_an_origin_that_moves_alone_in_the_climb_brings_it_down(px4):
    session = make_session()
    fly(session, px4, until=in_state(session, State.TAKEOFF))
    px4.reset((0.0, 0.0, 5.0), late_s=math.inf)
    px4._send_gps_global_origin()
    flown(px4, session)
    assert (
        session.outcome.reason
        == "landed, disarmed (the vehicle's local origin moved by 5.00 m in flight; landing)"
    )
    assert not px4.armed
