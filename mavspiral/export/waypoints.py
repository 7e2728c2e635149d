"""The plain-text mission of ArduPilot's and pymavlink's tools: `QGC WPL 110`, row 0 is home."""

from __future__ import annotations

import math

from mavspiral.export.items import Item, MissionItems

__all__ = ["waypoints_text"]


def waypoints_text(mission: MissionItems) -> str:
    """Tab-separated rows of seq, current, frame, command, four params, lat, lon, alt, autocontinue.

    NaN is not portable in this format, so a parameter that is the autopilot's to choose is written as 0.
    """
    home = mission.home
    rows = ["QGC WPL 110", _row(0, Item(16, 0, (0, 0, 0, 0, home.lat_deg, home.lon_deg, home.alt_amsl_m)))]
    rows += [_row(number, item) for number, item in enumerate(mission.items, start=1)]
    return "\n".join(rows) + "\n"


def _row(number: int, item: Item) -> str:
    p1, p2, p3, p4, x, y, z = (0.0 if math.isnan(value) else value for value in item.params)
    current = 1 if number == 0 else 0
    numbers = [f"{p1:.6f}", f"{p2:.6f}", f"{p3:.6f}", f"{p4:.6f}", f"{x:.8f}", f"{y:.8f}", f"{z:.6f}"]
    return "\t".join([str(number), str(current), str(item.frame), str(item.command), *numbers, "1"])
