"""What we write into our own `.plan` beside the mission.

QGroundControl ignores the object, and drops it when it saves the plan anew.
"""

from __future__ import annotations

import hashlib
import json
import math
from typing import Any

from mavspiral.export.items import MissionItems
from mavspiral.mission import Mission

__all__ = ["KEY", "own_notes"]

KEY = "mavspiral"
SCHEMA = 1


def own_notes(
    mission: Mission,
    items: MissionItems,
    *,
    sortie: tuple[int, int],
    inspection_s: tuple[float, float],
    clearance_m: float,
    fence: str | None,
) -> dict[str, Any]:
    """The object for the plan's root: how exact it is, what it was made from, and which stretch of the inspection it flies.

    `sortie` is its number, from 1, and of how many. The stretch is of the inspection's own time, `item_t_s` of the
    time on the sortie's own route from home and back; None for an item that belongs to no place on it. The digest is of the mission
    and of each item's command and frame: it tells whether somebody changed the plan.
    """
    made_from = _bare(mission)
    return {
        "schema": SCHEMA,
        "name": mission.name,
        "sortie": list(sortie),
        "inspection_s": [round(t_s, 3) for t_s in inspection_s],
        "chord_error_m": round(items.thinned.chord_error_m, 3),
        "heading_error_deg": round(math.degrees(items.thinned.heading_error_rad), 2),
        "clearance_m": round(clearance_m, 3),
        "fence": fence,
        "mission": made_from,
        "sha256": _digest(made_from, _commands(items)),
        "item_t_s": [None if math.isnan(item.t_s) else round(item.t_s, 3) for item in items.items],
    }


def _bare(mission: Mission) -> dict[str, Any]:
    return mission.model_dump(mode="json", by_alias=True, exclude_unset=True)


def _commands(items: MissionItems) -> list[tuple[int, int]]:
    return [(item.command, item.frame) for item in items.items]


def _digest(made_from: Any, commands: list[tuple[int, int]]) -> str:
    text = json.dumps([made_from, commands], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
