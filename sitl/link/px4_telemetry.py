"""What a PX4 link tells unasked, at rates that the other end may change, and what it tells when asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import common

from sitl.link.codec import Received
from sitl.link.commands import Command, answered, whole_number
from sitl.link.events import EVENTS
from sitl.link.gimbal import GIMBAL, GIMBAL_RATES_HZ
from sitl.link.helm import Helm
from sitl.link.instruments import INSTRUMENTS
from sitl.link.messages import Message, message_type
from sitl.link.missions import PROGRESS
from sitl.link.mode_list import AVAILABLE_MODES, listed
from sitl.link.px4_status import PX4_MODES, STATUS
from sitl.link.report import Report
from sitl.link.streams import Schedule, Streams
from sitl.link.telemetry import TELEMETRY, Builder

__all__ = ["TELEMETRY_COMMANDS", "Px4Telemetry", "TelemetryState"]

_HEARTBEAT = message_type("HEARTBEAT")
_PING = message_type("PING")
_TIMESYNC = message_type("TIMESYNC")
_MESSAGE_INTERVAL = message_type("MESSAGE_INTERVAL")
_GPS_GLOBAL_ORIGIN = message_type("GPS_GLOBAL_ORIGIN")

_BUILDERS: Mapping[int, Builder] = {
    kind.ID: builder for kind, builder in {**TELEMETRY, **INSTRUMENTS, **STATUS, **PROGRESS, **EVENTS}.items()
}
_NAMES_OF_NOTHING = """
    SCALED_IMU2 SCALED_IMU3 SCALED_PRESSURE2 SCALED_PRESSURE3 GPS2_RAW GPS_STATUS EFI_STATUS RAW_RPM WIND_COV
    ACTUATOR_OUTPUT_STATUS HIL_ACTUATOR_CONTROLS HIL_STATE_QUATERNION RC_CHANNELS MANUAL_CONTROL CAMERA_TRIGGER
    ATT_POS_MOCAP OPTICAL_FLOW_RAD OBSTACLE_DISTANCE ADSB_VEHICLE COLLISION FLIGHT_INFORMATION NAV_CONTROLLER_OUTPUT
    NAMED_VALUE_FLOAT DEBUG DEBUG_VECT DEBUG_FLOAT_ARRAY POSITION_TARGET_GLOBAL_INT
"""
_SILENT = frozenset(message_type(name).ID for name in _NAMES_OF_NOTHING.split())
"""PX4's other streams: an interval is taken, as PX4 takes it, and nothing comes, as where nothing is published."""
_HEARTBEAT_LIMIT_US = 1e6
"""Nobody switches HEARTBEAT off or makes it rarer than PX4 sends it: the vehicle would seem to be gone."""


@dataclass(frozen=True, slots=True)
class TelemetryState:
    """All that a link's telemetry remembers."""

    schedule: Schedule
    told_origin: Message | None
    ping_sequence: int


