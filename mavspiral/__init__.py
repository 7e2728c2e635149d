"""mavspiral: one smooth spiral around a building, planned, flown in simulation, measured, and flown for real.

    mission = mavspiral.load_mission("missions/torre.toml")
    inspection = mavspiral.plan(mission)
    flight = mavspiral.simulate(mission, seed=1)
    flight.passed, flight.tracking_p95_m, flight.clearance_min_m

Units are SI and frames are ENU wherever a name does not say otherwise.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mavspiral.closedloop import simulate
    from mavspiral.errors import InputError, LimitError, LinkError, MavspiralError
    from mavspiral.frames import GeoPoint, LocalFrame
    from mavspiral.inspection import Inspection
    from mavspiral.live import fly
    from mavspiral.logbook.flown import Flight
    from mavspiral.logbook.live_flight import LiveFlight
    from mavspiral.mission import Mission, load_mission
    from mavspiral.motion.trajectory import Trajectory, TrajectoryState
    from mavspiral.planner import plan
    from mavspiral.shape.heightmap import HeightMap, Site

__all__ = [
    "Flight",
    "GeoPoint",
    "HeightMap",
    "InputError",
    "Inspection",
    "LimitError",
    "LinkError",
    "LiveFlight",
    "LocalFrame",
    "MavspiralError",
    "Mission",
    "Site",
    "Trajectory",
    "TrajectoryState",
    "__version__",
    "fly",
    "load_mission",
    "plan",
    "simulate",
]

__version__ = "0.1.0"

# Each name is imported when it is asked for: `mavspiral --help` needs none of them.
_ROOMS = {
    "Flight": "logbook.flown",
    "GeoPoint": "frames",
    "HeightMap": "shape.heightmap",
    "InputError": "errors",
    "LiveFlight": "logbook.live_flight",
    "Inspection": "inspection",
    "LimitError": "errors",
    "LinkError": "errors",
    "LocalFrame": "frames",
    "MavspiralError": "errors",
    "Mission": "mission",
    "Site": "shape.heightmap",
    "Trajectory": "motion.trajectory",
    "TrajectoryState": "motion.trajectory",
    "fly": "live",
    "load_mission": "mission",
    "plan": "planner",
    "simulate": "closedloop",
}


def __getattr__(name: str) -> Any:
    """The exported name, from its room."""
    if name not in _ROOMS:
        raise AttributeError(f"module 'mavspiral' has no attribute {name!r}")
    return getattr(importlib.import_module(f"mavspiral.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    """The exported names."""
    return __all__
