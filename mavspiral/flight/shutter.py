"""Camera and gimbal while streaming: each shot and each tilt commanded at its time along the path.

A shot by `camera` is numbered, and commanded again under the same number until its picture is told or the next is due,
so that a lost packet costs no picture and makes no second one. Its answers bear no number: each is taken for that to the
oldest command not yet answered. A camera that is still busy with the shot before is asked until it is free. The camera
numbers its pictures too: a gap in what is told of them is a picture that was taken and whose telling was lost. Behind the
last shot that was told there is no gap: there the camera is asked for its next picture, until it tells or denies it.
Before the first that was told there is none either: if the camera does not count it as its first, it is asked for the one
before, whether that was ours. A shot by `digicam` cannot be numbered and is commanded once. By `distance` the vehicle
itself shoots, from the first shot to the last. With `none` the camera runs by itself, and nothing is counted.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.flight.messages import Command, CommandAck, ImageCaptured, Message, MessageId, Result
from mavspiral.flight.situation import Situation
from mavspiral.motion.trajectory import Trajectory

__all__ = ["Picture", "ShotOrders", "Shutter"]

_AGAIN_US = 200_000
_TRIES_N, _ASKS_N = 4, 25
"""So often a shot is commanded, and its picture asked for after that."""
_REFUSED = frozenset({Result.DENIED, Result.UNSUPPORTED, Result.FAILED})
_SHOOTING = frozenset(
    {Command.IMAGE_START_CAPTURE, Command.DO_DIGICAM_CONTROL, Command.DO_SET_CAM_TRIGG_DIST}
)
_UNTOLD_S = 1.5
"""A shot that was accepted so long ago was taken, told or not."""
_ANSWERS_US = 1_000_000
_EARLY_S = 0.05
"""A picture's time may be a frame before that of its command, as we read the vehicle's clock."""
_ITS_OWN_S = 60.0
"""A picture's time that is so much older, or ahead, is not of the vehicle's clock: ArduPilot's are of the GPS's, a camera's
of its own."""
_SILENT_N = 3
_TILT_EVERY_US = 200_000
_TILT_DEG = 0.5
"""The gimbal is told a tilt that differs by so much from the last that it was told."""
_PITCH_S = 0.1
"""The grid on which the gimbal's pitch along the path is kept."""


@dataclass(frozen=True, slots=True)
class ShotOrders:
    """What the camera is to be told.

    Args:
        trigger: camera, digicam, distance or none.
        spacing_m: between shots by distance.
        gimbal: whether there is one to be tilted.
        due_s: the path times of the shots on a trajectory, `(n,)`, rising.
    """

    trigger: str
    spacing_m: float
    gimbal: bool
    due_s: Callable[[Trajectory], FloatArray]


@dataclass(frozen=True, slots=True)
class Picture:
    """One that was taken: of which shot, when by the vehicle's clock, its number by the camera; -1 where nobody knows."""

    shot: int
    vehicle_s: float
    image_index: int = -1


@dataclass(slots=True)
class _Order:
    """A shot that was commanded and has not been answered."""

    shot: int
    vehicle_s: float
    again_us: int
    tries_n: int = 1
    asks_n: int = 0
    accepted: bool = False


