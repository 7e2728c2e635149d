"""The ways to a vehicle: UDP, TCP and serial links. Beside `realtime` the only sockets and the only clock."""

from __future__ import annotations

import contextlib
import errno
import importlib
import re
import select
import socket
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from mavspiral.errors import InputError, LinkError
from mavspiral.flight.signing import SIGNATURE_N, SIGNED

__all__ = ["Transport", "judge_url", "open_transport"]

_READ_N = 65536
_DATAGRAM_N = 1400
_WAITING_N = 4 * 2**20
"""Bytes. As much as may wait in a socket while a busy machine does not let us run: by default PX4 fills it in 0.7 s."""
_DIAL_S = 10.0
_PEER_SILENT_S = 3.0
_BAUD = 57600
_MAGICS = (b"\xfd", b"\xfe")  # how a datagram of MAVLink begins: a stranger's words open no conversation
_EXAMPLES = (
    "udpin://0.0.0.0:14540, udpout://192.168.1.2:14580, tcp://127.0.0.1:5760, serial:///dev/ttyACM0:57600"
)
_PYMAVLINK = {
    "udp": "udpin",
    "udpin": "udpin",
    "udpout": "udpout",
    "tcp": "tcp",
    "tcpout": "tcp",
    "tcpin": "tcpin",
}


class Transport(Protocol):
    """Bytes to and from one vehicle."""

    def send(self, data: bytes) -> None:
        """Send whole frames."""

    def receive(self, timeout_s: float) -> bytes:
        """What has come, waiting for it no longer than `timeout_s`; empty if nothing has."""

    def close(self) -> None:
        """Give up the port."""


@dataclass(frozen=True, slots=True)
class _Address:
    """Where a link leads: `kind` is udpin, udpout, tcp, tcpin or serial; `number` a port or a baud rate."""

    kind: str
    host: str
    number: int


def judge_url(url: str) -> _Address:
    """The link that `url` spells as MAVSDK or as pymavlink does; nothing is opened.

    Raises:
        InputError: it cannot be read.
    """
    if serial := re.fullmatch(r"(?:serial(?:_flowcontrol)?://)?((?:/dev/|COM)[^:,]+)(?:[:,](\d+))?", url):
        return _Address("serial", serial[1], int(serial[2] or _BAUD))
    address = re.fullmatch(r"(\w+):(?://)?\[?([^\[\]]*?)\]?:(\d{1,5})", url)
    kind = _PYMAVLINK.get(address[1]) if address else None
    if address is None or kind is None or not 0 < int(address[3]) < 65536:
        raise InputError(f"no link is called {url!r}. Fix: write it as one of {_EXAMPLES}")
    return _Address(kind, address[2] or "0.0.0.0", int(address[3]))


def open_transport(url: str, system_id: int | None = None) -> Transport:
    """The link at `url`; where several call at one UDP port, to the one of that MAVLink system.

    Raises:
        InputError: the URL cannot be read (`judge_url`), or its port is taken.
        LinkError: nobody listens at a TCP address, or the serial device is not there.
    """
    address = judge_url(url)
    host, number = address.host, address.number
    if address.kind == "serial":
        return _Serial(host, number)
    if address.kind in ("udpin", "udpout"):
        return _Udp(host, number, listens=address.kind == "udpin", system_id=system_id)
    return _Tcp(_dialled(host, number) if address.kind == "tcp" else _called(host, number))


class _Udp:
    """A datagram socket. A listening one answers whoever speaks first, until that one falls silent.

    Where it is for one MAVLink system, it answers nobody else; until that one speaks, all others are heard.
    """

    def __init__(self, host: str, port: int, *, listens: bool, system_id: int | None) -> None:
        self._listens, self._system_id = listens, system_id
        self._heard_s = 0.0
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        with contextlib.suppress(OSError):  # Linux gives as much as it allows, others refuse
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _WAITING_N)
        self._peer: tuple[object, ...] | None = None
        try:
            if listens:
                self._socket.bind((host, port))
            else:
                self._peer = socket.getaddrinfo(host, port, family, socket.SOCK_DGRAM)[0][4]
        except UnicodeError:
            self._socket.close()
            raise InputError(f"{host!r} is no host. Fix: write the link as one of {_EXAMPLES}") from None
        except OSError as error:
            self._socket.close()
            raise _refused(error, host, port) from error
        self._socket.setblocking(False)

    def send(self, data: bytes) -> None:
        if self._peer is None:
            return
        for datagram in _datagrams(data):
            with contextlib.suppress(OSError):  # lost, as on the air: silence decides when the link is
                self._socket.sendto(datagram, self._peer)

    def receive(self, timeout_s: float) -> bytes:
        select.select([self._socket], [], [], timeout_s)
        data = bytearray()
        while True:
            try:
                datagram, peer = self._socket.recvfrom(_READ_N)
            except BlockingIOError:
                return bytes(data)
            except OSError:  # nobody there yet, or the network is away for now
                return bytes(data)
            if datagram[:1] in _MAGICS and self._is_ours(peer, datagram):
                data += datagram

    def _is_ours(self, peer: tuple[object, ...], datagram: bytes) -> bool:
        now_s = time.monotonic()
        silent = now_s - self._heard_s > _PEER_SILENT_S
        if (
            self._listens
            and peer != self._peer
            and silent
            and self._system_id in (None, _system_of(datagram))
        ):
            self._peer = peer
        if peer != self._peer:
            return not self._listens or self._peer is None
        self._heard_s = now_s
        return True

    def close(self) -> None:
        self._socket.close()


