"""The rules of OFFBOARD: which setpoints can be flown, and what follows when they stay away."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sitl.orders import Mode
from sitl.signals import Setpoint

__all__ = ["commands_every_axis", "lost_us", "mode_after_loss"]

_LOSS_SEEN_US = 60_000
"""PX4 notices lost setpoints this much after COM_OF_LOSS_T: 1.05 s was seen, and 0.95 Hz still held."""
_RC_LOSS_MODES = {1: Mode.HOLD, 2: Mode.RETURN, 3: Mode.LAND}
"""NAV_RCL_ACT: what follows where there is no radio control."""
_OFFBOARD_LOSS_MODES = {3: Mode.RETURN, 4: Mode.LAND, 5: Mode.HOLD}
"""COM_OBL_RC_ACT. Its other values are modes for a pilot with sticks: without them NAV_RCL_ACT decides."""


def lost_us(last_us: int | None, limit_s: float) -> float:
    """Until when setpoints still come, as far as anybody can tell, after the last one."""
    return -math.inf if last_us is None else last_us + 1e6 * limit_s + _LOSS_SEEN_US


def mode_after_loss(mode: Mode, parameters: Mapping[str, float]) -> Mode:
    """What a vehicle without radio control does when that mode's setpoints stay away, or a joystick's sticks."""
    by_rc = _RC_LOSS_MODES.get(int(parameters["NAV_RCL_ACT"]), Mode.RETURN)
    if mode is Mode.POSITION:
        return by_rc
    return _OFFBOARD_LOSS_MODES.get(int(parameters["COM_OBL_RC_ACT"]), by_rc)


def commands_every_axis(setpoint: Setpoint) -> bool:
    """Whether each axis has a position, speed or acceleration, north and east in pairs, as PX4 demands.

    An attitude with its thrust commands them all.
    """
    *kinds, _, _, attitude = setpoint
    if attitude is not None or math.isfinite(sum(map(sum, kinds))):
        return True
    horizontal = vertical = False
    for kind in kinds:
        north, east, down = map(math.isfinite, kind)
        if north != east:
            return False
        horizontal |= north
        vertical |= down
    return horizontal and vertical
