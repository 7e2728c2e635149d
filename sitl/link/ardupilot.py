"""ArduCopter's dialect of MAVLink behaviour: one link of a vehicle, sans-I/O.

What ArduCopter 4.6.3 was seen to do is done here: it greets in plain text, sends only what it was asked for, and
says no with MAV_RESULT_FAILED. What the links share is the helm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from pymavlink.dialects.v20 import common

from sitl.link.ardupilot_commands import COPTER_ORDERS, INT_ONLY, INT_ORDERS
from sitl.link.ardupilot_missions import COPTER_MISSION_MESSAGES, COPTER_PROGRESS, CopterPlanService
from sitl.link.ardupilot_parameters import CopterParameterService
from sitl.link.ardupilot_status import (
    BOOT_US,
    COPTER_LISTED_MODES,
    COPTER_STATUS,
    MODE_OF_NUMBER,
    MODES_NOT_FLOWN,
    camera_feedback,
)
from sitl.link.ardupilot_sticks import manual_pulses_us, override_pulses_us
from sitl.link.ardupilot_streams import COPTER_RATES_HZ, FASTEST_HZ, stream_messages
from sitl.link.ardupilot_targets import attitude_target, global_target, local_target
from sitl.link.codec import Codec, CodecState, Received
from sitl.link.commands import Command, answered, command_of, whole_number
from sitl.link.files import FILE_MESSAGE, Files
from sitl.link.helm import Helm
from sitl.link.logs import LOG_REQUEST, no_logs
from sitl.link.messages import Message, MessageType, message_type
from sitl.link.mode_list import AVAILABLE_MODES, listed
from sitl.link.param_pack import param_file
from sitl.link.px4_status import status_texts
from sitl.link.report import Report
from sitl.link.signing import Signer
from sitl.link.streams import Schedule, Streams
from sitl.link.telemetry import Builder
from sitl.orders import Arm, SwitchMode, Verdict
from sitl.signals import Setpoint
from sitl.status import Home, Notice, Severity, Shot

__all__ = ["ArduPilotLink", "ArduPilotLinkState"]

GREETING = b"\r\n\r\nInit ArduCopter V4.6.3 (mavspiral)\r\n\r\nFree RAM: 131072\r\n"
"""What a console would show. A parser has to find its feet behind it."""

_HEARTBEAT = message_type("HEARTBEAT")
_LOCAL_TARGET = message_type("SET_POSITION_TARGET_LOCAL_NED")
_GLOBAL_TARGET = message_type("SET_POSITION_TARGET_GLOBAL_INT")
_ATTITUDE_TARGET = message_type("SET_ATTITUDE_TARGET")
_OVERRIDE = message_type("RC_CHANNELS_OVERRIDE")
_MANUAL_CONTROL = message_type("MANUAL_CONTROL")
_COMMAND_LONG = message_type("COMMAND_LONG")
_COMMAND_INT = message_type("COMMAND_INT")
_SET_MODE = message_type("SET_MODE")
_REQUEST_DATA_STREAM = message_type("REQUEST_DATA_STREAM")
_PARAMETER_MESSAGES = tuple(map(message_type, ("PARAM_REQUEST_LIST", "PARAM_REQUEST_READ", "PARAM_SET")))
_TIMESYNC = message_type("TIMESYNC")
_MESSAGE_INTERVAL = message_type("MESSAGE_INTERVAL")
_GPS_GLOBAL_ORIGIN = message_type("GPS_GLOBAL_ORIGIN")
_HOME_POSITION = message_type("HOME_POSITION")
_AUTOPILOT_VERSION = message_type("AUTOPILOT_VERSION")

_BUILDERS: Mapping[int, Builder] = {
    kind.ID: builder for kind, builder in {**COPTER_STATUS, **COPTER_PROGRESS}.items()
}
_ACCEPTED, _FAILED = common.MAV_RESULT_ACCEPTED, common.MAV_RESULT_FAILED
_DENIED, _UNSUPPORTED = common.MAV_RESULT_DENIED, common.MAV_RESULT_UNSUPPORTED
_RESULTS = {Verdict.ACCEPTED: _ACCEPTED, Verdict.NOT_NOW: _FAILED, Verdict.DENIED: _DENIED}
_HEARTBEAT_LIMIT_US = 1e6
_CUSTOM_MODE = 1
_OURS, _ANY = common.MAV_COMP_ID_AUTOPILOT1, common.MAV_COMP_ID_ALL


@dataclass(frozen=True, slots=True)
class ArduPilotLinkState:
    """All that a link remembers."""

    codec: CodecState
    schedule: Schedule
    parameters: CopterParameterService
    plans: CopterPlanService
    files: Files
    greets: bool
    told_home: Home | None
    text_number: int


class ArduPilotLink:
    """One serial port of an ArduCopter. The first one is the console too: it `greets`."""

    def __init__(self, system: int, signer: Signer | None = None, *, greets: bool) -> None:
        self._codec = Codec(system, _OURS, signer)
        self._streams = Streams(COPTER_RATES_HZ)
        self._parameters = CopterParameterService()
        self._plans = CopterPlanService()
        self._files = Files()
        self._greets = greets
        self._told_home: Home | None = None
        self._text_number = 0

    def receive(self, data: bytes, helm: Helm) -> bytes:
        """Take what came in, and say what is to be answered at once."""
        out = b""
        for received in self._codec.decode(data):
            handle = _HANDLERS.get(type(received.message))
            if handle is not None:
                for answer in handle(self, received, helm):
                    out += self._codec.encode(answer)
        return out

    def due_us(self, helm: Helm) -> int:
        """When there will be something to send unasked, unless something happens before; zero is at once."""
        if self._greets or self._plans.is_busy(helm) or self._files.is_busy:
            return 0
        return min(self._streams.next_us, self._parameters.due_us)

    def send(self, helm: Helm) -> bytes:
        """What is to be sent unasked in this frame."""
        out = b""
        if self._greets:
            self._greets, out = False, GREETING
        for message in self._parameters.proceed(helm.parameters, helm.time_us):
            out += self._codec.encode(message)
        for message in (*self._plans.proceed(helm), *self._files.proceed()):
            out += self._codec.encode(message)
        due = self._streams.due(helm.time_us)
        if due:
            report = helm.report()
            for message_id in due:
                if message_id == _TIMESYNC.ID:
                    out += self._codec.encode(_TIMESYNC(0, helm.time_us * 1000))
                    continue
                message = _BUILDERS[message_id](report)
                if message is not None:
                    out += self._codec.encode(message)
                if message_id == _HEARTBEAT.ID and report.flight.home is not self._told_home:
                    out += b"".join(map(self._codec.encode, self._whereabouts(helm)))
        return out

    def tell(self, notice: Notice) -> bytes:
        """The notice as text, for whoever listens; in parts when it is long."""
        texts, self._text_number = status_texts(notice, self._text_number)
        return b"".join(map(self._codec.encode, texts))

    def show(self, shot: Shot) -> bytes:
        """The picture that was taken, for whoever listens."""
        return self._codec.encode(camera_feedback(shot))

    def snapshot(self) -> ArduPilotLinkState:
        """All that this link remembers."""
        return ArduPilotLinkState(
            codec=self._codec.snapshot(),
            schedule=self._streams.snapshot(),
            parameters=replace(self._parameters),
            plans=replace(self._plans),
            files=replace(self._files),
            greets=self._greets,
            told_home=self._told_home,
            text_number=self._text_number,
        )

    def restore(self, state: ArduPilotLinkState) -> None:
        """Go on from a snapshot."""
        self._codec.restore(state.codec)
        self._streams.restore(state.schedule)
        self._parameters, self._plans = replace(state.parameters), replace(state.plans)
        self._files = replace(state.files)
        self._greets, self._told_home, self._text_number = state.greets, state.told_home, state.text_number

    def _whereabouts(self, helm: Helm) -> list[Message]:
        """GPS_GLOBAL_ORIGIN and HOME_POSITION, told again when home has moved."""
        report = helm.report()
        self._told_home = report.flight.home
        told = (_BUILDERS[_GPS_GLOBAL_ORIGIN.ID](report), _BUILDERS[_HOME_POSITION.ID](report))
        return [message for message in told if message is not None]

    def _addresses_us(self, message: Message) -> bool:
        return message.target_system in (self._codec.system, 0) and message.target_component in (_OURS, _ANY)

    def _on_heartbeat(self, received: Received, helm: Helm) -> list[Message]:
        if received.system == helm.parameters["SYSID_MYGCS"]:
            helm.hear_ground_station()
        return []

    def _on_local_target(self, received: Received, helm: Helm) -> list[Message]:
        return self._steer(received.message, local_target, helm)

    def _on_global_target(self, received: Received, helm: Helm) -> list[Message]:
        return self._steer(received.message, global_target, helm)

    def _on_attitude_target(self, received: Received, helm: Helm) -> list[Message]:
        target = attitude_target(received.message) if self._addresses_us(received.message) else None
        if target is not None:
            helm.steer(target)
        return []

    def _steer(
        self, message: Message, target_of: Callable[[Message, Report], Setpoint], helm: Helm
    ) -> list[Message]:
        if self._addresses_us(message):
            helm.steer(target_of(message, helm.report()))
        return []

    def _on_override(self, received: Received, helm: Helm) -> list[Message]:
        if self._addresses_us(received.message):
            self._hold(override_pulses_us(received.message), received, helm)
        return []

    def _on_manual_control(self, received: Received, helm: Helm) -> list[Message]:
        if received.message.target == self._codec.system:
            self._hold(manual_pulses_us(received.message, helm.parameters), received, helm)
        return []

    def _hold(self, pulses_us: dict[int, int], received: Received, helm: Helm) -> None:
        """Only the ground station may; and who does lives."""
        if received.system == helm.parameters["SYSID_MYGCS"]:
            helm.hear_channels(pulses_us)
            helm.hear_ground_station()

    def _on_parameter(self, received: Received, helm: Helm) -> list[Message]:
        if not self._addresses_us(received.message):
            return []
        return self._parameters.receive(received.message, helm.parameters, helm.set_parameter)

    def _on_plan(self, received: Received, helm: Helm) -> list[Message]:
        return self._plans.receive(received, helm) if self._addresses_us(received.message) else []

    def _on_file(self, received: Received, helm: Helm) -> list[Message]:
        if not self._addresses_us(received.message):
            return []
        return self._files.receive(received, lambda path: param_file(path, helm.parameters))

    def _on_log_list(self, received: Received, _: Helm) -> list[Message]:
        return no_logs() if self._addresses_us(received.message) else []

    def _on_timesync(self, received: Received, helm: Helm) -> list[Message]:
        timesync = received.message
        return [] if timesync.tc1 else [_TIMESYNC(helm.time_us * 1000, timesync.ts1)]

    def _on_set_mode(self, received: Received, helm: Helm) -> list[Message]:
        """Obeyed, but not answered."""
        message = received.message
        if message.target_system != self._codec.system:
            return []
        return self._switch(message.base_mode, message.custom_mode, helm)[1]

    def _on_data_stream(self, received: Received, helm: Helm) -> list[Message]:
        message = received.message
        if self._addresses_us(message) and helm.time_us >= BOOT_US:
            rate_hz = message.req_message_rate if message.start_stop else 0
            interval_us = 1e6 / min(rate_hz, FASTEST_HZ) if rate_hz else -1.0
            for message_id in stream_messages(message.req_stream_id):
                self._streams.set_interval_us(message_id, interval_us, helm.time_us)
        return []

    def _on_command(self, received: Received, helm: Helm) -> list[Message]:
        message = received.message
        if not self._addresses_us(message):
            return []
        command, frame = command_of(message), getattr(message, "frame", None)
        special = _COMMANDS.get(command.number)
        if special is not None:
            return special(self, command, received, helm)
        flight = helm.report().flight
        if frame is not None and command.number in INT_ORDERS:
            order = INT_ORDERS[command.number](command, flight, frame)
        elif command.number in COPTER_ORDERS and command.number not in INT_ONLY:
            order = COPTER_ORDERS[command.number](command, flight)
        else:
            return [answered(command.number, _UNSUPPORTED, received)]
        result = _FAILED if order is None else _RESULTS[helm.obey(order)]
        answers = [answered(command.number, result, received)]
        if isinstance(order, Arm) and result == _ACCEPTED:
            answers += self._whereabouts(helm)
        return answers

    def _do_set_mode(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        result, texts = self._switch(whole_number(command.param1), whole_number(command.param2), helm)
        return [*texts, answered(command.number, result, received)]

    def _switch(self, base_mode: int, number: int, helm: Helm) -> tuple[int, list[Message]]:
        if not base_mode & _CUSTOM_MODE or base_mode < 0:
            return _DENIED, []
        mode = MODE_OF_NUMBER.get(number)
        if mode is None:
            name = MODES_NOT_FLOWN.get(number)
            text = f"Mode change to {name} failed: not simulated" if name else f"No such mode {number}"
            return _FAILED, self._texts(text, helm)
        return _RESULTS[helm.obey(SwitchMode(mode))], []

    def _texts(self, text: str, helm: Helm) -> list[Message]:
        """A text for the one who asked."""
        notice = Notice(helm.time_us, Severity.WARNING, text)
        texts, self._text_number = status_texts(notice, self._text_number)
        return texts

    def _request_message(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        if whole_number(command.param1) == AVAILABLE_MODES.ID:
            modes = listed(COPTER_LISTED_MODES, whole_number(command.param2))
            return [answered(command.number, _ACCEPTED if modes else _FAILED, received), *modes]
        builder = _BUILDERS.get(whole_number(command.param1))
        message = None if builder is None else builder(helm.report())
        if message is None:
            return [answered(command.number, _FAILED, received)]
        return [answered(command.number, _ACCEPTED, received), message]

    def _request_version(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        return self._request_message(command._replace(param1=float(_AUTOPILOT_VERSION.ID)), received, helm)

    def _request_home(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        return self._request_message(command._replace(param1=float(_HOME_POSITION.ID)), received, helm)

    def _set_interval(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        message_id, interval_us = whole_number(command.param1), command.param2
        if message_id not in _BUILDERS and message_id != _TIMESYNC.ID:
            return [answered(command.number, _DENIED, received)]
        if message_id == _HEARTBEAT.ID and not 0.0 <= interval_us <= _HEARTBEAT_LIMIT_US:
            return [answered(command.number, _FAILED, received)]
        if 0.0 < interval_us < 1e6 / FASTEST_HZ:
            text = f"Requested rate ({1e6 / interval_us:.1f} Hz) too fast"
            return [*self._texts(text, helm), answered(command.number, _DENIED, received)]
        if helm.time_us >= BOOT_US:  # before, it says yes and forgets
            self._streams.set_interval_us(message_id, interval_us, helm.time_us)
        return [answered(command.number, _ACCEPTED, received)]

    def _get_interval(self, command: Command, received: Received, _: Helm) -> list[Message]:
        message_id = whole_number(command.param1)
        interval = _MESSAGE_INTERVAL(self._streams.interval_us(message_id), message_id & 0xFFFF)
        return [answered(command.number, _ACCEPTED, received), interval]

    def _check(self, command: Command, received: Received, _: Helm) -> list[Message]:
        """RUN_PREARM_CHECKS: their outcome comes as texts and in SYS_STATUS."""
        return [answered(command.number, _ACCEPTED, received)]

    def _enable_fence(self, command: Command, received: Received, helm: Helm) -> list[Message]:
        """As FENCE_ENABLE, which ArduPilot itself leaves as it was."""
        known = command.param1 in (0.0, 1.0)
        if known:
            helm.set_parameter("FENCE_ENABLE", command.param1)
        return [answered(command.number, _ACCEPTED if known else _FAILED, received)]


_HANDLERS: Mapping[MessageType, Callable[[ArduPilotLink, Received, Helm], list[Message]]] = {
    _HEARTBEAT: ArduPilotLink._on_heartbeat,
    _LOCAL_TARGET: ArduPilotLink._on_local_target,
    _GLOBAL_TARGET: ArduPilotLink._on_global_target,
    _ATTITUDE_TARGET: ArduPilotLink._on_attitude_target,
    _OVERRIDE: ArduPilotLink._on_override,
    _MANUAL_CONTROL: ArduPilotLink._on_manual_control,
    _COMMAND_LONG: ArduPilotLink._on_command,
    _COMMAND_INT: ArduPilotLink._on_command,
    _SET_MODE: ArduPilotLink._on_set_mode,
    _REQUEST_DATA_STREAM: ArduPilotLink._on_data_stream,
    _TIMESYNC: ArduPilotLink._on_timesync,
    FILE_MESSAGE: ArduPilotLink._on_file,
    LOG_REQUEST: ArduPilotLink._on_log_list,
    **dict.fromkeys(_PARAMETER_MESSAGES, ArduPilotLink._on_parameter),
    **dict.fromkeys(COPTER_MISSION_MESSAGES, ArduPilotLink._on_plan),
}
_COMMANDS: Mapping[int, Callable[[ArduPilotLink, Command, Received, Helm], list[Message]]] = {
    common.MAV_CMD_DO_SET_MODE: ArduPilotLink._do_set_mode,
    common.MAV_CMD_REQUEST_MESSAGE: ArduPilotLink._request_message,
    common.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: ArduPilotLink._request_version,
    common.MAV_CMD_GET_HOME_POSITION: ArduPilotLink._request_home,
    common.MAV_CMD_SET_MESSAGE_INTERVAL: ArduPilotLink._set_interval,
    common.MAV_CMD_GET_MESSAGE_INTERVAL: ArduPilotLink._get_interval,
    common.MAV_CMD_RUN_PREARM_CHECKS: ArduPilotLink._check,
    common.MAV_CMD_DO_FENCE_ENABLE: ArduPilotLink._enable_fence,
}
