"""What the commander sees of its vehicle."""

from __future__ import annotations

from typing import Protocol

from sitl.signals import Estimate, FloatArray, GeoPoint, GpsSample

__all__ = [
    "Battery",
    "Condition",
]


class Battery(Protocol):
    """The pack as its monitor sees it."""

    @property
    def voltage_v(self) -> float:
        """At the terminals."""

    @property
    def current_a(self) -> float:
        """Drawn now."""

    @property
    def used_ah(self) -> float:
        """Drawn since the start."""

    @property
    def remaining(self) -> float:
        """What is left, 0…1."""


class Condition(Protocol):
    """What the commander sees of its vehicle now. Each look costs something: it looks when it must."""

    @property
    def time_us(self) -> int:
        """Since the start."""

    @property
    def estimate(self) -> Estimate:
        """What the vehicle believes."""

    @property
    def origin(self) -> GeoPoint | None:
        """Where the estimate's frame is anchored, once that is known."""

    @property
    def knows_position(self) -> bool:
        """Whether a position may be flown to: the estimate's `position_ok`."""

    @property
    def charge_left(self) -> float:
        """What is left in the battery, 0…1."""

    @property
    def on_ground(self) -> bool:
        """The land detector's verdict."""

    @property
    def battery(self) -> Battery:
        """The pack."""

    @property
    def gps(self) -> GpsSample | None:
        """The fix that came last; None while there are none."""

    @property
    def fix_age_us(self) -> int:
        """How long ago the filter used a fix."""

    @property
    def attitude_wanted(self) -> FloatArray:
        """What the cascade steers to, `q_ned_frd`."""
