"""The pack: charge drawn by the rotors' shaft power, a straight open-circuit line, a resistance.

Terminal voltage u and current i satisfy u = E - R i and u i = P, so i = (E - √(E² - 4 R P)) / 2R.
"""

from __future__ import annotations

import math

import numpy as np

from sitl.airframe import Airframe
from sitl.kernels import kernel

__all__ = ["PACK", "drain", "new_pack"]

PACK = np.dtype(
    [
        ("used_ah", "f8"),
        ("voltage_v", "f8"),
        ("current_a", "f8"),
        ("capacity_ah", "f8"),
        ("full_v", "f8"),
        ("empty_v", "f8"),
        ("resistance_ohm", "f8"),
        ("efficiency", "f8"),
        ("avionics_w", "f8"),
    ]
)


def new_pack(airframe: Airframe) -> np.ndarray:
    """One PACK, full."""
    packs, sheet = np.zeros(1, PACK), airframe.battery
    pack = packs[0]
    pack["capacity_ah"] = sheet.capacity_ah
    pack["full_v"] = pack["voltage_v"] = sheet.cells * sheet.cell_full_v
    pack["empty_v"] = sheet.cells * sheet.cell_empty_v
    pack["resistance_ohm"] = sheet.resistance_ohm
    pack["efficiency"] = sheet.motor_efficiency
    pack["avionics_w"] = sheet.avionics_w
    return packs


@kernel
def drain(pack: np.record, shaft_power_w: float, dt_s: float) -> None:
    """Draw the rotors' shaft power for `dt_s`; an empty pack keeps its last voltage."""
    left = max(0.0, 1.0 - pack.used_ah / pack.capacity_ah)
    open_v = pack.empty_v + left * (pack.full_v - pack.empty_v)
    power = shaft_power_w / pack.efficiency + pack.avionics_w
    room = max(0.0, open_v * open_v - 4.0 * pack.resistance_ohm * power)
    current = (open_v - math.sqrt(room)) / (2.0 * pack.resistance_ohm)
    pack.current_a = current
    pack.voltage_v = open_v - pack.resistance_ohm * current
    pack.used_ah += current * dt_s / 3600.0
