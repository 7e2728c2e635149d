"""Uploaded plans as values: missions, fences and rally points, and how far the mission has come."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum

__all__ = ["MissionRun", "PlanItem", "PlanKind", "Plans"]

_RELATIVE_FRAMES = (3, 6)
_MISSION_FRAME = 2


class PlanKind(IntEnum):
    """What can be uploaded: MAVLink's MAV_MISSION_TYPE."""

    MISSION = 0
    FENCE = 1
    RALLY = 2


@dataclass(frozen=True, slots=True)
class PlanItem:
    """One item as the vehicle keeps it. `params` are MAVLink's seven; a place's are degrees and metres.

    Commands and frames are MAVLink's numbers. A frame of 2 is an item without a place.
    """

    command: int
    frame: int
    params: tuple[float, float, float, float, float, float, float]
    autocontinue: bool = True

    @property
    def has_place(self) -> bool:
        """Whether the last three parameters are latitude, longitude and height."""
        return self.frame != _MISSION_FRAME

    @property
    def is_relative(self) -> bool:
        """Whether the height is above home rather than above the sea."""
        return self.frame in _RELATIVE_FRAMES


@dataclass(frozen=True, slots=True)
class Plans:
    """All that has been uploaded."""

    mission: tuple[PlanItem, ...] = ()
    fence: tuple[PlanItem, ...] = ()
    rally: tuple[PlanItem, ...] = ()

    def of(self, kind: PlanKind) -> tuple[PlanItem, ...]:
        """The items of that kind."""
        return (self.mission, self.fence, self.rally)[kind]

    def with_items(self, kind: PlanKind, items: tuple[PlanItem, ...]) -> Plans:
        """These plans with one of them replaced."""
        match kind:
            case PlanKind.MISSION:
                return replace(self, mission=items)
            case PlanKind.FENCE:
                return replace(self, fence=items)
            case PlanKind.RALLY:
                return replace(self, rally=items)


@dataclass(frozen=True, slots=True)
class MissionRun:
    """How far a mission has come. It outlives a pause.

    `jumps` are the DO_JUMPs that were taken: item and how often. `speed_mps` is what DO_CHANGE_SPEED asked
    for, NaN the usual speed.
    """

    seq: int = 0
    reached: int = -1
    jumps: tuple[tuple[int, int], ...] = ()
    speed_mps: float = math.nan
    finished: bool = False
