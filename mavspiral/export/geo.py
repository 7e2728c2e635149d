"""The flight in Google Earth and any other viewer of KML: one line in space for each leg."""

from __future__ import annotations

from xml.sax.saxutils import escape

from mavspiral.frames import LocalFrame
from mavspiral.motion.trajectory import Trajectory, belongs

__all__ = ["trajectory_kml"]

GRID_S = 0.5
INSPECTION_COLOUR = "ff0e8ce6"
OTHER_COLOUR = "ffb0b0b0"


def trajectory_kml(trajectory: Trajectory, frame: LocalFrame, name: str) -> str:
    """The legs as KML LineStrings in WGS-84, heights above mean sea level."""
    legs = []
    for leg in trajectory.legs:
        begin_s, end_s = trajectory.span_s(leg.name)
        count = max(2, int((end_s - begin_s) / GRID_S) + 1)
        states = trajectory([begin_s + (end_s - begin_s) * i / (count - 1) for i in range(count)])
        colour = INSPECTION_COLOUR if belongs(leg.name, "inspection") else OTHER_COLOUR
        lat, lon, alt = frame.to_geodetic(states.position_enu_m)
        line = " ".join(f"{o:.7f},{a:.7f},{h:.2f}" for a, o, h in zip(lat, lon, alt, strict=True))
        legs.append(
            f"<Placemark><name>{escape(leg.name)}</name>"
            f"<Style><LineStyle><color>{colour}</color><width>2</width></LineStyle>"
            "</Style>"
            f"<LineString><altitudeMode>absolute</altitudeMode><coordinates>{line}</coordinates></LineString></Placemark>"
        )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2"><Document>'
        f"<name>{escape(name)}</name>\n" + "\n".join(legs) + "\n</Document></kml>\n"
    )
