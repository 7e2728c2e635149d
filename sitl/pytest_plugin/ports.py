"""Where a vehicle of either dialect is found, and which of them nobody else has."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

from sitl.link.endpoint import ARDUPILOT_TCP_PORTS, GCS_PORTS, OFFBOARD_PORTS, is_free

__all__ = ["DIALECTS", "Dialect", "Ports", "free_ports", "ports_of"]

Dialect = Literal["px4", "ardupilot"]
DIALECTS: tuple[Dialect, ...] = get_args(Dialect)

# PX4's ports lie 10, 30 and 40 apart: within a block of ten and blocks of fifty no two vehicles share one.
# ArduPilot's instances lie 10 apart; from 40 on its ground stations' ports are above all of PX4's.
_INSTANCES: dict[Dialect, tuple[int, ...]] = {
    "px4": tuple(block + i for block in (20, 70, 120, 170, 220) for i in range(10)),
    "ardupilot": tuple(range(40, 240)),
}
_WORKERS_APART = 7
_ARDUPILOT_APART = 10


@dataclass(frozen=True, slots=True)
class Ports:
    """One vehicle's: `companion` is UDP where a PX4 sends to and TCP where an ArduPilot listens; `gcs` is UDP."""

    instance: int
    companion: int
    gcs: int
    udp: tuple[int, ...]
    """All that the vehicle or who listens to it binds."""
    tcp: tuple[int, ...] = ()

    @property
    def url(self) -> str:
        """The companion's link as MAVSDK spells it."""
        return f"{'tcpout' if self.tcp else 'udpin'}://127.0.0.1:{self.companion}"

    @property
    def mavutil_url(self) -> str:
        """The companion's link as pymavlink spells it."""
        return f"{'tcp' if self.tcp else 'udpin'}:127.0.0.1:{self.companion}"


def ports_of(dialect: Dialect, instance: int) -> Ports:
    """The ports of that instance, as PX4's and ArduPilot's SITL count them."""
    if dialect == "px4":
        udp = tuple(port + instance for port in (*OFFBOARD_PORTS, *GCS_PORTS))
        return Ports(instance, udp[1], udp[3], udp)
    further = _ARDUPILOT_APART * instance
    gcs = GCS_PORTS[1] + further
    tcp = tuple(port + further for port in ARDUPILOT_TCP_PORTS)
    return Ports(instance, tcp[0], gcs, (gcs,), tcp)


def free_ports(dialect: Dialect) -> Iterator[Ports]:
    """Those that nobody has, each xdist worker beginning elsewhere."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    first = _WORKERS_APART * int(worker) if worker.isdecimal() else 0
    instances = _INSTANCES[dialect]
    for i in range(len(instances)):
        ports = ports_of(dialect, instances[(first + i) % len(instances)])
        tcp_free = all(is_free(port, "TCP") for port in ports.tcp)
        if tcp_free and all(map(is_free, ports.udp)):
            yield ports
