"""SmartRTL: home along the way it came.

Source: ArduPilot 4.6, AP_SmartRTL.cpp: places SRTL_ACCURACY apart, thinned by Ramer, Douglas and Peucker. Simpler: loops are not cut.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from sitl.autopilot.glide import Glide
from sitl.autopilot.trip import Stop, Trip, fly_home
from sitl.condition import Condition
from sitl.status import Home

__all__ = ["Trail", "fly_back"]

_LEAST_M, _MOST_POINTS = 0.5, 500
_Crumb = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Trail:
    """Where it has been since it armed, NED in metres. `full`: there was no room for more, so that it cannot be flown."""

    crumbs: tuple[_Crumb, ...] = ()
    full: bool = False

    def longer(self, condition: Condition, parameters: Mapping[str, float]) -> Trail:
        """With the present place, when it is far enough from the last."""
        if self.full:
            return self
        north_m, east_m, down_m = condition.estimate.position_ned_m.tolist()
        here, apart_m = (north_m, east_m, down_m), max(_LEAST_M, parameters["SRTL_ACCURACY"])
        if self.crumbs and math.dist(self.crumbs[-1], here) < apart_m:
            return self
        crumbs = (*self.crumbs, here)
        room = min(_MOST_POINTS, int(parameters["SRTL_POINTS"]))
        if len(crumbs) > room:
            crumbs = _thinned(crumbs, 0.5 * apart_m)
        return replace(self, crumbs=crumbs, full=len(crumbs) > room)

    @property
    def leads_home(self) -> bool:
        """Whether it can be flown."""
        return bool(self.crumbs) and not self.full


def fly_back(glide: Glide, home: Home | None, trail: Trail, parameters: Mapping[str, float]) -> Trip:
    """Back along the trail, and down at home."""
    crumbs = _thinned(trail.crumbs, 0.5 * max(_LEAST_M, parameters["SRTL_ACCURACY"]))
    last = fly_home(glide, home, parameters)
    way = tuple(Stop(complex(north_m, east_m), down_m) for north_m, east_m, down_m in reversed(crumbs[1:]))
    if home is None or not way:
        return last
    above = replace(last.stops[-2], down_m=way[-1].down_m)
    return last._replace(stops=(*way, above, last.stops[-1]))


def _thinned(crumbs: tuple[_Crumb, ...], within_m: float) -> tuple[_Crumb, ...]:
    """The fewest of these places whose straight joins keep within that distance of the others."""
    kept, spans = {0, len(crumbs) - 1}, [(0, len(crumbs) - 1)]
    while spans:
        begin, end = spans.pop()
        worst = max(
            range(begin + 1, end), key=lambda i: _off_m(crumbs[i], crumbs[begin], crumbs[end]), default=None
        )
        if worst is not None and _off_m(crumbs[worst], crumbs[begin], crumbs[end]) > within_m:
            kept.add(worst)
            spans += [(begin, worst), (worst, end)]
    return tuple(crumbs[i] for i in sorted(kept))


def _off_m(point: _Crumb, begin: _Crumb, end: _Crumb) -> float:
    way = [b - a for a, b in zip(begin, end, strict=True)]
    to = [p - a for a, p in zip(begin, point, strict=True)]
    square = sum(w * w for w in way)
    share = min(1.0, max(0.0, sum(w * t for w, t in zip(way, to, strict=True)) / square)) if square else 0.0
    return math.dist(to, [share * w for w in way])
