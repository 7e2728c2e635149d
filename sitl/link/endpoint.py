"""UDP and TCP: the only place in `sitl` with sockets."""

from __future__ import annotations

import contextlib
import errno
import socket
from collections.abc import Iterator
from typing import Protocol

from sitl.link.frames import datagrams

__all__ = [
    "ARDUPILOT_TCP_PORTS",
    "GCS_PORTS",
    "INSTANCE_STEP",
    "OFFBOARD_PORTS",
    "Endpoint",
    "PortTakenError",
    "TcpLink",
    "UdpLink",
    "ardupilot_links",
    "is_free",
    "listening",
    "listens",
    "px4_links",
]

OFFBOARD_PORTS = (14580, 14540)
"""Where PX4 SITL listens and where it sends, each plus the instance."""
GCS_PORTS = (18570, 14550)
ARDUPILOT_TCP_PORTS = (5760, 5762, 5763)
"""Where ArduPilot SITL listens, each plus ten times the instance."""
INSTANCE_STEP = 10

_RECEIVE_SIZE = 65535
_DATAGRAMS_PER_FRAME = 256
_UNSENT_LIMIT = 1 << 20
_PROBE_S = 0.05


class PortTakenError(OSError):
    """Somebody else has the port."""

    def __init__(self, address: str, port: int, kind: str = "UDP") -> None:
        super().__init__(f"{kind} port {port} on {address} is taken; another vehicle? Try --instance N.")


class Endpoint(Protocol):
    """One link's way into the world."""

    def receive(self) -> bytes:
        """What has come in."""

    def send(self, data: bytes) -> None:
        """Send what a link says."""

    def close(self) -> None:
        """Free the port."""


class UdpLink:
    """One UDP socket: it sends to its remote port until a client speaks, then to that first client for good.

    Raises:
        PortTakenError: the local port is in use.
    """

    def __init__(self, bind_address: str, local_port: int, remote_port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind((bind_address, local_port))
        except OSError as error:
            self._socket.close()
            if error.errno == errno.EADDRINUSE:
                raise PortTakenError(bind_address, local_port) from None
            raise
        self._partner: tuple[str, int] = ("127.0.0.1", remote_port)
        self._has_client = False

    @property
    def local_port(self) -> int:
        """The port that it listens on."""
        port: int = self._socket.getsockname()[1]
        return port

    def receive(self) -> bytes:
        """What has come in. In a flood the kernel keeps the rest, and drops what it cannot keep."""
        chunks: list[bytes] = []
        for _ in range(_DATAGRAMS_PER_FRAME):
            try:
                data, sender = self._socket.recvfrom(_RECEIVE_SIZE)
            except BlockingIOError:
                break
            except ConnectionError:  # an earlier datagram found nobody there
                continue
            if not self._has_client:
                self._partner, self._has_client = sender, True
            chunks.append(data)
        return b"".join(chunks)

    def send(self, data: bytes) -> None:
        """Send whole frames in datagrams of a modest size. Where there is no way or no room they are lost."""
        for datagram in datagrams(data):
            try:
                self._socket.sendto(datagram, self._partner)
            except OSError:  # as on a radio: telemetry is not worth stopping a flight
                return

    def close(self) -> None:
        """Free the port."""
        self._socket.close()


def is_free(port: int, kind: str = "UDP") -> bool:
    """Whether nobody on this machine listens on that UDP or TCP port."""
    stream = kind == "TCP"
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM if stream else socket.SOCK_DGRAM) as probe:
        if stream:  # a connection that has ended holds no port
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def listens(port: int) -> bool:
    """Whether anybody on this machine has that UDP port: else an empty datagram is refused."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("127.0.0.1", port))
        probe.settimeout(_PROBE_S)
        try:
            probe.send(b"")
            probe.recv(1)
        except TimeoutError:
            return True
        except OSError:
            return False
    return True


class TcpLink:
    """One TCP port: it serves one client at a time, and takes the next one when that has gone.

    Raises:
        PortTakenError: the port is in use.
    """

    def __init__(self, bind_address: str, port: int) -> None:
        self._server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._server.bind((bind_address, port))
            self._server.listen(1)
        except OSError as error:
            self._server.close()
            if error.errno == errno.EADDRINUSE:
                raise PortTakenError(bind_address, port, "TCP") from None
            raise
        self._server.setblocking(False)
        self._client: socket.socket | None = None
        self._unsent = b""

    @property
    def local_port(self) -> int:
        """The port that it listens on."""
        port: int = self._server.getsockname()[1]
        return port

    def has_client(self) -> bool:
        """Whether somebody is connected."""
        if self._client is None:
            with contextlib.suppress(OSError):  # nobody yet, or gone again
                self._client, _ = self._server.accept()
                self._client.setblocking(False)
                self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return self._client is not None

    def receive(self) -> bytes:
        """What has come in."""
        if not self.has_client() or self._client is None:
            return b""
        try:
            data = self._client.recv(_RECEIVE_SIZE)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def send(self, data: bytes) -> None:
        """Send the bytes as they are. Nobody there: they are lost. Who does not read is hung up on."""
        if self._client is None:
            return
        self._unsent += data
        try:
            self._unsent = self._unsent[self._client.send(self._unsent) :]
        except BlockingIOError:
            pass
        except OSError:
            self._hang_up()
        if len(self._unsent) > _UNSENT_LIMIT:
            self._hang_up()

    def close(self) -> None:
        """Free the port."""
        self._hang_up()
        self._server.close()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client, self._unsent = None, b""


def px4_links(bind_address: str, instance: int) -> tuple[UdpLink, ...]:
    """The offboard link and the ground station's, on PX4 SITL's ports.

    Raises:
        PortTakenError: one of the ports is in use; none is held then.
    """
    links: list[UdpLink] = []
    try:
        for local, remote in (OFFBOARD_PORTS, GCS_PORTS):
            links.append(UdpLink(bind_address, local + instance, remote + instance))
    except OSError:
        for link in links:
            link.close()
        raise
    return tuple(links)


def ardupilot_links(bind_address: str, instance: int) -> tuple[Endpoint, ...]:
    """ArduPilot SITL's three TCP ports, and UDP out to the ground station's, as sim_vehicle.py adds it.

    Raises:
        PortTakenError: one of the ports is in use; none is held then.
    """
    links: list[Endpoint] = []
    offset = INSTANCE_STEP * instance
    try:
        links += [TcpLink(bind_address, port + offset) for port in ARDUPILOT_TCP_PORTS]
        links.append(UdpLink(bind_address, 0, GCS_PORTS[1] + offset))
    except OSError:
        for link in links:
            link.close()
        raise
    return tuple(links)


@contextlib.contextmanager
def listening(port: int) -> Iterator[None]:
    """Hold that UDP port, as a ground station does that only listens.

    Raises:
        PortTakenError: somebody else has it.
    """
    link = UdpLink("127.0.0.1", port, port)
    try:
        yield
    finally:
        link.close()
