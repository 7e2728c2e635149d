"""The autopilots that can be streamed to, by the names of mission files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from mavspiral.flight.ardupilot import ARDUPILOT
from mavspiral.flight.profile import Profile
from mavspiral.flight.px4 import PX4

__all__ = ["PROFILES", "Autopilot", "autopilot_name"]

Autopilot = Literal["px4", "ardupilot"]
PROFILES: Mapping[Autopilot, Profile] = {"px4": PX4, "ardupilot": ARDUPILOT}


def autopilot_name(profile: Profile) -> Autopilot:
    """What a mission file calls it."""
    return next(name for name, known in PROFILES.items() if known.autopilot == profile.autopilot)
