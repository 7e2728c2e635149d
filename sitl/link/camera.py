"""A camera on a gimbal beside the autopilot: the component that MAVLink's camera protocol talks to.

It is component 100 of the vehicle's system, with a heartbeat and sequence numbers of its own; pictures are taken by the
same payload that missions use. Video, zoom and files it has none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import common

from sitl.link.codec import Codec, CodecState, Received
from sitl.link.commands import ORDERS, RESULTS, Command, answered, command_of, whole_number
from sitl.link.helm import Helm
from sitl.link.instruments import image_captured
from sitl.link.messages import Message, MessageType, message_type
from sitl.link.report import Report
from sitl.link.signing import Signer
from sitl.status import Shot

__all__ = ["CAMERA_COMPONENT", "Camera", "CameraState"]

CAMERA_COMPONENT = common.MAV_COMP_ID_CAMERA

_HEARTBEAT = message_type("HEARTBEAT")
_INFORMATION = message_type("CAMERA_INFORMATION")
_SETTINGS = message_type("CAMERA_SETTINGS")
_STORAGE = message_type("STORAGE_INFORMATION")
_CAPTURE_STATUS = message_type("CAMERA_CAPTURE_STATUS")

_IMAGE_CAPTURED_ID = message_type("CAMERA_IMAGE_CAPTURED").ID

_BEAT_US = 1_000_000
_COMMANDS = (message_type("COMMAND_LONG"), message_type("COMMAND_INT"))
_CARD_MIB, _PICTURE_MIB = 65536.0, 8.0
_IMAGE_MODE = common.CAMERA_MODE_IMAGE
_DONE, _DENIED, _UNKNOWN = (
    common.MAV_RESULT_ACCEPTED,
    common.MAV_RESULT_DENIED,
    common.MAV_RESULT_UNSUPPORTED,
)
_SHOOTING = (common.MAV_CMD_IMAGE_START_CAPTURE, common.MAV_CMD_IMAGE_STOP_CAPTURE)


def _text(text: str) -> tuple[int, ...]:
    return tuple(text.encode("ascii").ljust(32, b"\0"))


def _information(report: Report) -> Message:
    """A 1-inch sensor behind 8.8 mm, as in the missions of the gallery."""
    return _INFORMATION(
        time_boot_ms=report.time_ms, firmware_version=1, focal_length=8.8, sensor_size_h=13.2,
        sensor_size_v=8.8, flags=common.CAMERA_CAP_FLAGS_CAPTURE_IMAGE, resolution_h=5472, resolution_v=3648,
        cam_definition_version=0, vendor_name=_text("mavspiral"), model_name=_text("sitl"), lens_id=0,
        cam_definition_uri=b"", gimbal_device_id=1, camera_device_id=0,
    )  # fmt: skip


def _settings(report: Report) -> Message:
    return _SETTINGS(
        time_boot_ms=report.time_ms,
        mode_id=_IMAGE_MODE,
        zoomLevel=math.nan,
        focusLevel=math.nan,
        camera_device_id=0,
    )


def _storage(report: Report) -> Message:
    used_mib = min(_CARD_MIB, _PICTURE_MIB * report.flight.payload.shots)
    return _STORAGE(
        time_boot_ms=report.time_ms, total_capacity=_CARD_MIB, used_capacity=used_mib,
        available_capacity=_CARD_MIB - used_mib, read_speed=math.nan, write_speed=math.nan, storage_id=1,
        storage_count=1, status=common.STORAGE_STATUS_READY, type=common.STORAGE_TYPE_SD, name=b"card",
        storage_usage=0,
    )  # fmt: skip


def _capture_status(report: Report) -> Message:
    payload = report.flight.payload
    return _CAPTURE_STATUS(
        time_boot_ms=report.time_ms,
        image_interval=payload.interval_s,
        recording_time_ms=0,
        available_capacity=max(0.0, _CARD_MIB - _PICTURE_MIB * payload.shots),
        image_status=2 if payload.interval_s > 0.0 else 0,
        video_status=0,
        image_count=payload.shots,
        camera_device_id=0,
    )


_BUILDERS: Mapping[MessageType, Callable[[Report], Message]] = {
    _INFORMATION: _information,
    _SETTINGS: _settings,
    _STORAGE: _storage,
    _CAPTURE_STATUS: _capture_status,
}
_BY_ID = {kind.ID: builder for kind, builder in _BUILDERS.items()}
_OLD_REQUESTS = {
    common.MAV_CMD_REQUEST_CAMERA_INFORMATION: _INFORMATION.ID,
    common.MAV_CMD_REQUEST_CAMERA_SETTINGS: _SETTINGS.ID,
    common.MAV_CMD_REQUEST_STORAGE_INFORMATION: _STORAGE.ID,
    common.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS: _CAPTURE_STATUS.ID,
}


@dataclass(frozen=True, slots=True)
class CameraState:
    """All that a camera's end of a link remembers."""

    codec: CodecState
    due_us: int
    shots: tuple[Shot, ...] = ()


