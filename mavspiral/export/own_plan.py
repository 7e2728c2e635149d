"""What we write into our own `.plan` beside the mission, and reading it back without loss.

QGroundControl ignores the object, and drops it when it saves the plan anew.
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from mavspiral.errors import InputError
from mavspiral.export.items import MissionItems
from mavspiral.mission import Mission

__all__ = ["KEY", "OwnPlan", "own_notes", "read_own_plan"]

KEY = "mavspiral"
SCHEMA = 1


@dataclass(frozen=True, slots=True)
class OwnPlan:
    """The mission that a plan was made from, which of its sorties this is, and the path time of each item.

    The sortie flies `inspection_s` of the inspection's own time; path times are those of its own route from home and back.
    A time is None for an item that belongs to no place on the path.
    """

    mission: Mission
    sortie: tuple[int, int]
    inspection_s: tuple[float, float]
    item_t_s: tuple[float | None, ...]


def own_notes(
    mission: Mission,
    items: MissionItems,
    *,
    sortie: tuple[int, int],
    inspection_s: tuple[float, float],
    clearance_m: float,
    fence: str | None,
) -> dict[str, Any]:
    """The object for the plan's root: how exact it is, what it was made from, and which stretch of the inspection it flies."""
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


def read_own_plan(document: dict[str, Any], path: Path | None = None) -> OwnPlan | None:
    """What `own_notes` wrote into a plan; None if nobody did.

    Args:
        document: the plan.
        path: where the mission's own file would be: its map is looked for beside it.

    Raises:
        InputError: it was changed since.
    """
    notes = document.get(KEY)
    if not isinstance(notes, dict) or "mission" not in notes:
        return None
    try:
        listed = document["mission"]["items"]
        commands = [(int(item["command"]), int(item["frame"])) for item in listed]
        if notes["schema"] != SCHEMA or notes["sha256"] != _digest(notes["mission"], commands):
            raise InputError("the plan was changed after mavspiral wrote it: its digest does not match")
        mission = Mission.model_validate_json(json.dumps(notes["mission"]))
        times = tuple(None if t_s is None else float(t_s) for t_s in notes["item_t_s"])
        number, count = notes["sortie"]
        begin_s, end_s = (float(t_s) for t_s in notes["inspection_s"])
        if len(times) != len(commands):
            raise InputError(f"the plan has {len(commands)} items, its notes {len(times)}")
    except (KeyError, TypeError, ValueError, ValidationError) as error:
        raise InputError(f"the plan's {KEY!r} object cannot be read ({type(error).__name__})") from None
    return OwnPlan(
        mission if path is None else mission.model_copy(update={"path": path}),
        (number, count),
        (begin_s, end_s),
        times,
    )


def _bare(mission: Mission) -> dict[str, Any]:
    return mission.model_dump(mode="json", by_alias=True, exclude_unset=True)


def _commands(items: MissionItems) -> list[tuple[int, int]]:
    return [(item.command, item.frame) for item in items.items]


def _digest(made_from: Any, commands: list[tuple[int, int]]) -> str:
    text = json.dumps([made_from, commands], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
