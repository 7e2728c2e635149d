"""The camera of a pattern, as QGroundControl's CameraCalc loads it."""

from __future__ import annotations

from typing import Any

from mavspiral.export.check.findings import Findings
from mavspiral.export.check.shape import FLAG, NUMBER, TEXT, demand, short

__all__ = ["judge_camera"]

_NEWEST = 2
_DISTANCES = {
    "CameraName": TEXT,
    "AdjustedFootprintSide": NUMBER,
    "AdjustedFootprintFrontal": NUMBER,
    "DistanceToSurface": NUMBER,
    "DistanceMode": NUMBER,
}
_MANUAL = "Manual (no camera specs)"
_SPECS = {
    "ValueSetIsDistance": FLAG,
    **dict.fromkeys(("ImageDensity", "FrontalOverlap", "SideOverlap"), NUMBER),
    **dict.fromkeys(("SensorWidth", "SensorHeight", "ImageWidth", "ImageHeight", "FocalLength"), NUMBER),
    "Landscape": FLAG,
    "FixedOrientation": FLAG,
    "MinTriggerInterval": NUMBER,
}


def judge_camera(calc: dict[str, Any], place: str, findings: Findings) -> bool:
    """Whether a CameraCalc of version 2 can be loaded; older ones are upgraded first, and are not judged."""
    version, place = calc.get("version", 0), f"{place} CameraCalc"
    if version in (0, 1):
        findings.warning(
            place, f"version is {short(version)}: QGroundControl makes it anew, it is not judged"
        )
        return True
    if version != _NEWEST or isinstance(version, bool):
        findings.error(place, f"version is {short(version)}, the loader takes {_NEWEST}")
        return False
    if not demand(calc, _DISTANCES, place, findings):
        return False
    return calc["CameraName"] == _MANUAL or demand(calc, _SPECS, place, findings)
