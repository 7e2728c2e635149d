"""UDP and real time: the only place in `sitl` with sockets and a wall clock."""

from __future__ import annotations

import errno
import socket
import time
from collections.abc import Callable, Iterator, Sequence

__all__ = [
    "GCS_PORTS",
    "OFFBOARD_PORTS",
    "PortTakenError",
    "UdpLink",
    "datagrams",
    "is_free",
    "px4_links",
    "run",
    "signing_timestamp",
]

OFFBOARD_PORTS = (14580, 14540)
"""Where PX4 SITL listens and where it sends, each plus the instance."""
GCS_PORTS = (18570, 14550)

_DATAGRAM_LIMIT = 1280
_RECEIVE_SIZE = 65535
_DATAGRAMS_PER_FRAME = 256
_OVERHEAD, _SIGNATURE, _SIGNED = 12, 13, 1
_SIGNING_EPOCH_S = 1_420_070_400  # 2015-01-01 UTC
_FRAME_US = 10_000
_GIVE_UP_S = 0.5
"""So late, the clock is set anew rather than caught up with."""


class PortTakenError(OSError):
    """Somebody else has the port."""

    def __init__(self, address: str, port: int) -> None:
        super().__init__(f"UDP port {port} on {address} is taken; another vehicle? Try --instance N.")


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


def is_free(port: int) -> bool:
    """Whether nobody on this machine listens on that UDP port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def signing_timestamp() -> int:
    """What the clock says, as MAVLink's signatures count: 10 µs since 2015."""
    return int((time.time() - _SIGNING_EPOCH_S) * 1e5)


def datagrams(frames: bytes, limit: int = _DATAGRAM_LIMIT) -> Iterator[bytes]:
    """MAVLink 2 frames in datagrams of at most `limit` bytes, none of them cut."""
    begin = end = 0
    while end < len(frames):
        size = frames[end + 1] + _OVERHEAD + _SIGNATURE * (frames[end + 2] & _SIGNED)
        if end > begin and end + size - begin > limit:
            yield frames[begin:end]
            begin = end
        end += size
    if end > begin:
        yield frames[begin:]


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


def run(
    exchange: Callable[[int, tuple[bytes, ...]], tuple[bytes, ...]],
    links: Sequence[UdpLink],
    *,
    speedup: float = 1.0,
    after_frame: Callable[[], bool] = lambda: True,
) -> None:
    """Drive `exchange` with simulated time, `speedup` times the clock's, until `after_frame` says no.

    Frames have absolute deadlines, so that lateness does not add up.
    """
    frame_s = 1e-6 * _FRAME_US / speedup
    now_us, deadline_s = 0, time.monotonic()
    while after_frame():
        now_us, deadline_s = now_us + _FRAME_US, deadline_s + frame_s
        late_s = time.monotonic() - deadline_s
        if late_s < 0.0:
            time.sleep(-late_s)
        elif late_s > _GIVE_UP_S:
            deadline_s += late_s
        received = tuple(link.receive() for link in links)
        for link, data in zip(links, exchange(now_us, received), strict=True):
            if data:
                link.send(data)
