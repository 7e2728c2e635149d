"""One SimpleItem, as QGroundControl's MissionItem and SimpleMissionItem load it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from mavspiral.export.check.findings import Findings
from mavspiral.export.check.shape import ARRAY, FLAG, FLOAT_MAX, NUMBER, demand, is_kind, short

__all__ = ["PlanItem", "simple_item"]

_KEYS = {"command": NUMBER, "frame": NUMBER, "params": ARRAY, "autoContinue": FLAG}
_ALTITUDE = ("Altitude", "AltitudeMode", "AMSLAltAboveTerrain")

_MISSION_FRAME = 2
_STEPS = 1e7
"""Of latitude and longitude in a degree; in frame MISSION the two are what they are."""
_WHOLE_MAX = 2**31 - 1

_PLAIN_MODES = (1, 2)
"""Relative to home, above the sea."""
_HEIGHT_STEP_M = 0.01


@dataclass(frozen=True, slots=True)
class PlanItem:
    """One mission item as it would be uploaded: where it stands in the file, and MAVLink's numbers; null is NaN."""

    place: str
    command: int
    frame: int
    params: tuple[float, ...]
    jump_id: int | None


def simple_item(item: dict[str, Any], place: str, findings: Findings) -> Iterator[PlanItem]:
    """The item, if it can be loaded; what speaks against it is noted."""
    if not demand(item, _KEYS, place, findings):
        return
    params = item["params"]
    if len(params) != 7:
        findings.error(place, f"params has {len(params)} entries, wanted 7")
        return
    if not all(value is None or is_kind(value, NUMBER) for value in params):
        findings.error(place, "an entry of params is neither a number nor null")
        return
    if "doJumpId" in item and not is_kind(item["doJumpId"], NUMBER):
        findings.error(place, f"doJumpId is {short(item['doJumpId'])}, wanted a number")
        return
    for key in ("command", "frame"):
        if item[key] != int(item[key]) or not 0 <= item[key] < 65536:
            findings.error(place, f"{key} is {short(item[key])}, which MAVLink does not number so")
            return
    if not _judge_range(item, place, findings):
        return
    given = [key for key in _ALTITUDE if key in item]
    if given and len(given) < len(_ALTITUDE):
        missing = ", ".join(key for key in _ALTITUDE if key not in item)
        findings.error(
            place,
            f"{', '.join(given)} without {missing}: the altitude keys come all three or not at all",
        )
    for key in given:
        value = item[key]
        if not (is_kind(value, NUMBER) or (key == "AMSLAltAboveTerrain" and value is None)):
            findings.error(place, f"{key} is {short(value)}, wanted a number")
    _judge_height(item, place, findings)
    jump_id = item.get("doJumpId")
    yield PlanItem(
        place,
        int(item["command"]),
        int(item["frame"]),
        tuple(math.nan if value is None else float(value) for value in params),
        None if jump_id is None else int(jump_id),
    )


def _judge_range(item: dict[str, Any], place: str, findings: Findings) -> bool:
    """Whether MAVLink can carry the parameters: the fifth and sixth as whole numbers of 32 bits, the others as floats."""
    params, steps = [0.0 if value is None else value for value in item["params"]], _STEPS
    if item["frame"] == _MISSION_FRAME:
        steps = 1
        if any(value % 1 for value in params[4:6]):
            findings.warning(
                place, "MAVLink carries the fifth and sixth parameter in frame 2 as whole numbers"
            )
    tall = [value for value in params[4:6] if abs(value) * steps >= _WHOLE_MAX]
    tall += [value for value in (*params[:4], params[6]) if abs(value) > FLOAT_MAX]
    for value in tall:
        findings.error(place, f"{value:g} among params is more than MAVLink carries there")
    return not tall


def _judge_height(item: dict[str, Any], place: str, findings: Findings) -> None:
    """The ground station goes by Altitude, MAVSDK and `upload` by params; above terrain they are two heights."""
    altitude_m, height_m = item.get("Altitude"), item["params"][6]
    if not is_kind(altitude_m, NUMBER) or not is_kind(height_m, NUMBER):
        return
    if item.get("AltitudeMode") in _PLAIN_MODES and abs(altitude_m - height_m) > _HEIGHT_STEP_M:
        findings.warning(
            place,
            f"Altitude is {altitude_m:g}, the height in params {height_m:g}: readers differ on which of them counts",
        )
