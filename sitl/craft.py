"""A vehicle under its commander: what the links of a simulator steer and report on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from sitl.autopilot.commander import Commander, CommanderState
from sitl.autopilot.copter import Copter
from sitl.autopilot.copter_memory import CopterState
from sitl.clock import FRAME_US
from sitl.faults import Fault, LinkFault
from sitl.link.parameters import ParameterTable, TableState
from sitl.link.report import Report
from sitl.link.signing import Signing
from sitl.orders import Order, Verdict
from sitl.params import Params
from sitl.plans import MissionRun, Plans
from sitl.signals import Demand, FloatArray, GeoPoint, Setpoint, Sticks
from sitl.status import FlightStatus, Notice
from sitl.vehicle import Vehicle, VehicleConfig, VehicleState

__all__ = ["Craft", "CraftState", "Event", "SimulatorConfig"]


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


@dataclass(frozen=True, slots=True, eq=False)
class CraftState:
    """A craft's whole state, as a value."""

    vehicle: VehicleState
    commander: CommanderState | CopterState
    parameters: TableState
    uploading: bool


def _brain(config: SimulatorConfig, params: Params) -> tuple[ParameterTable, Commander | Copter]:
    """The autopilot's parameters, and its commander that obeys them."""
    if config.autopilot == "px4":
        table = ParameterTable(params)
        return table, Commander(table, config.loss_scale)
    from sitl.link.ardupilot_parameters import CopterTable

    table = CopterTable(params, config.vehicle.airframe, config.instance + 1)
    return table, Copter(table)


class Craft:
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

    def live(self, until_us: int, demand: Demand) -> None:
        """Do what the commander asks, until then or until something happens that it must see; for a frame at least."""
        until_us = max(until_us, self.time_us + FRAME_US)
        self.vehicle.advance(until_us, demand, alert=True, onward=self.commander.onward)
        self.time_us = self.vehicle.time_us
        self.run = self.commander.run
        self._watch()

    def link_faults(self) -> list[LinkFault]:
        """Those that the links suffer from now."""
        faults = self.vehicle.faults
        return [fault for fault in faults if isinstance(fault, LinkFault) and fault.active(self.time_us)]

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

    def hear_sticks(self, sticks: Sticks) -> None:
        """Take a pilot's sticks; an ArduCopter does not."""
        if isinstance(self.commander, Commander):
            self.commander.hear_sticks(sticks, self.time_us)

    def hear_channels(self, pulses_us: Mapping[int, int]) -> None:
        """Take what a ground station puts on a radio's channels; a PX4 does not."""
        if isinstance(self.commander, Copter):
            self.commander.hear_channels(pulses_us, self.time_us)

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

    def snapshot(self) -> CraftState:
        """The whole state, as a value, but for the events."""
        commander = self.commander.snapshot()
        return CraftState(self.vehicle.snapshot(), commander, self.parameters.snapshot(), self.uploading)

    def restore(self, state: CraftState) -> None:
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