def _system_of(datagram: bytes) -> int | None:
    """Who has sent its first frame."""
    at = 5 if datagram[:1] == _MAGICS[0] else 3
    return datagram[at] if len(datagram) > at else None


def _dialled(host: str, port: int) -> socket.socket:
    """A connection to whoever listens there."""
    try:
        return socket.create_connection((host, port), timeout=_DIAL_S)
    except OSError as error:
        reason = error.strerror or error
        raise LinkError(
            f"nobody listens at tcp://{host}:{port} ({reason}). Fix: start the vehicle, or mend the address"
        ) from error


def _called(host: str, port: int) -> socket.socket:
    """The connection of the first who calls there."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        server = socket.create_server((host, port), family=family, backlog=1)
    except UnicodeError:
        raise InputError(f"{host!r} is no host. Fix: write the link as one of {_EXAMPLES}") from None
    except OSError as error:
        raise _refused(error, host, port, "TCP") from error
    with server:
        server.settimeout(_DIAL_S)
        try:
            return server.accept()[0]
        except TimeoutError as error:
            raise LinkError(
                f"nobody called at tcpin://{host}:{port} in {_DIAL_S:g} s. Fix: start the vehicle, or mend the address"
            ) from error


class _Tcp:
    """A connection that is open."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection
        self._socket.settimeout(_DIAL_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise LinkError(f"the connection broke: {error.strerror or error}") from error

    def receive(self, timeout_s: float) -> bytes:
        try:
            if not select.select([self._socket], [], [], timeout_s)[0]:
                return b""
            data = self._socket.recv(_READ_N)
        except OSError as error:
            raise LinkError(f"the connection broke: {error.strerror or error}") from error
        if not data:
            raise LinkError("the vehicle closed the connection")
        return data

    def close(self) -> None:
        self._socket.close()


class _Serial:
    """A serial device, by pyserial."""

    def __init__(self, device: str, baud: int) -> None:
        try:
            serial = importlib.import_module("serial")
        except ImportError as error:
            raise InputError(f"{device} needs pyserial. Fix: pip install pyserial") from error
        try:
            self._port = serial.Serial(device, baud, timeout=0, write_timeout=1)
        except (OSError, ValueError) as error:
            raise LinkError(
                f"{device} cannot be opened: {error}. Fix: plug it in, or mend its name"
            ) from error

    def send(self, data: bytes) -> None:
        try:
            self._port.write(data)
        except OSError as error:
            raise LinkError(f"{self._port.name} broke: {error}") from error

    def receive(self, timeout_s: float) -> bytes:
        self._port.timeout = timeout_s
        try:
            first: bytes = self._port.read(1)
            return first + self._port.read(self._port.in_waiting) if first else b""
        except OSError as error:
            raise LinkError(f"{self._port.name} broke: {error}") from error

    def close(self) -> None:
        self._port.close()


def _refused(error: OSError, host: str, port: int, kind: str = "UDP") -> InputError:
    if error.errno == errno.EADDRINUSE:
        return InputError(
            f"{kind} port {port} is taken by another program (a ground station, another mavspiral?). "
            f"Fix: close it or give this link another port"
        )
    return InputError(f"cannot use {host}:{port}: {error.strerror or error}. Fix: an address of this machine")


def _datagrams(data: bytes) -> Iterator[bytes]:
    """`data`, which is whole MAVLink 2 frames, in pieces of whole frames that fit a datagram."""
    begin = end = 0
    while end < len(data):
        size = data[end + 1] + 12 + SIGNATURE_N * (data[end + 2] & SIGNED)
        if end + size - begin > _DATAGRAM_N and end > begin:
            yield data[begin:end]
            begin = end
        end += size
    if end > begin:
        yield data[begin:end]
