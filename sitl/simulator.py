"""The simulator: a vehicle, its commander and its links on one simulated clock. No socket, no wall clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sitl.clock import FRAME_US
from sitl.craft import Craft, CraftState, Event, SimulatorConfig
from sitl.faults import Fault, LinkFault
from sitl.link.channel import Channel, ChannelState
from sitl.link.px4 import Px4Link, Px4LinkState
from sitl.link.report import Report
from sitl.link.signing import Signer, SignerState
from sitl.link.streams import GCS_RATES_HZ, OFFBOARD_RATES_HZ
from sitl.signals import Estimate, TruthState

if TYPE_CHECKING:
    from sitl.link.ardupilot import ArduPilotLink, ArduPilotLinkState

__all__ = ["Event", "Simulator", "SimulatorConfig", "SimulatorState", "Step"]

_OFFBOARD = 0
_LINK_DICE = 0x4C494E4B
"""Sets the links' random streams apart from the senses'."""
_LINK_RATES_HZ: tuple[Mapping[str, float], ...] = (OFFBOARD_RATES_HZ, GCS_RATES_HZ)
_SERIAL_PORTS_N = 4
"""ArduPilot's: three for TCP, of which the first is the console, and the one of the ground station's UDP."""


class Step(NamedTuple):
    """What came of a step: bytes to send, when to come back at the latest, and what happened."""

    send: bytes
    next_due_us: int
    events: tuple[Event, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SimulatorState:
    """A simulator's whole state, as a value."""

    craft: CraftState
    links: tuple[Px4LinkState | ArduPilotLinkState, ...]
    channels: tuple[ChannelState, ...]
    signer: SignerState | None


