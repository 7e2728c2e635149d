"""What one autopilot does differently from another, as a value. The session itself knows no autopilot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mavspiral.flight.messages import Command, TypeMask

__all__ = ["Mode", "Profile"]


@dataclass(frozen=True, slots=True)
class Mode:
    """A flight mode: `custom_mode` as HEARTBEAT shows it, `command` as DO_SET_MODE wants params 1 to 3."""

    name: str
    custom_mode: int
    command: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Profile:
    """How to talk to one autopilot.

    Args:
        autopilot: MAV_AUTOPILOT in its heartbeat.
        follow: the mode in which it follows setpoints.
        hold: the mode in which it holds its position by itself, whether or not there are sticks.
        climb: the modes that it goes through in a commanded take-off.
        arm_in: the mode that it must be in to be armed for this; None where any will do.
        camera_id: the component that takes pictures when it is told to.
        gimbal: the command that tilts the camera to so many degrees, up is positive.
        takeoff_mode: the mode that a commanded take-off changes to; None where the mode stays.
        telemetry_hz: the streams that the session lives on, by message id; all others are switched off.
        kept: messages that are answers or notices, never switched off.
        quiet: streams that begin only in flight, switched off beforehand.
        lead_s: how long it takes to act on a setpoint; by so much they are sent ahead.
        tilt_lead_s: the same for a setpoint's acceleration, which it must tilt for.
        turn_lead_s: the same for its yaw rate, which its motors must build up.
        pre_stream_s: for how long it wants to see setpoints before it will follow them.
        takeoff_params: of NAV_TAKEOFF, from the height to reach AMSL and above the vehicle's own home.
        takeoff_from_home: it counts the height of a take-off from its home, so that home must be known.
        takeoff_within_m: how near to its take-off height it calls itself arrived.
        speed_parameters: which parameters bound horizontal speed, climb and descent.
        acceleration_parameter: which parameter bounds horizontal acceleration, if any.
        parameter_units: what a parameter's unit is in SI, where it is not one.
        integers_bytewise: PARAM_VALUE carries integers in the float's bytes.
        loss_timeout: parameter that says after how many seconds without setpoints its failsafe acts.
        loss_action: parameter that says what its failsafe does then.
        loss_actions: the values of `loss_action` in words.
        safe_loss_actions: those that need no pilot.
        long_loss_s: from how long on the failsafe's delay is worth a warning.
        loss_listens_to: parameter that says which system's heartbeat the failsafe waits for, if any.
        return_height: parameter that says at which height above home its own Return flies.
        pitfalls: what follows, in words, where one of `failsafes` is not as it must be; those that are not here are judged
            by what they are.
        forbidding: those of the pitfalls with which it is not flown.
        failsafes: what each parameter that makes a lost link safe must be, from what it is and the height
            above home, in metres, over which a straight way home is free.
        low_battery: parameter whose values but 0 make it act on a low battery by itself, and what that is near a building.
        unguarded: when none of its failsafes acts though we are gone, in words; None where one always does.
        damping: parameter that says what share of its measured acceleration it takes off again, if it does.
        later: the same autopilot from a version on, (major, minor), that has names of its own for its parameters.
        feels_drag: a setpoint's acceleration may hold what the air takes; else it is the motion's alone.
    """

    name: str
    autopilot: int
    type_mask: TypeMask
    coordinate_frame: int
    follow: Mode
    hold: Mode
    land: Mode
    go_home: Mode
    climb: tuple[Mode, ...]
    arm_in: Mode | None
    camera_id: int
    gimbal: Callable[[float], tuple[Command, tuple[float, ...]]]
    takeoff_mode: Mode | None
    other_modes: tuple[Mode, ...]
    telemetry_hz: Mapping[int, float]
    kept: frozenset[int]
    quiet: frozenset[int]
    lead_s: float
    tilt_lead_s: float
    turn_lead_s: float
    pre_stream_s: float
    takeoff_params: Callable[[float, float], tuple[float, ...]]
    takeoff_from_home: bool
    takeoff_within_m: float
    speed_parameters: tuple[str, str, str]
    acceleration_parameter: str | None
    parameter_units: Mapping[str, float]
    integers_bytewise: bool
    loss_timeout: str
    loss_action: str
    loss_actions: Mapping[int, str]
    safe_loss_actions: frozenset[int]
    long_loss_s: float
    loss_listens_to: str | None
    return_height: str
    failsafes: Mapping[str, Callable[[float, float], float]]
    pitfalls: Mapping[str, str]
    forbidding: frozenset[str]
    low_battery: tuple[str, str] | None
    unguarded: str | None
    damping: str | None
    feels_drag: bool
    later: tuple[tuple[int, int], Profile] | None = None

    def of_version(self, version: str) -> Profile:
        """The ways of that version ("4.7.0")."""
        if self.later is None:
            return self
        major, minor, *_ = map(int, version.split("."))
        return self.later[1] if (major, minor) >= self.later[0] else self

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters that the session reads before it arms."""
        always = (self.loss_timeout, self.loss_action, *self.speed_parameters, self.return_height)
        safe = (name for name in self.failsafes if name not in always)
        perhaps = (self.damping, self.acceleration_parameter, self.loss_listens_to)
        return (*always, *(name for name in perhaps if name is not None), *safe)

    def mode_name(self, custom_mode: int) -> str:
        """The mode in words."""
        for mode in (self.follow, self.hold, self.land, self.go_home, *self.climb, *self.other_modes):
            if mode.custom_mode == custom_mode:
                return mode.name
        return f"mode {custom_mode:#x}"
