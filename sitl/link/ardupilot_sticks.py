"""RC_CHANNELS_OVERRIDE and MANUAL_CONTROL to pulses on a radio's channels, as ArduPilot takes them.

Source: ArduPilot 4.6, GCS_Common.cpp, handle_rc_channels_override, handle_manual_control and manual_override.
"""

from __future__ import annotations

from collections.abc import Mapping

from sitl.link.messages import Message

__all__ = ["manual_pulses_us", "override_pulses_us"]

_CHANNELS_N = 8
_AS_IT_WAS, _NO_AXIS = 0xFFFF, 0x7FFF
_STICK_END = 1000


def override_pulses_us(message: Message) -> dict[int, int]:
    """Channel to pulse, for those that an RC_CHANNELS_OVERRIDE speaks of; 0 lets go."""
    told = ((number, getattr(message, f"chan{number}_raw")) for number in range(1, _CHANNELS_N + 1))
    return {number: pulse_us for number, pulse_us in told if pulse_us != _AS_IT_WAS}


def manual_pulses_us(message: Message, parameters: Mapping[str, float]) -> dict[int, int]:
    """Channel to pulse, for the axes that a MANUAL_CONTROL speaks of. Forward is a short pulse; throttle is 0…1000."""
    axes = {
        "ROLL": (message.y, message.y + _STICK_END, 2 * _STICK_END),
        "PITCH": (message.x, -message.x + _STICK_END, 2 * _STICK_END),
        "THROTTLE": (message.z, message.z, _STICK_END),
        "YAW": (message.r, message.r + _STICK_END, 2 * _STICK_END),
    }
    pulses_us = {}
    for name, (axis, raised, span) in axes.items():
        channel = int(parameters[f"RCMAP_{name}"])
        if axis != _NO_AXIS:
            low, high = parameters[f"RC{channel}_MIN"], parameters[f"RC{channel}_MAX"]
            pulses_us[channel] = round(low + (high - low) * raised / span)
    return pulses_us
