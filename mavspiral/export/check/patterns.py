"""QGroundControl's patterns: surveys and corridors carry their mission items, structure scans do not.

Sources: SurveyComplexItem, CorridorScanComplexItem, TransectStyleComplexItem, StructureScanComplexItem.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from mavspiral.export.check.camera_calc import judge_camera
from mavspiral.export.check.findings import Findings
from mavspiral.export.check.shape import ARRAY, FLAG, NUMBER, OBJECT, demand, place_of, short
from mavspiral.export.check.simple_item import PlanItem, simple_item

__all__ = ["Pattern", "pattern"]

_SURVEY = {"polygon": ARRAY, "angle": NUMBER}
_CORRIDOR = {"polyline": ARRAY, "CorridorWidth": NUMBER, "EntryPoint": NUMBER}
_TRANSECTS = {
    "TurnAroundDistance": NUMBER,
    "CameraTriggerInTurnAround": FLAG,
    "HoverAndCapture": FLAG,
    "Refly90Degrees": FLAG,
    "CameraCalc": OBJECT,
    "VisualTransectPoints": ARRAY,
    "Items": ARRAY,
    "CameraShots": NUMBER,
}
_STRUCTURE = {
    "EntranceAltitude": NUMBER,
    "ScanBottomAlt": NUMBER,
    "StructureHeight": NUMBER,
    "Layers": NUMBER,
    "GimbalPitch": NUMBER,
    "StartFromTop": FLAG,
    "CameraCalc": OBJECT,
    "polygon": ARRAY,
}
_VERSIONS = {"survey": (2, 3, 4, 5), "CorridorScan": (2,), "StructureScan": (3,)}
_OLD_SURVEYS = (2, 3)
_LANDINGS = ("fwLandingPattern", "vtolLandingPattern")


class Pattern(NamedTuple):
    """The items that a ComplexItem carries, and whether QGroundControl makes others of it: how many, 0 where unknown."""

    items: tuple[PlanItem, ...] = ()
    hollow: bool = False
    made_n: int = 0


def pattern(item: dict[str, Any], place: str, findings: Findings) -> Pattern:
    """What of a ComplexItem could be read."""
    kind = item.get("complexItemType")
    place = f"{place} ({short(kind)})"
    if kind in _LANDINGS:
        findings.warning(
            place,
            "a landing pattern of fixed wings, not judged: only QGroundControl makes items of it; `mavspiral upload` refuses it",
        )
        return Pattern(hollow=True)
    if not isinstance(kind, str) or kind not in _VERSIONS:
        findings.error(place, "QGroundControl knows no such pattern")
        return Pattern()
    version = item.get("version")
    if version not in _VERSIONS[kind] or isinstance(version, bool):
        wanted = " or ".join(map(str, _VERSIONS[kind]))
        findings.error(place, f"version is {short(version)}, the loader takes {wanted}")
        return Pattern()
    if kind == "survey" and version in _OLD_SURVEYS:
        findings.warning(
            place,
            f"a survey of version {version}: QGroundControl makes it anew, it is not judged, and `mavspiral upload` refuses it. Fix: save it there once more",
        )
        return Pattern(hollow=True)
    if kind == "StructureScan":
        return Pattern(hollow=True, made_n=_structure(item, place, findings))
    keys = {"TransectStyleComplexItem": OBJECT} | (_SURVEY if kind == "survey" else _CORRIDOR)
    if not demand(item, keys, place, findings):
        return Pattern()
    if kind != "survey" or version != 5:
        findings.warning(place, "MAVSDK imports surveys of version 5 and no other pattern")
    transects = item["TransectStyleComplexItem"]
    if not demand(transects, _TRANSECTS, place, findings):
        return Pattern()
    judge_camera(transects["CameraCalc"], place, findings)
    inside: list[PlanItem] = []
    for number, simple in enumerate(transects["Items"], start=1):
        within = f"{place}.{number}"
        if isinstance(simple, dict) and simple.get("type") == "SimpleItem":
            inside += simple_item(simple, within, findings)
        else:
            findings.error(within, "is no SimpleItem")
    return Pattern(tuple(inside))


def _structure(item: dict[str, Any], place: str, findings: Findings) -> int:
    """How many items QGroundControl makes of it: (corners + 3) · layers + 4."""
    if not demand(item, _STRUCTURE, place, findings):
        return 0
    judge_camera(item["CameraCalc"], place, findings)
    findings.warning(
        place,
        "keeps no mission items in the file: only QGroundControl can fly it, not MAVSDK; `mavspiral upload` refuses it",
    )
    corners = [place_of(corner, 2) for corner in item["polygon"]]
    if len(corners) < 3 or None in corners:
        findings.error(place, "polygon is not three or more of [latitude, longitude]")
        return 0
    layers = item["Layers"]
    if not 1 <= layers <= 10_000:
        findings.error(place, f"Layers is {short(layers)}, wanted one or more")
        return 0
    return (len(corners) + 3) * int(layers) + 4