class Shutter:
    """Commands the shots of a flight and counts the pictures.

    Args:
        situation: of the session.
        orders: what to command.
    """

    def __init__(self, situation: Situation, orders: ShotOrders) -> None:
        self.pictures: list[Picture] = []
        self.commanded_n = 0
        self._s = situation
        self._orders = orders
        self._route: Trajectory | None = None
        self._trigger = orders.trigger
        self._due_s: list[float] = []
        self._next_s = math.inf
        self._pitches_deg: list[float] = []
        self._open: list[_Order] = []
        self._unanswered: deque[tuple[int, int]] = deque()
        self._newest: int | None = None
        self._doubted: list[_Order] = []  # before the first picture that was told
        self._before, self._before_due_us, self._before_asks_n = -1, 0, 0
        self._runs = False
        self._answered = True
        self._answers = False  # the camera, to anything
        self._tells_due_us = 0
        self._tilts_due_us = 0
        self._tilt_deg = 0.0
        self._tilted = False

    @property
    def missed(self) -> tuple[int, ...]:
        """The shots that were commanded and never taken."""
        taken = {picture.shot for picture in self.pictures}
        return tuple(shot for shot in range(self.commanded_n) if shot not in taken)

    def tick(self) -> bytes:
        """What camera and gimbal are to be told now."""
        s = self._s
        if s.trajectory is not self._route and s.trajectory is not None:
            self._route = s.trajectory
            self._due_s = list(map(float, self._orders.due_s(s.trajectory)))
            self._look_forward()
            pitches_rad = s.trajectory.sampled(_PITCH_S).gimbal_pitch_rad
            self._pitches_deg = list(map(float, np.degrees(pitches_rad)))
        path_t_s = s.path_t_s
        on_it = path_t_s == path_t_s  # else off the trajectory, NaN
        told = b""
        if self._trigger == "distance":
            told = self._by_distance(on_it and self._due_s[0] <= path_t_s <= self._due_s[-1])
        elif self._trigger != "none":
            if self._doubted:
                told = self._ask_before()
            if self._open:
                told += self._again()
            if path_t_s >= self._next_s:
                told += self._shoot(self.commanded_n)
                self.commanded_n += 1
                self._look_forward()
        if s.now_us >= self._tilts_due_us and on_it and self._orders.gimbal:
            told += self._tilt(path_t_s)
        return told

    def _look_forward(self) -> None:
        due_s, n = self._due_s, self.commanded_n
        self._next_s = due_s[n] if n < len(due_s) else math.inf

    def heard(self, message: Message) -> None:
        """Take in what the camera or the vehicle has answered."""
        if isinstance(message, CommandAck):
            self._acknowledged(message)
        elif isinstance(message, ImageCaptured):
            self._answers = True
            if message.taken and (self._newest is None or message.image_index > self._newest):
                unheard_n = -1 if self._newest is None else message.image_index - self._newest - 1
                self._newest = message.image_index
                self._taken(message.time_boot_ms * 1e-3, unheard_n, message.image_index)
            elif message.taken and self._doubted and message.image_index == self._before:
                self._taken_before(message.time_boot_ms * 1e-3)

    def _acknowledged(self, message: CommandAck) -> None:
        if message.command in _SHOOTING:
            self._answers = True
            if message.result in _REFUSED:
                answer = Result(message.result).name
                self._s.tell_once("warning", f"the camera refuses to be told to take pictures: {answer}")
        if message.command == Command.IMAGE_START_CAPTURE:
            self._answer_to_shot(message.result)
        elif message.command == Command.REQUEST_MESSAGE and message.result in _REFUSED:
            if self._before_asks_n:
                self._deny_doubted()
                return
            for order in self._open[-1:]:
                order.asks_n = _ASKS_N if order.asks_n else 0
        elif message.command == Command.DO_SET_CAM_TRIGG_DIST:
            self._answered = True
        elif message.command == self._s.profile.gimbal(0.0)[0]:
            self._tilted = True
            if message.result in _REFUSED:
                self._s.tell_once("warning", f"the gimbal refuses to tilt: {Result(message.result).name}")

    def _answer_to_shot(self, result: int) -> None:
        """The camera has answered the oldest command that it may yet answer; what came too late was lost."""
        while self._unanswered and self._s.now_us - self._unanswered[0][1] > _ANSWERS_US:
            self._unanswered.popleft()
        shot = self._unanswered.popleft()[0] if self._unanswered else -1
        for order in self._open:
            if order.shot == shot:
                order.accepted |= result == Result.ACCEPTED
                order.tries_n -= result == Result.TEMPORARILY_REJECTED

    def _taken(self, vehicle_s: float, unheard_n: int, image_index: int) -> None:
        """A picture was taken then, and `unheard_n` others since the last that was told; -1 where none was."""
        now_s = self._s.clock.at(self._s.now_us) * 1e-6
        its_own = not now_s - _ITS_OWN_S * self._haste < vehicle_s < now_s + _ITS_OWN_S * self._haste
        if self._orders.trigger == "distance":
            self.pictures.append(Picture(-1, now_s if its_own else vehicle_s, image_index))
            return
        before = [
            order for order in self._open if its_own or order.vehicle_s <= vehicle_s + _EARLY_S * self._haste
        ]
        if not before:
            return
        *earlier, this = before
        for order in earlier:
            self._open.remove(order)
            if order.accepted or (unheard_n > 0 and order in earlier[-unheard_n:]):
                self.pictures.append(Picture(order.shot, order.vehicle_s))
            elif unheard_n < 0 and self._newest:
                self._doubted.append(order)
                self._before = self._newest - 1
            else:
                self._s.tell("warning", f"shot {order.shot + 1} was not taken")
        self._open.remove(this)
        self.pictures.append(Picture(this.shot, this.vehicle_s if its_own else vehicle_s, image_index))

    @property
    def _haste(self) -> float:
        """How many of its seconds one of ours may be: a clock that runs faster is read so much more coarsely."""
        return max(1.0, self._s.clock.rate)

    def _ask_before(self) -> bytes:
        if not self._doubted or self._s.now_us < self._before_due_us:
            return b""
        if self._before_asks_n >= _ASKS_N:
            self._deny_doubted()
            return b""
        self._before_due_us = self._s.now_us + _AGAIN_US
        self._before_asks_n += 1
        return self._asked(self._before)

    def _taken_before(self, vehicle_s: float) -> None:
        """The picture before the first that was told was taken then: ours, or one that was on the card already."""
        ours = [order for order in self._doubted if order.vehicle_s <= vehicle_s + _EARLY_S * self._haste]
        if ours:
            self.pictures.append(Picture(ours[-1].shot, vehicle_s, self._before))
            self._doubted.remove(ours[-1])
        if self._before == 0 or len(ours) < 2:
            self._deny_doubted()
            return
        self._before, self._before_asks_n, self._before_due_us = self._before - 1, 0, 0

    def _deny_doubted(self) -> None:
        for order in self._doubted:
            self._s.tell("warning", f"shot {order.shot + 1} was not taken")
        self._doubted, self._before_asks_n = [], 0

    def _shoot(self, shot: int) -> bytes:
        s = self._s
        if shot == _SILENT_N and not self._answers:
            words = f"no camera has answered to {_SILENT_N} shots: is it on, and does it do what the mission's trigger asks?"
            s.tell("warning", words)
        self._open.append(_Order(shot, s.clock.at(s.now_us) * 1e-6, s.now_us + _AGAIN_US))
        return self._commanded(shot)

    def _again(self) -> bytes:
        if self._orders.trigger == "digicam":
            return b""
        self._settle()
        if not self._open:
            return b""
        newest = self._open[-1]
        if self._s.now_us < newest.again_us:
            return b""
        newest.again_us = self._s.now_us + _AGAIN_US
        if newest.tries_n < _TRIES_N:
            newest.tries_n += 1
            return self._commanded(newest.shot)
        if self._newest is None or newest.asks_n >= _ASKS_N:
            return b""
        newest.asks_n += 1
        return self._asked(self._newest + 1)

    def _asked(self, image_index: int) -> bytes:
        what = (MessageId.CAMERA_IMAGE_CAPTURED, float(image_index))
        return self._s.link.command(Command.REQUEST_MESSAGE, *what, component=self._s.profile.camera_id)

    def _settle(self) -> None:
        """A shot that was accepted long ago was taken, though nobody told: we know when it was commanded."""
        now_s = self._s.clock.at(self._s.now_us) * 1e-6
        for order in tuple(self._open):
            if order.accepted and now_s - order.vehicle_s > _UNTOLD_S * self._haste:
                self._open.remove(order)
                self.pictures.append(Picture(order.shot, order.vehicle_s))

    def _commanded(self, shot: int) -> bytes:
        if self._orders.trigger == "digicam":
            return self._s.link.command(Command.DO_DIGICAM_CONTROL, 0.0, 0.0, 0.0, 0.0, 1.0)
        self._unanswered.append((shot, self._s.now_us))
        return self._s.link.command(
            Command.IMAGE_START_CAPTURE, 0.0, 0.0, 1.0, shot + 1.0, component=self._s.profile.camera_id
        )

    def _by_distance(self, runs: bool) -> bytes:
        s = self._s
        if runs is self._runs:
            if self._answered or s.now_us < self._tells_due_us:
                return b""
        else:
            self._runs, self._answered = runs, False
        self._tells_due_us = s.now_us + _AGAIN_US
        metres = self._orders.spacing_m if runs else 0.0
        return s.link.command(Command.DO_SET_CAM_TRIGG_DIST, metres, 0.0, 1.0 if runs else 0.0)

    def _tilt(self, path_t_s: float) -> bytes:
        s = self._s
        self._tilts_due_us = s.now_us + _TILT_EVERY_US
        pitch_deg = self._pitches_deg[min(round(path_t_s / _PITCH_S), len(self._pitches_deg) - 1)]
        if self._tilted and abs(pitch_deg - self._tilt_deg) < _TILT_DEG:
            return b""
        self._tilt_deg, self._tilted = pitch_deg, False
        command, params = s.profile.gimbal(pitch_deg)
        return s.link.command(command, *params)
