"""What a ground station puts on a radio's channels, where no radio is: RC_CHANNELS_OVERRIDE and MANUAL_CONTROL.

Source: ArduPilot 4.6, RC_Channel.cpp and AP_RCMapper. A channel that nobody holds has no pulse here: its stick rests in the
middle, also the throttle's, which on ArduPilot's SITL rests at the bottom.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from sitl.signals import Sticks

__all__ = ["Radio"]

_IGNORES_OVERRIDES = 2
"""RC_OPTIONS."""
_FULL_THROTTLE = 1000.0
"""What THR_DZ counts in."""


@dataclass(frozen=True, slots=True)
class Radio:
    """The channels that are held: number, pulse in microseconds, and when it was told."""

    held: tuple[tuple[int, int, int], ...] = ()

    def told(self, pulses_us: Mapping[int, int], now_us: int) -> Radio:
        """With these channels held from now; a pulse of 0 lets go."""
        kept = {number: (pulse_us, then_us) for number, pulse_us, then_us in self.held}
        kept |= {number: (pulse_us, now_us) for number, pulse_us in pulses_us.items()}
        return Radio(tuple((number, *kept[number]) for number in sorted(kept) if kept[number][0]))

    def pulses_us(self, now_us: int, parameters: Mapping[str, float]) -> dict[int, int]:
        """The pulse of each channel that is held: for RC_OVERRIDE_TIME after it was told, for good where that is negative."""
        if int(parameters["RC_OPTIONS"]) & _IGNORES_OVERRIDES:
            return {}
        time_s = parameters["RC_OVERRIDE_TIME"]
        return {
            number: pulse_us
            for number, pulse_us, then_us in self.held
            if time_s < 0.0 or now_us - then_us < 1e6 * time_s
        }

    def sticks(self, now_us: int, parameters: Mapping[str, float]) -> Sticks | None:
        """How far the sticks are deflected; None while nobody holds one of them."""
        if not self.held:
            return None
        pulses_us = self.pulses_us(now_us, parameters)
        channels = [int(parameters[f"RCMAP_{name}"]) for name in ("ROLL", "PITCH", "THROTTLE", "YAW")]
        if not any(channel in pulses_us for channel in channels):
            return None
        roll, pitch, throttle, yaw = (
            _deflection(channel, pulses_us[channel], parameters) if channel in pulses_us else 0.0
            for channel in channels
        )
        if channels[2] in pulses_us:
            throttle = _climb(channels[2], pulses_us[channels[2]], parameters)
        return Sticks(-pitch, roll, throttle, yaw)


def _deflection(channel: int, pulse_us: int, parameters: Mapping[str, float]) -> float:
    """-1…1 about RCn_TRIM, zero within RCn_DZ of it."""
    low, middle, high, dead, reverse = (
        parameters[f"RC{channel}_{name}"] for name in ("MIN", "TRIM", "MAX", "DZ", "REVERSED")
    )
    off_us = pulse_us - middle
    end_us = high - middle if off_us > 0.0 else middle - low
    size = max(0.0, abs(off_us) - dead) / max(1.0, end_us - dead)
    return math.copysign(min(1.0, size), -off_us if reverse else off_us)


def _climb(channel: int, pulse_us: int, parameters: Mapping[str, float]) -> float:
    """-1…1 about the middle between RCn_MIN and RCn_MAX, zero within THR_DZ of it."""
    low, high = parameters[f"RC{channel}_MIN"], parameters[f"RC{channel}_MAX"]
    raised = 2.0 * (pulse_us - low) / max(1.0, high - low) - 1.0
    dead = 2.0 * parameters["THR_DZ"] / _FULL_THROTTLE
    size = max(0.0, abs(raised) - dead) / max(1e-3, 1.0 - dead)
    return math.copysign(min(1.0, size), -raised if parameters[f"RC{channel}_REVERSED"] else raised)
