"""The loop over real sockets, on free ports; time is simulated wherever waiting would prove nothing."""

import contextlib
import gc
import os
import pty
import signal
import socket
import sys
import threading
import time
from pathlib import Path

import pytest
from fake_flight import make_session, split, way_home

from mavspiral.errors import InputError, LinkError
from mavspiral.flight import transports
from mavspiral.flight.outcome import Outcome, SessionConfig, State, Step
from mavspiral.flight.realtime import drive
from mavspiral.flight.transports import open_transport
from mavspiral.flight.wishes import Wish

LIMIT_S = 60.0
"""Against hanging; no test waits for it to pass."""


def free_port(kind=socket.SOCK_DGRAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def opened(url):
    transport = open_transport(url)
    try:
        yield transport
    finally:
        transport.close()


class Radio:
    """Steps the fake vehicle at the other end of a UDP port, 20 ms of shared simulated time at every step."""

    def __init__(self, px4, port, at_step=None):
        self.px4, self.now_us, self._port, self._at_step = px4, 1_000_000, port, at_step
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.bind(("127.0.0.1", 0))

    def __call__(self, session, step):
        self.now_us += 20_000
        frames = []
        with contextlib.suppress(BlockingIOError):
            while True:
                frames += split(self._socket.recv(65536))
        for frame in self.px4.step(self.now_us, frames):
            self._socket.sendto(frame, ("127.0.0.1", self._port))
        if self._at_step:
            self._at_step(session)


def test_a_whole_flight_over_udp(px4):
    port = free_port()
    session = make_session()
    radio = Radio(px4, port)
    with opened(f"udpin://127.0.0.1:{port}") as transport:
        outcome = drive(session, transport, radio, now_us=lambda: radio.now_us)
    assert outcome.ok, outcome
    assert not px4.armed and session.figures.rate_hz == pytest.approx(50, abs=0.1)


class Wire:
    """The fake vehicle as a transport, 20 ms a receive."""

    def __init__(self, px4):
        self.px4, self.now_us, self._frames = px4, 1_000_000, []
        self.sent_us = 0

    def send(self, data):
        self._frames, self.sent_us = split(data), self.now_us

    def receive(self, timeout_s):
        self.now_us += 20_000
        return b"".join(self.px4.step(self.now_us, self._frames))

    def close(self):
        pass


@pytest.mark.parametrize(("error", "raised"), [(BrokenPipeError, False), (ZeroDivisionError, True)])
def test_whoever_watches_cannot_end_a_flight(px4, error, raised):
    """A closed terminal, or a fault in a user's callback, must leave no vehicle in the air."""
    session, wire = make_session(), Wire(px4)
    shown = []

    def watch(session, step):
        if session.path_t_s > 10:
            shown.append(step)
            raise error

    with pytest.raises(error) if raised else contextlib.nullcontext():
        drive(session, wire, watch, now_us=lambda: wire.now_us)
    assert session.outcome.ok and not px4.armed
    assert len(shown) == 1, "it is not asked again"


def test_the_way_home_is_planned_once_the_setpoint_that_was_due_has_gone(px4):
    wire, planned = Wire(px4), []

    def slow_way_home(*places):
        planned.append(wire.sent_us == wire.now_us)
        return way_home(*places)

    session = make_session(way_home=slow_way_home)

    def calls_home(session, step):
        if session.state is State.STREAM and session.path_t_s > 20:
            session.wish(Wish.GO_HOME)

    drive(session, wire, calls_home, now_us=lambda: wire.now_us)
    assert planned == [True]
    assert session.outcome.reason == "landed, disarmed (stopped by the user; flying home)" and not px4.armed


def test_while_it_flies_nothing_is_collected_and_other_threads_give_way_soon():
    seen = []

    class Over:
        outcome = None

        def step(self, now_us, received):
            seen.append((gc.isenabled(), sys.getswitchinterval()))
            self.outcome = Outcome(True, State.LAND, "over", 0)
            return Step(b"", now_us, ())

        def stop(self):
            raise AssertionError

    class Nowhere:
        def send(self, data):
            assert not data

        def receive(self, timeout_s):
            return b""

    before = gc.isenabled(), sys.getswitchinterval()
    drive(Over(), Nowhere())
    [(collects, switches_s)] = seen
    assert not collects and switches_s < 0.001
    assert (gc.isenabled(), sys.getswitchinterval()) == before


class SleepyProcessor:
    """A transport and a clock: whoever sleeps wakes 0.7 ms late, and packets come as they please."""

    def __init__(self, packets_us=()):
        self.now_us, self.packets_us = 0, list(packets_us)

    def clock(self):
        self.now_us += 1
        return self.now_us

    def send(self, data):
        assert not data

    def receive(self, timeout_s):
        until_us = self.now_us + round(timeout_s * 1e6)
        if self.packets_us and self.packets_us[0] <= until_us:
            self.now_us = max(self.now_us, self.packets_us.pop(0))
            return b"packet"
        self.now_us = until_us + 700 * (timeout_s > 0)
        return b""


class Metronome:
    """A deadline every 20 ms, a hundred times; a packet takes 0.5 ms to be taken in."""

    def __init__(self, processor):
        self.outcome, self._processor = None, processor
        self.due_us, self.late_us = 20_000, []

    def step(self, now_us, received):
        self._processor.now_us += 500 * bool(received)
        if now_us >= self.due_us:
            self.late_us.append(now_us - self.due_us)
            self.due_us += 20_000
        if len(self.late_us) == 100:
            self.outcome = Outcome(True, State.LAND, "over", 0)
        return Step(b"", self.due_us, ())

    def stop(self):
        raise AssertionError


def test_it_is_awake_when_a_deadline_comes():
    processor = SleepyProcessor()
    metronome = Metronome(processor)
    drive(metronome, processor, now_us=processor.clock)
    assert max(metronome.late_us) < 10


def test_a_packet_that_comes_just_before_a_deadline_waits_for_it():
    processor = SleepyProcessor(20_000 * turn - 100 for turn in range(2, 90))
    metronome = Metronome(processor)
    drive(metronome, processor, now_us=processor.clock)
    assert not processor.packets_us and max(metronome.late_us) < 10


def test_what_comes_while_the_machine_does_not_let_us_run_is_not_lost():
    """A vehicle sends on; the system gives no socket more than it allows, and counts the overhead double."""
    port, allowed = free_port(), Path("/proc/sys/net/core/rmem_max")
    with opened(f"udpin://127.0.0.1:{port}") as transport:
        given_n = transport._socket.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
        assert given_n >= (2 * min(int(allowed.read_text()), 4 * 2**20) if allowed.exists() else 2**17)
        sent_n = given_n // 2500
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
            for _ in range(sent_n):
                vehicle.sendto(b"\xfd" + bytes(99), ("127.0.0.1", port))
        assert len(transport.receive(1.0)) == 100 * sent_n


def test_a_strangers_datagrams_open_no_conversation(px4):
    port = free_port()
    with (
        opened(f"udpin://127.0.0.1:{port}") as transport,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        stranger.sendto(b"hello", ("127.0.0.1", port))
        assert transport.receive(0.5) == b""
        stranger.sendto(b"\xfd\x00", ("127.0.0.1", port))
        assert transport.receive(LIMIT_S) == b"\xfd\x00"


def test_an_address_that_cannot_be_reached_is_silence_not_a_fault(px4):
    with opened("udpout://255.255.255.255:14580") as transport:
        transport.send(make_session().step(0, b"").send)


def test_ctrl_c_holds_and_again_flies_home(px4):
    port = free_port()
    presses = []

    def at_step(session):
        if session.path_t_s > 30 and (not presses or (len(presses) == 1 and radio.now_us > presses[0] + 3e6)):
            presses.append(radio.now_us)
            os.kill(os.getpid(), signal.SIGINT)

    session, radio = make_session(), Radio(px4, port, at_step)
    before = signal.getsignal(signal.SIGINT)
    with opened(f"udp:127.0.0.1:{port}") as transport:
        outcome = drive(session, transport, radio, now_us=lambda: radio.now_us)
    assert outcome.state is State.LAND and "stopped by the user" in outcome.reason
    assert signal.getsignal(signal.SIGINT) is before


def test_a_polite_kill_flies_home_since_nobody_can_be_asked(px4):
    port = free_port()
    told = []

    def at_step(session):
        if session.path_t_s > 30 and not told:
            told.append(radio.now_us)
            os.kill(os.getpid(), signal.SIGTERM)

    session, radio = make_session(), Radio(px4, port, at_step)
    before = signal.getsignal(signal.SIGTERM)
    with opened(f"udp:127.0.0.1:{port}") as transport:
        outcome = drive(
            session,
            transport,
            radio,
            on_end=lambda: session.wish(Wish.GO_HOME),
            now_us=lambda: radio.now_us,
        )
    assert outcome.reason == "landed, disarmed (stopped by the user; flying home)"
    assert State.HOLD.value not in [event.text for event in session.events]
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_dry_run_in_real_time(px4):
    """Both ends on the wall clock, the vehicle in a thread of its own, for three seconds."""
    port = free_port()
    over = threading.Event()

    def vehicle():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
            end.setblocking(False)
            while not over.wait(0.005):
                frames = []
                with contextlib.suppress(BlockingIOError):
                    while True:
                        frames += split(end.recv(65536))
                for frame in px4.step(time.monotonic_ns() // 1000, frames):
                    end.sendto(frame, ("127.0.0.1", port))

    thread = threading.Thread(target=vehicle)
    with opened(f"udpin:127.0.0.1:{port}") as transport:
        thread.start()
        try:
            outcome = drive(make_session(SessionConfig(dry_run=True)), transport)
        finally:
            over.set()
            thread.join()
    assert outcome.ok, outcome


def test_nobody_at_the_other_end_is_exit_3():
    ticks = iter(range(0, 10**9, 100_000))
    with opened(f"udpout://127.0.0.1:{free_port()}") as transport:
        outcome = drive(make_session(), transport, now_us=lambda: next(ticks))
    assert outcome.exit_code == 3 and outcome.state is State.CONNECT


def test_a_connection_that_breaks_is_exit_3():
    server = socket.create_server(("127.0.0.1", 0))
    with server, opened(f"tcp://127.0.0.1:{server.getsockname()[1]}") as transport:
        server.accept()[0].close()
        outcome = drive(make_session(), transport)
    assert outcome.exit_code == 3 and "connection" in outcome.reason


def test_a_listening_port_answers_whoever_spoke_first(monkeypatch):
    monkeypatch.setattr(transports, "_PEER_SILENT_S", 60.0)  # of the second's chances this is not about
    port = free_port()
    with (
        opened(f"udpin://0.0.0.0:{port}") as transport,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second,
    ):
        transport.send(b"\xfd" + bytes(11))  # nobody to send to yet: no harm
        first.sendto(b"\xfdone", ("127.0.0.1", port))
        assert transport.receive(LIMIT_S) == b"\xfdone"
        second.sendto(b"\xfdtwo", ("127.0.0.1", port))
        assert transport.receive(0.2) == b""
        beat = make_session().step(0, b"").send
        transport.send(beat)
        first.settimeout(LIMIT_S)
        assert first.recv(100) == beat


def test_datagrams_hold_whole_frames():
    frame = make_session().step(0, b"").send
    pieces = list(transports._datagrams(frame * 200))
    assert b"".join(pieces) == frame * 200
    assert all(len(piece) % len(frame) == 0 and len(piece) <= 1400 for piece in pieces)
    assert len(pieces) == 4


@pytest.mark.parametrize(
    "spelling", ["udpin://127.0.0.1:{}", "udp:127.0.0.1:{}", "udpin:127.0.0.1:{}", "udp://:{}"]
)
def test_a_taken_port_is_named_with_a_fix(spelling):
    port = free_port()
    with opened(spelling.format(port)), pytest.raises(InputError, match=f"port {port} is taken.*close it"):
        open_transport(spelling.format(port))


@pytest.mark.parametrize(
    "url",
    [
        "",
        "14540",
        "udpin://0.0.0.0",
        "udpin://0.0.0.0:0",
        "udpin://0.0.0.0:99999",
        "http://x:1",
        "serial://",
        "udpin:x:y",
    ],
)
def test_what_is_no_link_is_answered_with_examples(url):
    with pytest.raises(InputError, match=r"udpin://0\.0\.0\.0:14540") as refusal:
        open_transport(url)
    assert "\n" not in str(refusal.value) and repr(url) in str(refusal.value)


def test_an_unknown_host_is_bad_input():
    with pytest.raises(InputError, match=r"no-such-host\.invalid"):
        open_transport("udpout://no-such-host.invalid:14580")


def test_nobody_listens_at_a_tcp_address():
    with pytest.raises(LinkError, match="nobody listens"):
        open_transport(f"tcp:127.0.0.1:{free_port(socket.SOCK_STREAM)}")


@pytest.mark.parametrize(
    "url", ["serial:///dev/ttyACM0:57600", "/dev/ttyACM0,57600", "/dev/ttyACM0", "COM3,115200"]
)
def test_a_serial_link_without_pyserial_names_it(url, monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(InputError, match="pip install pyserial"):
        open_transport(url)


@pytest.mark.parametrize(("url", "baud"), [("serial://{}:115200", 115200), ("{},9600", 9600), ("{}", 57600)])
def test_serial_devices_in_both_spellings(url, baud):
    pytest.importorskip("serial")
    ours, theirs = pty.openpty()
    with opened(url.format(os.ttyname(theirs))) as transport:
        assert transport._port.baudrate == baud
        os.write(ours, b"hello")
        assert transport.receive(LIMIT_S) == b"hello"
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("spelling", ["tcpin://127.0.0.1:{}", "tcpin:127.0.0.1:{}"])
def test_a_vehicle_that_calls_us_is_answered(spelling, monkeypatch):
    port = free_port(socket.SOCK_STREAM)
    heard = []

    def vehicle():
        until_s = time.monotonic() + LIMIT_S
        while time.monotonic() < until_s:
            try:
                with socket.create_connection(("127.0.0.1", port)) as end:
                    end.sendall(b"hello")
                    heard.append(end.recv(100))
                return
            except ConnectionRefusedError:
                time.sleep(0.01)

    monkeypatch.setattr(transports, "_DIAL_S", LIMIT_S)
    caller = threading.Thread(target=vehicle)
    caller.start()
    with opened(spelling.format(port)) as transport:
        assert transport.receive(LIMIT_S) == b"hello"
        transport.send(b"yes")
        caller.join()
    assert heard == [b"yes"]


def test_nobody_calls(monkeypatch):
    monkeypatch.setattr(transports, "_DIAL_S", 0.05)
    with pytest.raises(LinkError, match="nobody called"):
        open_transport(f"tcpin:127.0.0.1:{free_port(socket.SOCK_STREAM)}")


def test_a_taken_tcp_port_is_named():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"TCP port {port} is taken"):
            open_transport(f"tcpin:127.0.0.1:{port}")


def test_of_several_at_one_port_the_one_that_is_named_is_answered():
    port = free_port()
    with (
        contextlib.closing(open_transport(f"udpin://127.0.0.1:{port}", 2)) as link,
        contextlib.ExitStack() as open_,
    ):
        vehicles = {}
        for system in (1, 2):
            vehicles[system] = open_.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            vehicles[system].settimeout(LIMIT_S)
            vehicles[system].sendto(bytes((0xFD, 0, 0, 0, 0, system)), ("127.0.0.1", port))
            assert link.receive(LIMIT_S)[5] == system, "who else is there is heard until it comes"
            if system == 1:
                link.send(bytes((0xFD, *[0] * 11)))
        vehicles[1].sendto(bytes((0xFD, 0, 0, 0, 0, 1)), ("127.0.0.1", port))
        vehicles[2].sendto(bytes((0xFD, 0, 0, 0, 0, 2)), ("127.0.0.1", port))
        link.send(bytes((0xFD, *[0] * 11)))
        assert len(vehicles[2].recv(100)) == 12
        vehicles[1].setblocking(False)
        with pytest.raises(BlockingIOError):
            vehicles[1].recv(100)
