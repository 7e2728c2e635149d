"""A commander over a body that does what it is told at once."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sitl.autopilot.commander import Commander
from sitl.link.parameters import ParameterTable
from sitl.orders import Arm, Mode, SwitchMode, TakeOff, Verdict
from sitl.params import Params
from sitl.signals import Estimate, GeoPoint, vector

FRAME_US = 10_000
ORIGIN = GeoPoint(19.435, -99.146, 2240.0)
NAN3 = vector([math.nan] * 3)


def estimate(position, velocity, ok=True):
    numbers = np.zeros(31)
    numbers[:7] = *position, *velocity, 1.0
    return Estimate(0, vector(numbers, 31), ok, ok, ok, ok)


@dataclass
class Body:
    """Follows its setpoint exactly: position where there is one, else velocity."""

    time_us: int = 0
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    ok: bool = True
    charge_left: float = 1.0

    @property
    def estimate(self):
        return estimate(self.position, self.velocity, self.ok)

    @property
    def origin(self):
        return ORIGIN if self.ok else None

    @property
    def knows_position(self):
        return self.ok

    @property
    def on_ground(self):
        return self.position[2] >= 0.0

    def follow(self, demand):
        dt = 1e-6 * FRAME_US
        if demand.armed and not demand.idle:
            wanted = demand.setpoint.velocity_ned_mps
            self.velocity = np.where(np.isfinite(wanted), wanted, 0.0)
            moved = self.position + self.velocity * dt
            goal = demand.setpoint.position_ned_m
            self.position = np.minimum(np.where(np.isfinite(goal), goal, moved), [np.inf, np.inf, 0.0])
        self.time_us += FRAME_US


class Flight:
    def __init__(self, **params):
        self.body = Body()
        self.commander = Commander(ParameterTable(Params(params)))
        self.demands = []

    def obey(self, order):
        return self.commander.obey(order, self.body)

    def live(self, seconds, setpoint=None, every_us=20_000):
        """Frames for so long, with a setpoint at that interval. Returns the demands of these frames."""
        demands = []
        for frame in range(round(seconds * 1e6 / FRAME_US)):
            if setpoint is not None and frame * FRAME_US % every_us == 0:
                self.commander.steer(setpoint, self.body)
            demands.append(self.commander.command(self.body))
            self.body.follow(demands[-1])
        return demands

    @property
    def status(self):
        return self.commander.status(self.body)

    def airborne(self, height_m=20.0):
        self.live(0.1)
        assert self.obey(TakeOff(ORIGIN.alt_amsl_m + height_m)) is Verdict.ACCEPTED
        assert self.obey(Arm()) is Verdict.ACCEPTED
        self.live(40.0)
        assert self.status.mode is Mode.HOLD
        return self

    def offboard(self, setpoint):
        self.commander.steer(setpoint, self.body)
        assert self.obey(SwitchMode(Mode.OFFBOARD)) is Verdict.ACCEPTED
        self.live(1.0, setpoint)
        assert self.status.mode is Mode.OFFBOARD
        return self
