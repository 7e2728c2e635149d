"""How low the battery is, and what PX4 does about it (BAT_*_THR, COM_LOW_BAT_ACT)."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Final

from sitl.orders import Mode

__all__ = ["Charge", "answer_to", "charge_of"]


class Charge(IntEnum):
    """How low the battery is, as PX4 warns of it. It only ever gets worse."""

    FINE = 0
    LOW = 1
    CRITICAL = 2
    EMERGENCY = 3

    @property
    def advice(self) -> str:
        """What PX4 tells the pilot while nothing is done."""
        return _ADVICE[self]


_ADVICE: Final = {
    Charge.FINE: "",
    Charge.LOW: "Low battery level, return advised",
    Charge.CRITICAL: "Critical battery level, land now",
    Charge.EMERGENCY: "Emergency battery level, land immediately",
}
_BY_ACTION: Final[Mapping[int, Mapping[Charge, Mode]]] = {
    1: {Charge.CRITICAL: Mode.RETURN, Charge.EMERGENCY: Mode.RETURN},
    2: {Charge.CRITICAL: Mode.LAND, Charge.EMERGENCY: Mode.LAND},
    3: {Charge.CRITICAL: Mode.RETURN, Charge.EMERGENCY: Mode.LAND},
}
"""COM_LOW_BAT_ACT: return, land, or return and then land. 0 warns only."""


def charge_of(remaining: float, parameters: Mapping[str, float]) -> Charge:
    """The warning for what is left of the charge, 0…1."""
    if remaining < parameters["BAT_EMERGEN_THR"]:
        return Charge.EMERGENCY
    if remaining < parameters["BAT_CRIT_THR"]:
        return Charge.CRITICAL
    return Charge.LOW if remaining < parameters["BAT_LOW_THR"] else Charge.FINE


def answer_to(charge: Charge, parameters: Mapping[str, float]) -> Mode | None:
    """The mode that the warning leads to; None when there is only the warning."""
    return _BY_ACTION.get(int(parameters["COM_LOW_BAT_ACT"]), {}).get(charge)
