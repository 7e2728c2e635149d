"""Shots commanded along the path: each once, lost packets or not, and what was taken is known."""

from types import SimpleNamespace

import numpy as np
import pytest
from fake_flight import Air, fly, make_session
from fake_px4 import FakePx4
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.messages import Command, CommandAck, ImageCaptured
from mavspiral.flight.outcome import State
from mavspiral.flight.px4 import PX4
from mavspiral.flight.shutter import Picture, ShotOrders, Shutter

DUE_S = np.array([6.0, 8.0, 11.0, 20.0, 26.0])


class WithCamera(FakePx4):
    """A vehicle whose camera has an address of its own and takes each number once."""

    busy_until_s = 0.0

    def __init__(self, *args, deaf_n=0):
        super().__init__(*args)
        self.shots, self.triggers, self.tilts, self.deaf_n = [], [], [], deaf_n
        self.asked = []

    def _on_command_long(self, m):
        if m.target_component == PX4.camera_id:
            if self.deaf_n:
                self.deaf_n -= 1
                return
            if m.command == Command.REQUEST_MESSAGE:
                self._retell(int(m.param1), int(m.param2))
                return
            busy = self._boot_us * 1e-6 < self.busy_until_s
            if not busy and m.param4 not in [number for number, _ in self.shots]:
                self.shots.append((m.param4, self._boot_us * 1e-6))
                self._image()
            ack = mavlink.MAVLink_command_ack_message(m.command, 1 if busy else 0)
            frame = ack.pack(mavlink.MAVLink(None, 1, PX4.camera_id))
            self._out.append(frame)
            return
        super()._on_command_long(m)

    def _retell(self, message_id, index):
        assert message_id == 263
        known = 0 <= index < len(self.shots)
        result = mavlink.MAV_RESULT_ACCEPTED if known else mavlink.MAV_RESULT_DENIED
        self._out.append(
            mavlink.MAVLink_command_ack_message(512, result).pack(mavlink.MAVLink(None, 1, PX4.camera_id))
        )
        self.asked.append(index)
        if known:
            self._tell(index)

    def _image(self):
        self._tell(len(self.shots) - 1)

    def _tell(self, index):
        boot_ms = int(self.shots[index][1] * 1e3)
        self._send(
            mavlink.MAVLink_camera_image_captured_message(
                boot_ms, 0, 0, 0, 0, 0, 0, (1.0, 0.0, 0.0, 0.0), index, 1, b""
            )
        )

    def _command_203(self, m):
        assert m.param5 == 1.0
        self.shots.append((0.0, self._boot_us * 1e-6))
        self._image()
        return 0

    def _command_206(self, m):
        self.triggers.append((self._boot_us * 1e-6, m.param1))
        return 0

    def _command_1000(self, m):
        self.tilts.append(m.param1)
        return 0


@pytest.fixture
def vehicle(px4):
    return WithCamera(px4.origin, px4.position)


def shooting(trigger, gimbal=False):
    return make_session(shots=ShotOrders(trigger, 3.0, gimbal, lambda _: DUE_S))


def due_vehicle_s(session):
    """When path time came to each shot, on the vehicle's clock: from the log."""
    log = session.log()
    on_it = np.isfinite(log.path_t_s)
    return np.interp(DUE_S, log.path_t_s[on_it], log.vehicle_s[on_it])


@pytest.mark.parametrize("trigger", ["camera", "digicam"])
def test_each_shot_is_taken_once_at_its_time_along_the_path(vehicle, trigger):
    session = shooting(trigger)
    fly(session, vehicle)
    taken_s = np.array([t for _, t in vehicle.shots])
    assert len(taken_s) == len(DUE_S)
    assert np.abs(taken_s - due_vehicle_s(session)).max() < 0.06
    assert [p.shot for p in session.pictures] == [0, 1, 2, 3, 4] and session.missed_shots == ()
    assert np.allclose([p.vehicle_s for p in session.pictures], taken_s, atol=0.01)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_on_a_bad_link_no_picture_is_missing_and_none_is_double(vehicle, seed):
    session = shooting("camera")
    fly(session, vehicle, up=Air(seed, loss=0.3), down=Air(seed + 9, loss=0.3))
    assert session.outcome.ok
    assert [number for number, _ in vehicle.shots] == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert sorted(p.shot for p in session.pictures) == [
        0,
        1,
        2,
        3,
        4,
    ]  # one that was asked for again is heard of later