class Simulator:
    """A quadrotor at the other end of MAVLink links: PX4's offboard link and GCS's, or ArduPilot's serial ports."""

    def __init__(self, config: SimulatorConfig) -> None:
        self.config = config
        self._craft = Craft(config)
        self._signer = None if config.signing is None else Signer(config.signing)
        self._links: tuple[Px4Link | ArduPilotLink, ...] = _links(config, self._signer)
        dice = np.random.SeedSequence([config.vehicle.seed, _LINK_DICE]).spawn(2 * len(self._links))
        self._uplinks = tuple(map(Channel, dice[::2]))
        self._downlinks = tuple(map(Channel, dice[1::2]))
        self._impaired = False  # since some link fault first struck: until then nothing is ever under way

    def step(self, now_us: int, received: bytes) -> Step:
        """Live until `now_us` in whole frames, then take what came in on the first link."""
        (send,) = self.exchange(now_us, (received,))
        return Step(send, self.time_us + FRAME_US, self.take_events())

    def exchange(self, now_us: int, received: tuple[bytes, ...]) -> tuple[bytes, ...]:
        """As `step`, for as many links as there are entries. The links beyond stay silent.

        Link faults take hold once a call: of what comes in, and of all that is sent since the last one.
        """
        craft, links = self._craft, self._links[: len(received)]
        commander, vehicle = craft.commander, craft.vehicle
        outs = [b""] * len(links)
        while craft.time_us + FRAME_US <= now_us:
            demand = commander.command(vehicle)
            until_us = min(now_us, commander.holds_until_us, *[link.due_us(craft) for link in links])
            craft.live(until_us, demand)
            for port, link in enumerate(links):
                outs[port] += link.send(craft)
            if commander.has_news:
                self._tell(outs)
        ill = craft.link_faults() if vehicle.faults else ()
        self._impaired |= bool(ill)
        if self._impaired:
            received = _carried(self._uplinks, craft.time_us, received, ill)
        for port, data in enumerate(received):
            if data:
                outs[port] += links[port].receive(data, craft)
        if len(links) > 1:
            self._forward(outs)
        if commander.has_news:
            self._tell(outs)
        return _carried(self._downlinks, craft.time_us, outs, ill) if self._impaired else tuple(outs)

    def inject(self, fault: Fault) -> None:
        """Have that go wrong too, from its start or, if that has passed, from now."""
        self._craft.inject(fault)

    def heal(self, kind: type[Fault]) -> None:
        """End all faults of that kind."""
        self._craft.heal(kind)

    def take_events(self) -> tuple[Event, ...]:
        """What happened since the last call; `step` calls it."""
        events = tuple(self._craft.events)
        self._craft.events.clear()
        return events

    @property
    def time_us(self) -> int:
        """Simulated time: whole frames."""
        return self._craft.time_us

    @property
    def truth(self) -> TruthState:
        """What really is, for whoever judges the flight."""
        return self._craft.vehicle.truth

    @property
    def estimate(self) -> Estimate:
        """What the vehicle believes."""
        return self._craft.vehicle.estimate

    @property
    def report(self) -> Report:
        """What the vehicle believes and says of itself."""
        return self._craft.report()

    @property
    def refused(self) -> int:
        """How many frames came that were not signed, or wrongly, or replayed."""
        return 0 if self._signer is None else self._signer.refused

    @property
    def parameters(self) -> Mapping[str, float]:
        """What the vehicle's parameters are now, by PX4's names."""
        return self._craft.parameters

    def snapshot(self) -> SimulatorState:
        """The whole state, as a value. Take the events first: they are not part of it."""
        return SimulatorState(
            self._craft.snapshot(),
            tuple(link.snapshot() for link in self._links),
            tuple(channel.snapshot() for channel in (*self._uplinks, *self._downlinks)),
            None if self._signer is None else self._signer.snapshot(),
        )

    def restore(self, state: SimulatorState) -> None:
        """Become again what `snapshot` saw."""
        self._craft.restore(state.craft)
        if self._signer is not None and state.signer is not None:
            self._signer.restore(state.signer)
        for link, link_state in zip(self._links, state.links, strict=True):
            link.restore(link_state)  # type: ignore[arg-type]  # a twin by config gave it
        for channel, channel_state in zip((*self._uplinks, *self._downlinks), state.channels, strict=True):
            channel.restore(channel_state)
        self._impaired = True  # something may be

    def _forward(self, outs: list[bytes]) -> None:
        """Pass heartbeats on from the ground station's link, as PX4's start script has it."""
        offboard = self._links[_OFFBOARD]
        if not isinstance(offboard, Px4Link):
            return
        for source in self._links[_OFFBOARD + 1 : len(outs)]:
            assert isinstance(source, Px4Link)
            for heartbeat in source.take_heartbeats():
                outs[_OFFBOARD] += offboard.forward(heartbeat)

    def _tell(self, outs: list[bytes]) -> None:
        notices, shots = self._craft.take_notices(), self._craft.commander.take_shots()
        for port, link in enumerate(self._links[: len(outs)]):
            outs[port] += b"".join((*map(link.tell, notices), *map(link.show, shots)))


def _carried(
    channels: tuple[Channel, ...], now_us: int, data: Sequence[bytes], ill: Sequence[LinkFault]
) -> tuple[bytes, ...]:
    ways = zip(channels, data, strict=False)  # there may be more channels than links that are used
    return tuple(channel.carry(now_us, chunk, ill) for channel, chunk in ways)


def _links(config: SimulatorConfig, signer: Signer | None) -> tuple[Px4Link | ArduPilotLink, ...]:
    system = config.instance + 1
    if config.autopilot == "px4":
        return tuple(
            Px4Link(system, rates_hz, signer, camera=config.camera, relayed=number != _OFFBOARD)
            for number, rates_hz in enumerate(_LINK_RATES_HZ)
        )
    from sitl.link.ardupilot import ArduPilotLink  # its dialect's tables take a while to load

    return tuple(ArduPilotLink(system, signer, greets=port == 0) for port in range(_SERIAL_PORTS_N))
