"""The simulator: a vehicle, its commander and its links on one simulated clock. No socket, no wall clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from sitl.autopilot.commander import Commander, CommanderState
from sitl.autopilot.copter import Copter
from sitl.autopilot.copter_memory import CopterState
from sitl.faults import Fault, LinkFault
from sitl.link.channel import Channel, ChannelState
from sitl.link.parameters import ParameterTable, TableState
from sitl.link.px4 import Px4Link, Px4LinkState
from sitl.link.report import Report
from sitl.link.signing import Signer, SignerState, Signing
from sitl.link.streams import GCS_RATES_HZ, OFFBOARD_RATES_HZ
from sitl.orders import FlightStatus, Notice, Order, Verdict
from sitl.params import Params
from sitl.plans import MissionRun, Plans
from sitl.signals import Estimate, FloatArray, GeoPoint, Setpoint, TruthState
from sitl.vehicle import FRAME_US, Vehicle, VehicleConfig, VehicleState

if TYPE_CHECKING:
    from sitl.link.ardupilot import ArduPilotLink, ArduPilotLinkState

__all__ = ["Event", "Simulator", "SimulatorConfig", "SimulatorState", "Step"]

_OFFBOARD = 0
_LINK_DICE = 0x4C494E4B
"""Sets the links' random streams apart from the senses'."""
_LINK_RATES_HZ: tuple[Mapping[str, float], ...] = (OFFBOARD_RATES_HZ, GCS_RATES_HZ)
_SERIAL_PORTS_N = 4
"""ArduPilot's: three for TCP, of which the first is the console, and the one of the ground station's UDP."""


@dataclass(frozen=True, slots=True)
class SimulatorConfig:
    """Everything that decides a flight besides the bytes that come in.

    `loss_scale` stretches the time after which setpoints count as lost: PX4 sets it to its speed-up. With `signing`
    the links sign what they send and take nothing that is not signed. With `camera` a camera on a gimbal answers.
    """

    vehicle: VehicleConfig
    autopilot: Literal["px4", "ardupilot"] = "px4"
    instance: int = 0
    loss_scale: float = 1.0
    signing: Signing | None = None
    camera: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """Something worth a line: `kind` is "mode", "armed", "disarmed" or "notice"."""

    time_us: int
    kind: Literal["mode", "armed", "disarmed", "notice"]
    text: str


@dataclass(frozen=True, slots=True)
class Step:
    """What came of a step: bytes to send, when to come back at the latest, and what happened."""

    send: bytes
    next_due_us: int
    events: tuple[Event, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SimulatorState:
    """A simulator's whole state, as a value."""

    vehicle: VehicleState
    commander: CommanderState | CopterState
    parameters: TableState
    links: tuple[Px4LinkState | ArduPilotLinkState, ...]
    channels: tuple[ChannelState, ...]
    uploading: bool
    signer: SignerState | None


class Simulator:
    """A quadrotor at the other end of MAVLink links: PX4's offboard link and GCS's, or ArduPilot's serial ports."""

    def __init__(self, config: SimulatorConfig) -> None:
        self.config = config
        self._craft = _Craft(config)
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
        outs = [bytearray() for _ in links]
        while craft.time_us + FRAME_US <= now_us:
            craft.advance()
            for link, out in zip(links, outs, strict=True):
                out += link.send(craft)
            if craft.commander.has_news:
                self._tell(outs)
        ill = [f for f in craft.vehicle.faults if isinstance(f, LinkFault) and f.active(craft.time_us)]
        self._impaired |= bool(ill)
        if self._impaired:
            received = _carried(self._uplinks, craft.time_us, received, ill)
        for link, data, out in zip(links, received, outs, strict=True):
            if data:
                out += link.receive(data, craft)
        self._forward(outs)
        if craft.commander.has_news:
            self._tell(outs)
        sent = tuple(map(bytes, outs))
        return _carried(self._downlinks, craft.time_us, sent, ill) if self._impaired else sent

    def inject(self, fault: Fault) -> None:
        """Have that go wrong too, from its start or, if that has passed, from now."""
        self._craft.inject(fault)

    def heal(self, kind: type[Fault]) -> None:
        """End all faults of that kind."""
        self._craft.heal(kind)

    def take_events(self) -> tuple[Event, ...]:
        """What happened since the last call; `step` calls it."""
        events, self._craft.events = tuple(self._craft.events), []
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
        craft = self._craft
        return SimulatorState(
            craft.vehicle.snapshot(),
            craft.commander.snapshot(),
            craft.parameters.snapshot(),
            tuple(link.snapshot() for link in self._links),
            tuple(channel.snapshot() for channel in (*self._uplinks, *self._downlinks)),
            craft.uploading,
            None if self._signer is None else self._signer.snapshot(),
        )

    def restore(self, state: SimulatorState) -> None:
        """Become again what `snapshot` saw."""
        self._craft.restore(state)
        if self._signer is not None and state.signer is not None:
            self._signer.restore(state.signer)
        for link, link_state in zip(self._links, state.links, strict=True):
            link.restore(link_state)  # type: ignore[arg-type]  # a twin by config gave it
        for channel, channel_state in zip((*self._uplinks, *self._downlinks), state.channels, strict=True):
            channel.restore(channel_state)
        self._impaired = True  # something may be

    def _forward(self, outs: list[bytearray]) -> None:
        """Pass heartbeats on from the ground station's link, as PX4's start script has it."""
        offboard = self._links[_OFFBOARD]
        if not isinstance(offboard, Px4Link):
            return
        for source in self._links[: len(outs)]:
            assert isinstance(source, Px4Link)
            heartbeats = source.take_heartbeats()
            if source is not offboard:
                outs[_OFFBOARD] += b"".join(map(offboard.forward, heartbeats))

    def _tell(self, outs: list[bytearray]) -> None:
        for notice in self._craft.take_notices():
            for link, out in zip(self._links, outs, strict=False):
                out += link.tell(notice)
        for shot in self._craft.commander.take_shots():
            for link, out in zip(self._links, outs, strict=False):
                out += link.show(shot)


