"""The endpoint: datagrams of whole frames, the first client, a taken port, deadlines."""

import random
import socket
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.link import endpoint
from sitl.link.codec import Codec
from sitl.link.endpoint import GCS_PORTS, PortTakenError, TcpLink, UdpLink, is_free, run, wait_for_client
from sitl.link.frames import datagrams
from sitl.link.messages import message_type

STATUSTEXT = message_type("STATUSTEXT")
LIMIT_S = 60.0


@given(st.lists(st.binary(min_size=1, max_size=50), max_size=40), st.integers(20, 1280))
def test_datagrams_hold_whole_frames_and_lose_none(texts, limit):
    codec = Codec(1, 1)
    frames = [codec.encode(STATUSTEXT(6, text, 0, 0)) for text in texts]
    parts = list(datagrams(b"".join(frames), limit))
    assert b"".join(parts) == b"".join(frames)
    for part in parts:
        assert len(part) <= limit or part in frames
        whole = Codec(1, 1)
        whole.decode(part)
        assert whole.snapshot().pending == b""
        assert whole.rejected == 0


def client():
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sock.bind(("127.0.0.1", 0))
    sock.settimeout(LIMIT_S)
    return sock


def frame(text):
    return Codec(1, 1).encode(STATUSTEXT(6, text, 0, 0))


def test_it_sends_to_its_remote_port_until_the_first_client_speaks():
    default, first, second = client(), client(), client()
    link = UdpLink("127.0.0.1", 0, default.getsockname()[1])
    try:
        link.send(frame(b"anybody"))
        assert default.recv(999) == frame(b"anybody")
        first.sendto(b"one", ("127.0.0.1", link.local_port))
        second.sendto(b"two", ("127.0.0.1", link.local_port))
        assert link.receive() == b"onetwo"
        link.send(frame(b"you"))
        assert first.recv(999) == frame(b"you")
        second.setblocking(False)
        with pytest.raises(BlockingIOError):
            second.recv(999)
    finally:
        for sock in (default, first, second):
            sock.close()
        link.close()


def test_nobody_there_is_no_error():
    gone = client()
    port = gone.getsockname()[1]
    gone.close()
    link = UdpLink("127.0.0.1", 0, port)
    try:
        for _ in range(3):
            link.send(frame(b"hello"))
            assert link.receive() == b""
    finally:
        link.close()


def test_a_taken_port_is_named():
    link = UdpLink("127.0.0.1", 0, 9)
    try:
        with pytest.raises(PortTakenError, match=str(link.local_port)):
            UdpLink("127.0.0.1", link.local_port, 9)
    finally:
        link.close()


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
    monkeypatch.setattr(endpoint, "time", clock)

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


def eventually(holds, limit_s=LIMIT_S):
    deadline = time.monotonic() + limit_s
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_a_tcp_port_serves_one_client_and_then_the_next():
    link = TcpLink("127.0.0.1", 0)
    try:
        link.send(b"lost")
        assert link.receive() == b""
        for word in (b"one", b"two"):
            with socket.create_connection(("127.0.0.1", link.local_port), timeout=LIMIT_S) as client:
                eventually(link.has_client)
                client.sendall(word)
                heard = []
                eventually(lambda heard=heard, word=word: heard.append(link.receive()) or heard[-1] == word)
                link.send(b"Init text, no frame")
                assert client.recv(99) == b"Init text, no frame"
            eventually(lambda: not link.receive() and link._client is None)
    finally:
        link.close()


def test_a_client_that_does_not_read_is_hung_up_on_and_memory_stays_bounded():
    link = TcpLink("127.0.0.1", 0)
    try:
        with socket.create_connection(("127.0.0.1", link.local_port), timeout=LIMIT_S):
            eventually(link.has_client)
            for _ in range(200):
                link.send(b"x" * 100_000)
                if link._client is None:
                    break
            assert link._client is None
            assert len(link._unsent) == 0
    finally:
        link.close()


def test_a_taken_tcp_port_is_named():
    link = TcpLink("127.0.0.1", 0)
    try:
        with pytest.raises(PortTakenError, match=f"TCP port {link.local_port}"):
            TcpLink("127.0.0.1", link.local_port)
    finally:
        link.close()


def station_port(instance):
    return GCS_PORTS[1] + 10 * instance


@pytest.fixture
def unused():
    """An instance that no vehicle has, nor anybody its ground station's port; below those that the system hands out."""
    return next(i for i in random.sample(range(400, 1800), 1400) if is_free(station_port(i)))


def test_ardupilot_boots_when_a_client_comes_to_the_first_port(unused):
    console = TcpLink("127.0.0.1", 0)
    waiting = threading.Thread(target=wait_for_client, args=((console,), unused), daemon=True)
    try:
        waiting.start()
        waiting.join(0.3)
        assert waiting.is_alive()
        with socket.create_connection(("127.0.0.1", console.local_port), timeout=LIMIT_S):
            waiting.join(LIMIT_S)
            assert not waiting.is_alive()
    finally:
        console.close()


def test_ardupilot_boots_when_a_ground_station_listens(unused):
    console, station = TcpLink("127.0.0.1", 0), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        station.bind(("127.0.0.1", station_port(unused)))
        wait_for_client((console,), unused)
    finally:
        station.close()
        console.close()
