"""What all links of a vehicle share: the one way to touch it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from sitl.faults import Fault
from sitl.link.parameters import ParameterTable
from sitl.link.report import Report
from sitl.orders import Order, Verdict
from sitl.plans import MissionRun, Plans
from sitl.signals import FloatArray, GeoPoint, Setpoint, Sticks

__all__ = ["Helm"]


class Helm(Protocol):
    """What a link may touch of the vehicle behind it."""

    parameters: ParameterTable
    time_us: int
    uploading: bool
    """Whether one of the links is taking a plan."""
    run: MissionRun
    """How far the mission has come; the same object until it has come further."""

    @property
    def plans(self) -> Plans:
        """What has been uploaded."""

    def set_parameter(self, name: str, value: float) -> None:
        """Change a parameter, and whatever depends on it."""

    def obey(self, order: Order) -> Verdict:
        """Carry out the order, or not."""

    def steer(self, setpoint: Setpoint) -> None:
        """Take an OFFBOARD setpoint."""

    def inject(self, fault: Fault) -> None:
        """Have that go wrong too, from its start or, if that has passed, from now."""

    def heal(self, kind: type[Fault]) -> None:
        """End all faults of that kind."""

    def hear_sticks(self, sticks: Sticks) -> None:
        """Take a pilot's sticks."""

    def hear_channels(self, pulses_us: Mapping[int, int]) -> None:
        """Take what a ground station puts on a radio's channels, by their number; 0 lets go of one."""

    def hear_ground_station(self) -> None:
        """The ground station that the vehicle listens for is there."""

    def move_origin(self, point: GeoPoint) -> None:
        """Anchor the estimate's frame there; nothing while it is armed."""

    def attitude(self) -> FloatArray:
        """The attitude `q_ned_frd`, as estimated."""

    def report(self) -> Report:
        """All that there is to tell now."""
