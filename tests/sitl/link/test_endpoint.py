"""The endpoint: datagrams of whole frames, the first client, a taken port."""

import random
import socket
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.link.codec import Codec
from sitl.link.endpoint import GCS_PORTS, PortTakenError, TcpLink, UdpLink, is_free
from sitl.link.frames import datagrams
from sitl.link.messages import message_type
from sitl.link.realtime import wait_for_client

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
