"""What QGroundControl's loader demands of a `.plan`, and what MAVSDK's importer demands beyond it.

Sources: QGroundControl, PlanMasterController, MissionController and their validator (a missing key or a wrong
type ends the load, unknown keys are ignored); MAVSDK, mission_import.cpp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mavspiral.export.check.fence_shapes import FenceCircle, FencePolygon, fence_shapes, rally_points
from mavspiral.export.check.findings import Findings
from mavspiral.export.check.patterns import Pattern, pattern
from mavspiral.export.check.shape import ARRAY, NUMBER, OBJECT, TEXT, demand, is_kind, place_of, short
from mavspiral.export.check.simple_item import PlanItem, simple_item

__all__ = ["PlanParts", "judge_loading"]

_ROOT = {
    "fileType": TEXT,
    "version": NUMBER,
    "groundStation": TEXT,
    "mission": OBJECT,
    "geoFence": OBJECT,
    "rallyPoints": OBJECT,
}
_MISSION = {"items": ARRAY, "plannedHomePosition": ARRAY, "firmwareType": NUMBER}
_OLD_KEYS = {"MAV_AUTOPILOT", "complexItems"}
_MISSION_OPTIONAL = ("vehicleType", "cruiseSpeed", "hoverSpeed", "globalPlanAltitudeMode")


@dataclass(frozen=True, slots=True)
class PlanParts:
    """What of a plan could be read: its items, fence and rally points.

    `hollow` are the places of patterns that keep no items in the file, `made_n` how many QGroundControl makes of them
    as far as that can be told.
    """

    firmware: int | None
    home: tuple[float, float, float] | None
    items: tuple[PlanItem, ...]
    hollow: tuple[str, ...]
    made_n: int
    polygons: tuple[FencePolygon, ...]
    circles: tuple[FenceCircle, ...]
    rally: tuple[tuple[float, float, float], ...]


def judge_loading(document: dict[str, Any], findings: Findings) -> PlanParts:
    """The parts of a plan, with everything that speaks against loading it noted in `findings`."""
    if "mission" not in document and (
        document.get("fileType") == "Mission" or ("fileType" not in document and _OLD_KEYS & document.keys())
    ):
        findings.error(
            "the file",
            "a mission of an old QGroundControl (.mission), not a plan. Fix: save it as a .plan with one that still opens it",
        )
        return PlanParts(
            firmware=None, home=None, items=(), hollow=(), made_n=0, polygons=(), circles=(), rally=()
        )
    demand(document, _ROOT, "the file", findings)
    if isinstance(kind := document.get("fileType"), str) and kind != "Plan":
        findings.error("fileType", f'{short(kind)} is not "Plan"')
    version = document.get("version")
    if is_kind(version, NUMBER) and version != 1:
        findings.error("version", f"{short(version)} is not 1, the only version there is")
    elif isinstance(version, float):
        findings.warning("version", "1.0 is not written as the whole number 1: MAVSDK refuses it")
    mission = document.get("mission")
    firmware, home = _vehicle(mission if isinstance(mission, dict) else {}, findings)
    patterns = _items(mission if isinstance(mission, dict) else {}, findings)
    fence = document.get("geoFence")
    polygons, circles = fence_shapes(fence, findings) if isinstance(fence, dict) else ((), ())
    rally = document.get("rallyPoints")
    points = rally_points(rally, findings) if isinstance(rally, dict) else ()
    return PlanParts(
        firmware=firmware,
        home=home,
        items=tuple(item for found in patterns.values() for item in found.items),
        hollow=tuple(place for place, found in patterns.items() if found.hollow),
        made_n=sum(found.made_n for found in patterns.values()),
        polygons=polygons,
        circles=circles,
        rally=points,
    )


def _vehicle(
    mission: dict[str, Any], findings: Findings
) -> tuple[int | None, tuple[float, float, float] | None]:
    """The autopilot that it was made for, and the planned home."""
    if not mission:
        return None, None
    demand(mission, _MISSION, "mission", findings)
    for key in _MISSION_OPTIONAL:
        if key in mission and not is_kind(mission[key], NUMBER):
            findings.error(f"mission.{key}", f"is {short(mission[key])}, wanted a number")
    if not (type(mission.get("version")) is int and mission["version"] == 2):
        findings.warning("mission.version", "is not the whole number 2: MAVSDK refuses it")
    home = None
    if (point := place_of(mission.get("plannedHomePosition"), 3)) is not None:
        home = point[0], point[1], point[2]
    elif isinstance(mission.get("plannedHomePosition"), list):
        findings.error("mission.plannedHomePosition", "is not [latitude, longitude, height above the sea]")
    firmware: Any = mission.get("firmwareType")
    return int(firmware) if is_kind(firmware, NUMBER) else None, home


def _items(mission: dict[str, Any], findings: Findings) -> dict[str, Pattern]:
    """What each entry of the list holds, by its place."""
    found: dict[str, Pattern] = {}
    listed = mission.get("items")
    for number, item in enumerate(listed if isinstance(listed, list) else (), start=1):
        place = f"item {number}"
        if not isinstance(item, dict):
            findings.error(place, f"is {short(item)}, wanted an object")
        elif item.get("type") == "SimpleItem":
            found[place] = Pattern(tuple(simple_item(item, place, findings)))
        elif item.get("type") == "ComplexItem":
            found[place] = pattern(item, place, findings)
        else:
            findings.error(place, f'type is {short(item.get("type"))}, wanted "SimpleItem" or "ComplexItem"')
    if isinstance(listed, list) and not listed:
        findings.error("mission.items", "is empty: there is nothing to fly")
    return found