class Camera:
    """The camera's end of one link."""

    def __init__(self, system: int, signer: Signer | None = None) -> None:
        self._codec = Codec(system, CAMERA_COMPONENT, signer)
        self._due_us = 0
        self._shots: list[Shot] = []

    def send(self, now_us: int) -> bytes:
        """Its heartbeat, when that is due."""
        if now_us < self._due_us:
            return b""
        self._due_us = now_us + _BEAT_US
        beat = _HEARTBEAT(
            0, common.MAV_TYPE_CAMERA, common.MAV_AUTOPILOT_INVALID, 0, common.MAV_STATE_ACTIVE, 3
        )
        return self._codec.encode(beat)

    def is_meant(self, message: Message) -> bool:
        """Whether that is a command to the camera."""
        return type(message) in _COMMANDS and (message.target_system, message.target_component) == (
            self._codec.system,
            CAMERA_COMPONENT,
        )

    def receive(self, received: Received, helm: Helm) -> bytes:
        """What it answers to a command that is meant for it: the ACK first, then what was asked for."""
        command = command_of(received.message)
        result, message = self._obey(command, helm)
        out = self._codec.encode(answered(command.number, result, received))
        return out if message is None else out + self._codec.encode(message)

    def show(self, shot: Shot) -> bytes:
        """The picture that was taken, for whoever listens; it is told again to whoever asks for its number."""
        self._shots.append(shot)
        return self._codec.encode(image_captured(shot))

    def snapshot(self) -> CameraState:
        """All that it remembers."""
        return CameraState(self._codec.snapshot(), self._due_us, tuple(self._shots))

    def restore(self, state: CameraState) -> None:
        """Go on from a snapshot."""
        self._codec.restore(state.codec)
        self._due_us = state.due_us
        self._shots = list(state.shots)

    def _obey(self, command: Command, helm: Helm) -> tuple[int, Message | None]:
        wanted = _OLD_REQUESTS.get(command.number)
        if command.number == common.MAV_CMD_REQUEST_MESSAGE:
            wanted = int(command.param1) if math.isfinite(command.param1) else -1
        if wanted == _IMAGE_CAPTURED_ID:
            number = whole_number(command.param2)
            told = next((shot for shot in self._shots if shot.index == number), None)
            return (_DENIED, None) if told is None else (_DONE, image_captured(told))
        if wanted is not None:
            builder = _BY_ID.get(wanted)
            return (_UNKNOWN, None) if builder is None else (_DONE, builder(helm.report()))
        if command.number in _SHOOTING:
            order = ORDERS[command.number](command, helm.report().flight)
            return _DENIED if order is None else RESULTS[helm.obey(order)], None
        if command.number == common.MAV_CMD_SET_CAMERA_MODE:
            if command.param2 != _IMAGE_MODE:
                return _DENIED, None
            return _DONE, _settings(helm.report())
        return _UNKNOWN, None