def test_the_last_picture_is_asked_for_when_nothing_was_heard_of_it(vehicle):
    session = shooting("camera")

    def cut(frames):  # nothing of the camera's comes while the last shot is commanded
        unheard = 25.5 < session.path_t_s < 27.5
        return [f for f in frames if not (unheard and (f[6] == PX4.camera_id or f[7:9] == b"\x07\x01"))]

    fly(session, vehicle, down=cut)
    assert session.outcome.ok and vehicle.asked
    assert set(vehicle.asked) == {4}
    assert [p.shot for p in session.pictures] == [0, 1, 2, 3, 4] and session.missed_shots == ()
    assert session.pictures[-1].vehicle_s == pytest.approx(vehicle.shots[-1][1], abs=0.01)


def test_a_last_shot_that_the_camera_denies_is_missed_and_asked_for_once(vehicle):
    session = shooting("camera")

    def deaf(_now_us):
        if 25.5 < session.path_t_s < 26.0:
            vehicle.deaf_n = 4

    fly(session, vehicle, each=deaf)
    assert session.outcome.ok
    assert len(vehicle.shots) == 4 and vehicle.asked == [4]
    assert session.missed_shots == (4,)


def unheard_until(session, path_t_s):
    """Nothing of the camera's comes before that path time."""

    def cut(frames):
        unheard = session.path_t_s < path_t_s
        return [f for f in frames if not (unheard and (f[6] == PX4.camera_id or f[7:9] == b"\x07\x01"))]

    return cut


@pytest.mark.parametrize("before_n", [0, 7])
def test_first_pictures_that_were_never_told_are_asked_for(vehicle, before_n):
    session = shooting("camera")
    vehicle.shots = [(-1.0, 0.5)] * before_n  # on the card already
    fly(session, vehicle, down=unheard_until(session, 10.5))
    assert session.outcome.ok and vehicle.asked[:2] == [before_n + 1, before_n]
    assert sorted(p.shot for p in session.pictures) == [0, 1, 2, 3, 4] and session.missed_shots == ()
    told_s = sorted(p.vehicle_s for p in session.pictures)
    assert told_s == pytest.approx([t for _, t in vehicle.shots[before_n:]], abs=0.01)


def test_a_picture_from_before_the_flight_is_not_taken_for_the_first_shot(vehicle):
    vehicle.shots, vehicle.deaf_n = [(-1.0, 0.5)], 4
    session = shooting("camera")
    fly(session, vehicle)
    assert session.outcome.ok and vehicle.asked == [0]
    assert session.missed_shots == (0,)
    assert "shot 1 was not taken" in [event.text for event in session.events]


def test_a_camera_that_does_not_answer_costs_that_shot_and_it_is_said(vehicle):
    vehicle.deaf_n = 4
    session = shooting("camera")
    fly(session, vehicle)
    assert session.missed_shots == (0,) and session.outcome.ok
    assert "shot 1 was not taken" in [event.text for event in session.events]


def test_on_a_vehicle_that_lives_faster_a_picture_is_its_own_shots_though_its_clock_is_misread():
    """At eight times real time 70 ms of the vehicle's are 9 of ours. The second picture's telling is lost."""
    due_s, taken_s = np.array([1.0, 1.7, 2.4]), np.array([1.0, 1.7, 2.33])
    flight = SimpleNamespace(sampled=lambda _: SimpleNamespace(gimbal_pitch_rad=np.zeros(9)))
    clock = SimpleNamespace(rate=8.0, at=lambda now_us: 8.0 * now_us)
    s = SimpleNamespace(trajectory=flight, clock=clock, profile=PX4, tell=print)
    s.link = SimpleNamespace(command=lambda *words, component=0: b"")
    shutter = Shutter(s, ShotOrders("camera", 0.0, False, lambda _: due_s))
    for index, (shot_s, vehicle_s) in enumerate(zip(due_s, taken_s, strict=True)):
        s.now_us, s.path_t_s = round(shot_s / 8.0 * 1e6), shot_s
        shutter.tick()
        shutter.heard(CommandAck(Command.IMAGE_START_CAPTURE, 0))
        if index != 1:
            shutter.heard(ImageCaptured(round(vehicle_s * 1e3), index, True))
    assert shutter.pictures == [Picture(0, 1.0, 0), Picture(1, 1.7), Picture(2, 2.33, 2)]


