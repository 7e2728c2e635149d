"""What speaks against a fence that has been uploaded whole: then ArduPilot does not take it.

Source: ArduPilot 4.6, AC_PolyFence_loader.cpp, validate_fence, and MissionItemProtocol_Fence.cpp, complete.
"""

from __future__ import annotations

from collections.abc import Sequence

from pymavlink.dialects.v20 import common

from sitl.plans import PlanItem

__all__ = ["fence_fault"]

_POLYGONS = (
    common.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    common.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
)
_CIRCLES = (common.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, common.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION)
_FEWEST = 3


def fence_fault(items: Sequence[PlanItem]) -> str | None:
    """What is wrong: a polygon that has not as many corners in a row as each of them says, or no area."""
    kind = corners = missing = 0
    for item in items:
        count = int(item.params[0])
        if missing and item.command != kind:
            return f"Received incorrect vertex type (want={kind} got={item.command})"
        if item.command in _CIRCLES and not item.params[0] > 0.0:
            return "Non-positive circle radius"
        if item.command not in _POLYGONS:
            continue
        if count < _FEWEST:
            return f"Invalid vertex count ({count})"
        if not missing:
            kind, corners, missing = item.command, count, count
        if count != corners:
            return f"Unexpected vertex count want={corners} got={count}"
        missing -= 1
    return f"Incorrect item count (want={corners} got={corners - missing})" if missing else None
