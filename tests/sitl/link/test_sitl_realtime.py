"""Frames in real time: each in its turn, never early, and lateness is caught up with gently."""

import time

import numpy as np
import pytest

from sitl.link import realtime
from sitl.link.realtime import run


@pytest.mark.parametrize("speedup", [1.0, 10.0])
def test_every_frame_is_exchanged_once_and_never_ahead_of_the_clock(speedup):
    times_us, begin_s = [], time.monotonic()

    def exchange(now_us, received):
        elapsed_us = 1e6 * (time.monotonic() - begin_s)
        assert now_us <= speedup * elapsed_us + 1.0
        times_us.append(now_us)
        return ()

    run(exchange, (), speedup=speedup, after_frame=lambda: len(times_us) < 20)
    assert times_us == [10_000 * (i + 1) for i in range(20)]


class Clock:
    """A clock for `run` that stands still but for its sleeps and what is added to it."""

    def __init__(self):
        self.now_s = 100.0

    def monotonic(self):
        return self.now_s

    def sleep(self, rest_s):
        self.now_s += rest_s


def kept_back(monkeypatch, away_s, speedup):
    """When each of 400 frames was exchanged, in seconds since the beginning; before the 50th the machine was away so long."""
    clock, at_s = Clock(), []
    monkeypatch.setattr(realtime, "time", clock)

    def exchange(now_us, received):
        at_s.append(clock.now_s - 100.0)
        if len(at_s) == 50:
            clock.now_s += away_s
        return ()

    run(exchange, (), speedup=speedup, after_frame=lambda: len(at_s) < 400)
    return at_s


@pytest.mark.parametrize("speedup", [1.0, 8.0])
def test_who_was_kept_from_running_catches_up_and_floods_nobody(monkeypatch, speedup):
    """A reader's UDP socket holds a few hundred datagrams: half a second of eight times real time would be four hundred at once."""
    at_s, frame_s = kept_back(monkeypatch, 0.4, speedup), 0.01 / speedup
    rests_s = np.diff(at_s[50:])
    assert min(rests_s) >= 0.4 * frame_s
    if speedup == 1.0:
        assert at_s[-1] == pytest.approx(400 * frame_s)


def test_who_was_away_for_long_goes_on_from_there(monkeypatch):
    at_s = kept_back(monkeypatch, 5.0, 1.0)
    assert at_s[-1] == pytest.approx(400 * 0.01 + 5.0, abs=0.02)
