"""What PX4 does with a command, and how it answers; those that ask for messages are `px4_telemetry`'s."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import common

from sitl.link.codec import Received
from sitl.link.commands import ORDERS, RESULTS, Command, answered, whole_number
from sitl.link.failures import begun_by, ended_by
from sitl.link.gimbal import claimed
from sitl.link.helm import Helm
from sitl.link.messages import Message
from sitl.link.px4_status import MODE_OF_CODE, MODES_NOT_FLOWN
from sitl.orders import SwitchMode, WishMode

__all__ = ["CommandService", "switch_mode"]

_CUSTOM_MODE = 1
"""MAV_MODE_FLAG_CUSTOM_MODE_ENABLED."""


@dataclass(slots=True)
class CommandService:
    """The commands of one link. `verdicts` are answers that come a frame later."""

    verdicts: tuple[Message, ...] = ()

    def receive(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        """Carry out the command; what is answered at once."""
        special = _COMMANDS.get(command.number)
        if special is not None:
            return special(self, command, received, helm)
        if command.number in _NOTHING_TO_DO:
            result = _NOTHING_TO_DO[command.number](command)
            return [answered(command.number, result, received)]
        order_of = ORDERS.get(command.number)
        if order_of is None:
            return [answered(command.number, common.MAV_RESULT_UNSUPPORTED, received)]
        if command.number == common.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE:
            command = claimed(command, received)
        order = order_of(command, helm.report().flight)
        result = common.MAV_RESULT_DENIED if order is None else RESULTS[helm.obey(order)]
        return [answered(command.number, result, received)]

    def take_verdicts(self) -> tuple[Message, ...]:
        """The verdicts since the last call."""
        verdicts, self.verdicts = self.verdicts, ()
        return verdicts

    def _set_mode(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        """PX4's receiver says yes at once. Its commander says what came of it a frame (10 ms) later."""
        code = _byte(command.param2), _byte(command.param3)
        verdict = answered(command.number, switch_mode(_byte(command.param1), code, helm), received)
        self.verdicts = (*self.verdicts, verdict)
        return [answered(command.number, common.MAV_RESULT_ACCEPTED, received)]

    def _inject_failure(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        """Only where SYS_FAILURE_EN allows it, as in PX4."""
        begun, ended = begun_by(command, helm.time_us), ended_by(command)
        if not helm.parameters["SYS_FAILURE_EN"]:
            result = common.MAV_RESULT_DENIED
        elif not begun and not ended:
            result = common.MAV_RESULT_UNSUPPORTED
        else:
            result = common.MAV_RESULT_ACCEPTED
            for fault in begun:
                helm.inject(fault)
            for kind in ended:
                helm.heal(kind)
        return [answered(command.number, result, received)]


def switch_mode(base_mode: int, code: tuple[int, int], helm: Helm) -> int:
    """The result of asking for a mode. One that is not known does nothing, and yet PX4 says yes."""
    mode = MODE_OF_CODE.get(code) if base_mode & _CUSTOM_MODE else None
    if mode is not None:
        return int(RESULTS[helm.obey(SwitchMode(mode))])
    name = MODES_NOT_FLOWN.get(code) if base_mode & _CUSTOM_MODE else None
    return int(common.MAV_RESULT_ACCEPTED if name is None else RESULTS[helm.obey(WishMode(name))])


def _byte(value: float) -> int:
    """A parameter as PX4 casts it; one that is left out counts as zero."""
    return int(value) & 0xFF if math.isfinite(value) else 0


_NOTHING_TO_DO: Mapping[int, Callable[[Command], int]] = {
    # No output has that function here, as none has in PX4's SIH; PX4 says yes all the same.
    common.MAV_CMD_DO_SET_ACTUATOR: lambda _: int(common.MAV_RESULT_ACCEPTED),
    # PX4's SITL has no way to reboot, and says so; not to reboot it can.
    common.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: lambda command: int(
        common.MAV_RESULT_DENIED if whole_number(command.param1) else common.MAV_RESULT_ACCEPTED
    ),
}
"""Commands that PX4 only answers: with this."""
_COMMANDS: Mapping[int, Callable[[CommandService, Command, Received, Helm], list[Message]]] = {
    common.MAV_CMD_DO_SET_MODE: CommandService._set_mode,
    common.MAV_CMD_INJECT_FAILURE: CommandService._inject_failure,
}