def test_a_camera_that_is_busy_is_asked_until_it_is_free(vehicle):
    session = shooting("camera")

    def busy(_now_us):
        if session.path_t_s < 7.2:  # the first shot is due at 6, the second at 8
            vehicle.busy_until_s = vehicle._boot_us * 1e-6 + 0.1

    fly(session, vehicle, each=busy)
    assert session.outcome.ok and session.missed_shots == ()
    assert [number for number, _ in vehicle.shots] == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_the_answer_to_a_repeated_command_is_not_taken_for_that_to_the_next_shot():
    """The first shot is commanded twice and its picture told; the second answer comes when the next was commanded, which is lost."""
    flight = SimpleNamespace(sampled=lambda _: SimpleNamespace(gimbal_pitch_rad=np.zeros(99)))
    clock = SimpleNamespace(rate=1.0, at=lambda now_us: now_us)
    said = []
    s = SimpleNamespace(
        trajectory=flight, clock=clock, profile=PX4, tell=lambda *words: said.append(words[1])
    )
    s.link = SimpleNamespace(command=lambda *words, component=0: b"")
    shutter = Shutter(s, ShotOrders("camera", 0.0, False, lambda _: np.array([1.0, 1.3, 4.0])))
    accepted = CommandAck(Command.IMAGE_START_CAPTURE, 0)
    heard = {
        1.22: [accepted, ImageCaptured(1000, 0, True)],  # late: it was asked again at 1.2
        1.32: [accepted],
        4.02: [accepted, ImageCaptured(4000, 1, True)],
    }
    for tick in range(250):
        path_t_s = round(0.02 * tick, 2)
        s.now_us, s.path_t_s = round(path_t_s * 1e6), path_t_s
        for message in heard.get(path_t_s, ()):
            shutter.heard(message)
        shutter.tick()
    assert [picture.shot for picture in shutter.pictures] == [0, 2]
    assert shutter.missed == (1,) and "shot 2 was not taken" in said


def test_by_distance_it_begins_with_the_first_shot_and_ends_after_the_last(vehicle):
    session = shooting("distance")
    fly(session, vehicle)
    begin_s, *_, end_s = due_vehicle_s(session)
    [(on_s, spacing_m), (off_s, none)] = vehicle.triggers
    assert (spacing_m, none) == (3.0, 0.0)
    assert on_s == pytest.approx(begin_s, abs=0.06) and off_s == pytest.approx(end_s, abs=0.06)


def test_a_flight_that_is_given_up_switches_the_trigger_off(vehicle):
    session = shooting("distance")
    fly(session, vehicle, until=lambda: session.path_t_s > 12)
    session.stop()
    fly(session, vehicle, until=lambda: session.state is State.HOLD)
    session.stop()
    fly(session, vehicle, until=lambda: session.state is State.RETURN)
    fly(session, vehicle, until=lambda: len(vehicle.triggers) > 1, limit_s=3.0)
    assert vehicle.triggers[-1][1] == 0.0


def test_with_none_nothing_is_commanded(vehicle):
    session = shooting("none")
    fly(session, vehicle)
    told = {m.command for _, m in vehicle.commands}
    assert not told & {Command.IMAGE_START_CAPTURE, Command.DO_DIGICAM_CONTROL, Command.DO_SET_CAM_TRIGG_DIST}
    assert not vehicle.shots and session.outcome.ok


def test_the_gimbal_is_levelled_once_where_the_plan_is_level(vehicle):
    session = shooting("none", gimbal=True)
    fly(session, vehicle)
    assert vehicle.tilts == [0.0]