class Px4Telemetry:
    """The messages of one link; with `camera`, of a vehicle that carries one on a gimbal."""

    def __init__(self, rates_hz: Mapping[str, float], *, camera: bool) -> None:
        self._builders = {**_BUILDERS, **GIMBAL} if camera else _BUILDERS
        self._streamed: Mapping[int, Builder] = {
            **self._builders,
            _PING.ID: self._next_ping,
            _TIMESYNC.ID: _timesync,
            _GPS_GLOBAL_ORIGIN.ID: self._new_origin,
        }
        self.streams = Streams({**rates_hz, **GIMBAL_RATES_HZ} if camera else rates_hz)
        self._told_origin: Message | None = None
        self._ping_sequence = 0

    def due(self, helm: Helm) -> list[Message]:
        """The messages to send now. Each call uses them up."""
        due = self.streams.due(helm.time_us)
        if not due:
            return []
        report, streamed = helm.report(), self._streamed
        return [told for message_id in due if (told := streamed[message_id](report)) is not None]

    def origin(self, helm: Helm) -> Message | None:
        """GPS_GLOBAL_ORIGIN, once there is one."""
        return self._builders[_GPS_GLOBAL_ORIGIN.ID](helm.report())

    def snapshot(self) -> TelemetryState:
        """All that it remembers."""
        return TelemetryState(self.streams.snapshot(), self._told_origin, self._ping_sequence)

    def restore(self, state: TelemetryState) -> None:
        """Go on from a snapshot."""
        self.streams.restore(state.schedule)
        self._told_origin, self._ping_sequence = state.told_origin, state.ping_sequence

    def _next_ping(self, report: Report) -> Message:
        self._ping_sequence = self._ping_sequence + 1 & 0xFFFFFFFF
        return _PING(report.time_us, self._ping_sequence, 0, 0)

    def _new_origin(self, report: Report) -> Message | None:
        """GPS_GLOBAL_ORIGIN, where it has moved."""
        message = self._builders[_GPS_GLOBAL_ORIGIN.ID](report)
        if message is None or message[:3] == self._told_origin:
            return None
        self._told_origin = message[:3]
        return message

    def _request(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        if whole_number(command.param1) == AVAILABLE_MODES.ID:
            modes = listed(PX4_MODES, whole_number(command.param2) if math.isfinite(command.param2) else 0)
            result = common.MAV_RESULT_ACCEPTED if modes else common.MAV_RESULT_DENIED
            return [*modes, answered(command.number, result, received)]
        builder = self._builders.get(whole_number(command.param1))
        message = None if builder is None else builder(helm.report())
        if message is None:
            return [answered(command.number, common.MAV_RESULT_DENIED, received)]
        return [message, answered(command.number, common.MAV_RESULT_ACCEPTED, received)]

    def _request_named(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        """The old commands that ask for one message each."""
        wanted = command._replace(param1=float(_REQUESTED_BY[command.number]))
        return self._request(wanted, received, helm)

    def _set_interval(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        message_id = whole_number(command.param1)
        if message_id in _SILENT:
            return [answered(command.number, common.MAV_RESULT_ACCEPTED, received)]
        unknown = message_id not in self._streamed
        silenced = message_id == _HEARTBEAT.ID and not 0.0 <= command.param2 <= _HEARTBEAT_LIMIT_US
        if unknown or silenced:
            return [answered(command.number, common.MAV_RESULT_FAILED, received)]
        self.streams.set_interval_us(message_id, command.param2, helm.time_us)
        return [answered(command.number, common.MAV_RESULT_ACCEPTED, received)]

    def _get_interval(self, command: Command, received: Received, _: Helm) -> list[Message]:
        message_id = whole_number(command.param1)
        interval = _MESSAGE_INTERVAL(self.streams.interval_us(message_id), message_id & 0xFFFF)
        return [interval, answered(command.number, common.MAV_RESULT_ACCEPTED, received)]


def _timesync(report: Report) -> Message:
    """PX4's own question for the time at the other end."""
    return _TIMESYNC(0, report.time_us * 1000)


_REQUESTED_BY: Mapping[int, int] = {
    common.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: message_type("AUTOPILOT_VERSION").ID,
    common.MAV_CMD_REQUEST_PROTOCOL_VERSION: message_type("PROTOCOL_VERSION").ID,
    common.MAV_CMD_GET_HOME_POSITION: message_type("HOME_POSITION").ID,
}
TELEMETRY_COMMANDS: Mapping[int, Callable[[Px4Telemetry, Command, Received, Helm], list[Message]]] = {
    common.MAV_CMD_REQUEST_MESSAGE: Px4Telemetry._request,
    **dict.fromkeys(_REQUESTED_BY, Px4Telemetry._request_named),
    common.MAV_CMD_SET_MESSAGE_INTERVAL: Px4Telemetry._set_interval,
    common.MAV_CMD_GET_MESSAGE_INTERVAL: Px4Telemetry._get_interval,
}
"""The commands that ask for messages, and what answers them."""
