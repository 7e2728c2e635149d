"""A plan to fly in tests, and the loop that hands bytes to and fro on a simulated clock."""

import math
import random

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.curve.line import LinePath
from mavspiral.flight.outcome import SessionConfig
from mavspiral.flight.session import Session
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.trajectory import Leg, Trajectory

PLAN_ORIGIN = GeoPoint(19.4336, -99.1409, 2240.0)
VEHICLE_ORIGIN = (19.43395, -99.14125, 2251.5)  # some 40 m from the plan's, 11.5 m higher
HOME = (-69.0, 49.0, 14.5)  # NED of the vehicle: its ground is at 2237 m, 3 m below the plan's


class Helix:
    """Two turns of 8 m round (20, 0), climbing 6 m a turn."""

    u_end_rad = 4 * math.pi

    def __call__(self, u_rad, order=0):
        u = np.asarray(u_rad, dtype=float)
        turn = order * math.pi / 2  # each derivative of cos and sin turns by a quarter
        x, y = 8 * np.cos(u + turn), 8 * np.sin(u + turn)
        z = (18 + 3 / math.pi * u, np.full_like(u, 3 / math.pi), np.zeros_like(u), np.zeros_like(u))[order]
        return np.stack([x + (20 if order == 0 else 0), y, z], axis=-1)

    def jet(self, u_rad):
        return np.stack([self(u_rad, order) for order in range(4)])


class Inward:
    """Yaw towards the middle of the helix."""

    def __call__(self, u_rad, order=0):
        u = np.asarray(u_rad, dtype=float)
        return (u + math.pi, np.ones_like(u), np.zeros_like(u))[order]

    def jet(self, u_rad):
        return np.stack([self(u_rad, order) for order in range(3)])


class Steady:
    """One yaw."""

    def __init__(self, yaw_enu_rad):
        self.yaw_enu_rad = yaw_enu_rad

    def __call__(self, u_rad, order=0):
        return np.full_like(np.asarray(u_rad, dtype=float), self.yaw_enu_rad if order == 0 else 0.0)

    def jet(self, u_rad):
        return np.stack([self(u_rad, order) for order in range(3)])


def minimum_jerk_law(u_end_rad, duration_s, knots=400):
    s = np.linspace(0, 1, knots + 1)
    return TimeLaw(
        duration_s / knots,
        u_end_rad * (10 * s**3 - 15 * s**4 + 6 * s**5),
        u_end_rad / duration_s * (30 * s**2 - 60 * s**3 + 30 * s**4),
        u_end_rad / duration_s**2 * (60 * s - 180 * s**2 + 120 * s**3),
    )


def line(name, start, end, yaw_enu_rad):
    path = LinePath(np.asarray(start, float), np.asarray(end, float))
    duration_s = max(2.0, 15 / 8 * math.dist(start, end) / 4.0)
    return Leg(name, path, Steady(yaw_enu_rad), minimum_jerk_law(path.u_end_rad, duration_s))


def make_trajectory(home_enu_m, helix_s=40.0):
    helix = Helix()
    above = np.asarray(home_enu_m) + np.array([0, 0, 20.0])
    begin, end = helix(0.0), helix(helix.u_end_rad)
    return Trajectory(
        (
            line("approach-1", above, begin, math.pi),
            Leg("inspection", helix, Inward(), minimum_jerk_law(helix.u_end_rad, helix_s)),
            line("return-1", end, above, math.pi),
        )
    )


def way_home(start_enu_m, end_enu_m, yaw_enu_rad):
    return Trajectory((line("home-1", start_enu_m, end_enu_m, yaw_enu_rad),))


def leaving_first(start_enu_m, end_enu_m, yaw_enu_rad):
    away_enu_m = start_enu_m + np.array([6.0, 0.0, 0.0])
    leave = line("leave-1", start_enu_m, away_enu_m, yaw_enu_rad)
    return Trajectory((leave, *way_home(away_enu_m, end_enu_m, yaw_enu_rad).legs))


def make_session(config=None, route=make_trajectory, **kwargs):
    kwargs.setdefault("way_home", way_home)
    return Session(route, LocalFrame(PLAN_ORIGIN), config or SessionConfig(), **kwargs)


class Air:
    """What lies between: loses, doubles and overtakes frames."""

    def __init__(self, seed=1, loss=0.0, double=0.0, overtake=0.0):
        self._random, self._loss, self._double, self._overtake = random.Random(seed), loss, double, overtake
        self._kept = []

    def __call__(self, frames):
        out, draw = self._kept, self._random.random
        self._kept = []
        for frame in frames:
            if draw() < self._loss:
                continue
            (self._kept if draw() < self._overtake else out).append(frame)
            if draw() < self._double:
                out.append(frame)
        self._random.shuffle(out) if self._overtake and draw() < self._overtake else None
        return out


def fly(session, px4, until=None, limit_s=600.0, step_us=20_000, down=None, up=None, each=None):
    """Step both every 20 ms until the session has an outcome (or `until()`); the simulated end in us."""
    now_us, received = 5_000_000, b""
    up, down = up or (lambda frames: frames), down or (lambda frames: frames)
    while now_us < 5_000_000 + limit_s * 1e6:
        if each:
            each(now_us)
        sent = session.step(now_us, received).send
        received = b"".join(down(px4.step(now_us, up(split(sent)))))
        if session.outcome or (until and until()):
            return now_us
        now_us += step_us
    raise AssertionError(f"still in {session.state} after {limit_s} s: {session.events[-5:]}")


def split(stream):
    """The MAVLink 2 frames in a row."""
    frames = []
    while stream:
        assert stream[0] == 0xFD
        size = stream[1] + 12
        frames.append(stream[:size])
        stream = stream[size:]
    return frames


def texts(session):
    return " | ".join(event.text for event in session.events)


def streaming_for(session, path_s):
    return lambda: session.path_t_s > path_s


def parsed(stream):
    return mavlink.MAVLink(None).parse_buffer(stream) or []