def _carried(
    channels: tuple[Channel, ...], now_us: int, data: Sequence[bytes], ill: Sequence[LinkFault]
) -> tuple[bytes, ...]:
    ways = zip(channels, data, strict=False)  # there may be more channels than links that are used
    return tuple(channel.carry(now_us, chunk, ill) for channel, chunk in ways)


def _links(config: SimulatorConfig, signer: Signer | None) -> tuple[Px4Link | ArduPilotLink, ...]:
    system = config.instance + 1
    if config.autopilot == "px4":
        return tuple(Px4Link(system, rates_hz, signer, camera=config.camera) for rates_hz in _LINK_RATES_HZ)
    from sitl.link.ardupilot import ArduPilotLink  # its dialect's tables take a while to load

    return tuple(ArduPilotLink(system, signer, greets=port == 0) for port in range(_SERIAL_PORTS_N))


def _brain(config: SimulatorConfig, params: Params) -> tuple[ParameterTable, Commander | Copter]:
    """The autopilot's parameters, and its commander that obeys them."""
    if config.autopilot == "px4":
        table = ParameterTable(params)
        return table, Commander(table, config.loss_scale)
    from sitl.link.ardupilot_parameters import CopterTable

    table = CopterTable(params, config.instance + 1, config.vehicle.airframe.battery.capacity_ah)
    return table, Copter(table)


class _Craft:
    """A vehicle under its commander: the helm that the links hold."""

    def __init__(self, config: SimulatorConfig) -> None:
        params = config.vehicle.params.replace(MAV_SYS_ID=config.instance + 1)
        self.parameters, self.commander = _brain(config, params)
        self.vehicle = Vehicle(replace(config.vehicle, params=self.parameters.vehicle_params))
        self.events: list[Event] = []
        self.uploading = False
        self.run: MissionRun = self.commander.run
        self.time_us = self.vehicle.time_us
        self._armed, self._mode = self.commander.armed, self.commander.mode

    def advance(self) -> None:
        """Live for a frame."""
        until_us = self.time_us + FRAME_US
        self.vehicle.advance(until_us, self.commander.command(self.vehicle))
        self.time_us = until_us
        self.run = self.commander.run
        self._watch()

    @property
    def plans(self) -> Plans:
        """What has been uploaded."""
        return self.commander.plans

    def obey(self, order: Order) -> Verdict:
        """Carry out the order, or not."""
        verdict = self.commander.obey(order, self.vehicle)
        self.run = self.commander.run
        self._watch()
        return verdict

    def steer(self, setpoint: Setpoint) -> None:
        """Take an OFFBOARD setpoint."""
        self.commander.steer(setpoint, self.vehicle)

    def hear_ground_station(self) -> None:
        """The ground station is there."""
        self.commander.hear_ground_station(self.time_us)

    def move_origin(self, point: GeoPoint) -> None:
        """Anchor the estimate's frame there, and home in it; PX4 does so in flight too, where nothing is moved here."""
        if isinstance(self.commander, Commander) and not self.commander.armed:
            self.vehicle.move_origin(point)
            self.commander.hear_of_origin(self.vehicle)

    def attitude(self) -> FloatArray:
        """The attitude `q_ned_frd`, as estimated."""
        return self.vehicle.estimate.q_ned_frd

    def set_parameter(self, name: str, value: float) -> None:
        """Change a parameter of the vehicle, its commander, or both."""
        self.parameters.set(name, value)
        self.vehicle.params = self.parameters.vehicle_params

    def inject(self, fault: Fault) -> None:
        """Have that go wrong too."""
        self.vehicle.inject(fault)

    def heal(self, kind: type[Fault]) -> None:
        """End all faults of that kind."""
        self.vehicle.heal(kind)

    def report(self) -> Report:
        """All that there is to tell now."""
        return Report(self.time_us, self.vehicle.estimate, self.vehicle, self._flight_status)

    def _flight_status(self) -> FlightStatus:
        return self.commander.status(self.vehicle)

    def take_notices(self) -> tuple[Notice, ...]:
        """What the commander has to tell since the last call."""
        notices = self.commander.take_notices()
        self.events += [Event(notice.time_us, "notice", notice.text) for notice in notices]
        return notices

    def restore(self, state: SimulatorState) -> None:
        """Become again what the snapshot saw."""
        self.vehicle.restore(state.vehicle)
        self.commander.restore(state.commander)  # type: ignore[arg-type]  # a twin by config gave it
        self.parameters.restore(state.parameters)
        self.vehicle.params = self.parameters.vehicle_params
        self.events, self.uploading = [], state.uploading
        self.run = self.commander.run
        self.time_us = self.vehicle.time_us
        self._armed, self._mode = self.commander.armed, self.commander.mode

    def _watch(self) -> None:
        armed, mode = self.commander.armed, self.commander.mode
        if armed is not self._armed:
            self.events.append(Event(self.time_us, "armed" if armed else "disarmed", mode.name))
        if mode is not self._mode:
            self.events.append(Event(self.time_us, "mode", mode.name))
        self._armed, self._mode = armed, mode
