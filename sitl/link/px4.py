"""PX4's dialect of MAVLink behaviour: one link of a vehicle, sans-I/O.

What PX4 v1.17 was seen to do is done here: who is answered, in which order, and when nobody is. A link knows
nothing of the other links; what they share is the helm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from pymavlink.dialects.v20 import common

from sitl.link.camera import CAMERA_COMPONENT, Camera, CameraState
from sitl.link.codec import Codec, CodecState, Received
from sitl.link.commands import answered, command_of
from sitl.link.events import REQUEST_EVENT, no_event
from sitl.link.files import FILE_MESSAGE, Files, no_file
from sitl.link.global_setpoints import global_setpoint_of
from sitl.link.helm import Helm
from sitl.link.instruments import image_captured
from sitl.link.logs import LOG_REQUEST, no_logs
from sitl.link.messages import Message, MessageType, message_type
from sitl.link.missions import MISSION_MESSAGES, PlanService
from sitl.link.parameters import ParameterService
from sitl.link.px4_commands import CommandService, switch_mode
from sitl.link.px4_status import status_texts
from sitl.link.px4_telemetry import TELEMETRY_COMMANDS, Px4Telemetry, TelemetryState
from sitl.link.setpoints import attitude_setpoint_of, setpoint_of
from sitl.link.signing import Signer
from sitl.signals import GeoPoint, Sticks
from sitl.status import Notice, Shot

__all__ = ["Px4Link", "Px4LinkState"]

_HEARTBEAT = message_type("HEARTBEAT")
_SET_POSITION_TARGET = message_type("SET_POSITION_TARGET_LOCAL_NED")
_SET_GLOBAL_TARGET = message_type("SET_POSITION_TARGET_GLOBAL_INT")
_SET_ATTITUDE_TARGET = message_type("SET_ATTITUDE_TARGET")
_MANUAL_CONTROL = message_type("MANUAL_CONTROL")
_COMMAND_LONG = message_type("COMMAND_LONG")
_COMMAND_INT = message_type("COMMAND_INT")
_SET_MODE = message_type("SET_MODE")
_PARAMETER_MESSAGES = tuple(map(message_type, ("PARAM_REQUEST_LIST", "PARAM_REQUEST_READ", "PARAM_SET")))
_PING = message_type("PING")
_SET_GPS_GLOBAL_ORIGIN = message_type("SET_GPS_GLOBAL_ORIGIN")
_TIMESYNC = message_type("TIMESYNC")

_STICK_END = 1000
_QUARTER_E7 = 900_000_000
"""90 degrees as MAVLink has them."""
_OURS, _ANY = common.MAV_COMP_ID_AUTOPILOT1, common.MAV_COMP_ID_ALL
_CAMERA_COMMANDS = (common.MAV_CMD_IMAGE_START_CAPTURE, common.MAV_CMD_IMAGE_STOP_CAPTURE)


@dataclass(frozen=True, slots=True)
class Px4LinkState:
    """All that a link remembers."""

    codec: CodecState
    telemetry: TelemetryState
    parameters: ParameterService
    plans: PlanService
    files: Files
    commands: CommandService
    hears_gcs: bool
    text_number: int
    camera: CameraState | None = None


class Px4Link:
    """One MAVLink instance of a PX4 vehicle; with `camera`, of one that carries a camera on a gimbal.

    The heartbeats that a `relayed` one hears are for other links, too.
    """

    def __init__(
        self,
        system: int,
        rates_hz: Mapping[str, float],
        signer: Signer | None = None,
        *,
        camera: bool = False,
        relayed: bool = False,
    ) -> None:
        self._codec = Codec(system, _OURS, signer)
        self._camera = Camera(system, signer) if camera else None
        self._telemetry = Px4Telemetry(rates_hz, camera=camera)
        self._parameters = ParameterService()
        self._plans = PlanService()
        self._files = Files()
        self._commands = CommandService()
        self._hears_gcs = False
        self._relayed = relayed
        self._heartbeats: list[Received] = []
        self._text_number = 0

    def receive(self, data: bytes, helm: Helm) -> bytes:
        """Take what came in, and say what is to be answered at once."""
        out = b""
        for received in self._codec.decode(data):
            if self._camera is not None and self._camera.is_meant(received.message):
                out += self._camera.receive(received, helm)
            handle = _HANDLERS.get(type(received.message))
            for answer in () if handle is None else handle(self, received, helm):
                sender = (
                    (self._codec.system, CAMERA_COMPONENT)
                    if self._addresses_camera(received.message)
                    else None
                )
                out += self._codec.encode(answer, sender)
        return out

    def due_us(self, helm: Helm) -> int:
        """When there will be something to send unasked, unless something happens before; zero is at once."""
        if self._commands.verdicts or self._camera is not None or self._parameters.has_news(helm.parameters):
            return 0
        return min(self._telemetry.streams.next_us, self._plans.due_us(helm))

    def send(self, helm: Helm) -> bytes:
        """What is to be sent unasked in this frame."""
        out = b"" if self._camera is None else self._camera.send(helm.time_us)
        messages = (
            *self._commands.take_verdicts(),
            *self._parameters.proceed(helm.parameters),
            *self._plans.proceed(helm),
            *self._telemetry.due(helm),
        )
        return out + b"".join(map(self._codec.encode, messages))

    def tell(self, notice: Notice) -> bytes:
        """The notice as text, if a ground station listens; in parts when it is long."""
        if not self._hears_gcs:
            return b""
        texts, self._text_number = status_texts(notice, self._text_number)
        return b"".join(map(self._codec.encode, texts))

    def show(self, shot: Shot) -> bytes:
        """The picture that was taken, for whoever listens."""
        if self._camera is not None:
            return self._camera.show(shot)
        return self._codec.encode(image_captured(shot))

    def take_heartbeats(self) -> tuple[Received, ...]:
        """The heartbeats heard since the last call, for other links to pass on."""
        if not self._heartbeats:
            return ()
        heartbeats, self._heartbeats = tuple(self._heartbeats), []
        return heartbeats

    def forward(self, received: Received) -> bytes:
        """What another link heard, passed on."""
        return self._codec.encode(received.message, (received.system, received.component))

    def snapshot(self) -> Px4LinkState:
        """All that this link remembers."""
        return Px4LinkState(
            codec=self._codec.snapshot(),
            telemetry=self._telemetry.snapshot(),
            parameters=replace(self._parameters),
            plans=replace(self._plans),
            files=replace(self._files),
            commands=replace(self._commands),
            hears_gcs=self._hears_gcs,
            text_number=self._text_number,
            camera=None if self._camera is None else self._camera.snapshot(),
        )

    def restore(self, state: Px4LinkState) -> None:
        """Go on from a snapshot."""
        self._codec.restore(state.codec)
        self._telemetry.restore(state.telemetry)
        self._parameters, self._plans = replace(state.parameters), replace(state.plans)
        self._files, self._commands = replace(state.files), replace(state.commands)
        self._hears_gcs = state.hears_gcs
        if self._camera is not None and state.camera is not None:
            self._camera.restore(state.camera)
        self._text_number = state.text_number

    def _addresses_us(self, message: Message) -> bool:
        return message.target_system == self._codec.system and message.target_component in (_OURS, _ANY)

    def _addresses_camera(self, message: Message | None) -> bool:
        """Whether it is for a shutter at the camera's address, which we answer for where no whole camera is on board."""
        return (
            self._camera is None
            and isinstance(message, _COMMAND_LONG)
            and message.command in _CAMERA_COMMANDS
            and (message.target_system, message.target_component) == (self._codec.system, CAMERA_COMPONENT)
        )

    def _on_heartbeat(self, received: Received, helm: Helm) -> list[Message]:
        if received.message.type == common.MAV_TYPE_GCS:
            self._hears_gcs = True
            helm.hear_ground_station()
        if self._relayed:
            self._heartbeats.append(received)
        return []

    def _on_setpoint(self, received: Received, helm: Helm) -> list[Message]:
        message = received.message
        if message.target_system in (self._codec.system, 0) and message.target_component in (_OURS, _ANY):
            if type(message) is _SET_ATTITUDE_TARGET:
                setpoint = attitude_setpoint_of(message)
            elif type(message) is _SET_GLOBAL_TARGET:
                setpoint = global_setpoint_of(message, helm.report())
            else:
                setpoint = setpoint_of(message, helm.attitude)
            if setpoint is not None:
                helm.steer(setpoint)
        return []

    def _on_sticks(self, received: Received, helm: Helm) -> list[Message]:
        """A joystick at the ground station. Throttle is 0…1000, and 500 neither climbs nor sinks."""
        message = received.message
        axes = message.x, message.y, 2 * message.z - _STICK_END, message.r
        if message.target == self._codec.system and all(abs(axis) <= _STICK_END for axis in axes):
            helm.hear_sticks(Sticks(*(axis / _STICK_END for axis in axes)))
        return []

    def _on_parameter(self, received: Received, helm: Helm) -> list[Message]:
        if not self._addresses_us(received.message):
            return []
        return self._parameters.receive(received.message, helm.parameters, helm.set_parameter)

    def _on_plan(self, received: Received, helm: Helm) -> list[Message]:
        return self._plans.receive(received, helm) if self._addresses_us(received.message) else []

    def _on_file(self, received: Received, _: Helm) -> list[Message]:
        """PX4 has files; there are none here, and it says so."""
        return self._files.receive(received, no_file) if self._addresses_us(received.message) else []

    def _on_log_list(self, received: Received, _: Helm) -> list[Message]:
        return no_logs() if self._addresses_us(received.message) else []

    def _on_event_request(self, received: Received, _: Helm) -> list[Message]:
        return no_event(received) if self._addresses_us(received.message) else []

    def _on_origin(self, received: Received, helm: Helm) -> list[Message]:
        """Whoever sets the origin, and for whomever, is told where it is now."""
        message = received.message
        valid = abs(message.latitude) <= _QUARTER_E7 and abs(message.longitude) <= 2 * _QUARTER_E7
        if valid and message.target_system == self._codec.system:
            helm.move_origin(
                GeoPoint(message.latitude * 1e-7, message.longitude * 1e-7, message.altitude * 1e-3)
            )
        told = self._telemetry.origin(helm)
        return [] if told is None else [told]

    def _on_ping(self, received: Received, _: Helm) -> list[Message]:
        ping = received.message
        if ping.target_system or ping.target_component:
            return []
        return [_PING(ping.time_usec, ping.seq, received.system, received.component)]

    def _on_timesync(self, received: Received, helm: Helm) -> list[Message]:
        timesync = received.message
        return [] if timesync.tc1 else [_TIMESYNC(helm.time_us * 1000, timesync.ts1)]

    def _on_set_mode(self, received: Received, helm: Helm) -> list[Message]:
        message = received.message
        if message.target_system != self._codec.system:
            return []
        code = message.custom_mode >> 16 & 0xFF, message.custom_mode >> 24 & 0xFF
        result = switch_mode(message.base_mode, code, helm)
        return [answered(common.MAV_CMD_DO_SET_MODE, result, received)]

    def _on_command(self, received: Received, helm: Helm) -> list[Message]:
        if not (self._addresses_us(received.message) or self._addresses_camera(received.message)):
            return []
        command = command_of(received.message)
        tell = TELEMETRY_COMMANDS.get(command.number)
        if tell is not None:
            return tell(self._telemetry, command, received, helm)
        return self._commands.receive(command, received, helm)


_HANDLERS: Mapping[MessageType, Callable[[Px4Link, Received, Helm], list[Message]]] = {
    _HEARTBEAT: Px4Link._on_heartbeat,
    _SET_POSITION_TARGET: Px4Link._on_setpoint,
    _SET_GLOBAL_TARGET: Px4Link._on_setpoint,
    _SET_ATTITUDE_TARGET: Px4Link._on_setpoint,
    _MANUAL_CONTROL: Px4Link._on_sticks,
    _COMMAND_LONG: Px4Link._on_command,
    _COMMAND_INT: Px4Link._on_command,
    _SET_MODE: Px4Link._on_set_mode,
    _PING: Px4Link._on_ping,
    _TIMESYNC: Px4Link._on_timesync,
    _SET_GPS_GLOBAL_ORIGIN: Px4Link._on_origin,
    FILE_MESSAGE: Px4Link._on_file,
    LOG_REQUEST: Px4Link._on_log_list,
    REQUEST_EVENT: Px4Link._on_event_request,
    **dict.fromkeys(_PARAMETER_MESSAGES, Px4Link._on_parameter),
    **dict.fromkeys(MISSION_MESSAGES, Px4Link._on_plan),
}
