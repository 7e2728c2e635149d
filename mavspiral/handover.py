"""What is handed to an autopilot that flies by itself: the inspection as missions, and as `.plan` documents.

A sortie is what it is when streamed: a stretch of the inspection, with a way of its own from home and back. AUTO is
slower, and a board holds only so many items: so there may be more of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np

from mavspiral.errors import InputError, LimitError
from mavspiral.export.camera_items import camera_orders, shot_stops_s
from mavspiral.export.fences import SafeArea, safe_area
from mavspiral.export.fitting import AROUND_S, AUTO_SLOWER, Fit, fitted
from mavspiral.export.items import MissionItems, mission_items
from mavspiral.export.own_plan import own_notes
from mavspiral.export.plan_file import plan_document
from mavspiral.export.thinning import Tolerance, thin
from mavspiral.inspection import Inspection
from mavspiral.motion.trajectory import Trajectory
from mavspiral.proof import CLEARANCE_GRID_S
from mavspiral.survey.shots import Shots
from mavspiral.survey.solids import Solids
from mavspiral.tour.sorties import OVERLAP_SHOTS_N, Sortie, shots_on

__all__ = [
    "AutoSortie",
    "Handover",
    "inspection_documents",
    "inspection_missions",
    "mission_warnings",
    "the_document",
]

SORTIES_MAX = 24
"""Into more a stretch is not cut."""

FIX = "or stream it with `mavspiral fly`"


@dataclass(frozen=True, slots=True, eq=False)
class AutoSortie:
    """A stretch of the inspection, the route that flies it from home and back, and the mission of that."""

    sortie: Sortie
    route: Trajectory
    fit: Fit
    area: SafeArea


@dataclass(frozen=True, slots=True, eq=False)
class Handover:
    """The inspection as missions, and in words why stretches of it have none."""

    sorties: tuple[AutoSortie, ...]
    refusals: tuple[str, ...]

    @property
    def missions(self) -> tuple[MissionItems, ...]:
        """The mission of each sortie."""
        return tuple(auto.fit.mission for auto in self.sorties)

    @property
    def clearance_m(self) -> float:
        """The least clearance of them all, corners cut."""
        return min((auto.fit.clearance_m for auto in self.sorties), default=math.inf)


@dataclass(frozen=True, slots=True)
class _Refusal:
    """A stretch of the inspection's own time that has no mission: which limit forbids it, and by how much."""

    begin_s: float
    end_s: float
    limit: str
    reason: str


def inspection_missions(inspection: Inspection) -> Handover:
    """The inspection as the fewest missions that fit battery and board, as exact as the board and the clearance allow.

    Where AUTO is too slow for the battery to fly all of it, the sorties of the stream that it can fly.
    """
    endurance_s = (inspection.mission.vehicle.endurance_s - AROUND_S) / AUTO_SLOWER
    try:
        sorties = inspection.sorties(endurance_s=endurance_s)
    except LimitError:
        sorties = inspection.sorties()
    flights: list[AutoSortie] = []
    refusals: list[_Refusal] = []
    for sortie in sorties:
        handed = _handed(inspection, sortie)
        if isinstance(handed, _Refusal):
            refusals.append(handed)
        else:
            flights += handed
    return Handover(tuple(flights), _words(inspection, refusals))


def inspection_documents(inspection: Inspection, handover: Handover) -> tuple[dict[str, Any], ...]:
    """Those missions as `.plan` files, each complete."""
    count = len(handover.sorties)
    return tuple(
        plan_document(
            auto.fit.mission,
            inspection.site.heights.frame,
            auto.area,
            own_notes(
                inspection.mission,
                auto.fit.mission,
                sortie=(number, count),
                inspection_s=(auto.sortie.begin_s, auto.sortie.end_s),
                clearance_m=auto.fit.clearance_m,
                fence=auto.area.omitted,
            ),
        )
        for number, auto in enumerate(handover.sorties, start=1)
    )


def the_document(inspection: Inspection) -> dict[str, Any]:
    """The one `.plan` that flies all of the inspection.

    Raises:
        LimitError: a stretch of it has no mission.
        InputError: it takes more than one.
    """
    path, handover = inspection.mission.path, inspection_missions(inspection)
    if handover.refusals:
        raise LimitError(f"{path}: {handover.refusals[0]}")
    documents = inspection_documents(inspection, handover)
    if len(documents) > 1:
        raise InputError(
            f"{path}: the mission is in {len(documents)} sorties. Fix: `mavspiral plan`, then upload the .plan of the one to fly"
        )
    return documents[0]


def mission_warnings(handover: Handover, items_max: int) -> tuple[str, ...]:
    """What it costs to fly the files rather than the stream, in words; nothing where it costs nothing out of the way."""
    told = list(handover.refusals)
    if any(auto.fit.coarser > 1.0 for auto in handover.sorties):
        chord_m = max(mission.thinned.chord_error_m for mission in handover.missions)
        heading_deg = math.degrees(max(mission.thinned.heading_error_rad for mission in handover.missions))
        told.append(
            f"[vehicle] max_items = {items_max}: the .plan's waypoints are up to {chord_m:.2f} m and {heading_deg:.0f}° off the "
            f"curve, its corners keep {handover.clearance_m:.2f} m of clearance"
        )
    if len(handover.sorties) > 1:
        told.append(
            f"as missions it is in {len(handover.sorties)} sorties ([vehicle] max_items and endurance_s), each from take-off "
            "to return"
        )
    told += dict.fromkeys(f".plan: {auto.area.omitted}" for auto in handover.sorties if auto.area.omitted)
    return tuple(told)


def _handed(inspection: Inspection, sortie: Sortie) -> list[AutoSortie] | _Refusal:
    """The fewest missions that fly the sortie, or why there are none."""
    vehicle = inspection.mission.vehicle
    parts: tuple[Sortie, ...] = (sortie,)
    whole: AutoSortie | None = None
    refusal = _Refusal(sortie.begin_s, sortie.end_s, "", "")
    while parts and len(parts) <= SORTIES_MAX:
        flights: list[AutoSortie] = []
        for part in parts:
            try:
                flights.append(_flight(inspection, part))
            except LimitError as error:
                return _Refusal(sortie.begin_s, sortie.end_s, "clearance", str(error))
            whole = whole or flights[-1]
            route, items_n = flights[-1].route, len(flights[-1].fit.mission.items)
            begin_s, end_s = route.span_s("inspection")
            lasts_s, way_s = _auto_s(route.duration_s), _auto_s(route.duration_s - (end_s - begin_s))
            if lasts_s > vehicle.endurance_s:
                refusal = _Refusal(
                    sortie.begin_s,
                    sortie.end_s,
                    "endurance_s",
                    f"[vehicle] endurance_s = {vehicle.endurance_s:g}: even in {len(parts)} sorties AUTO takes {lasts_s:.0f} s "
                    f"for one, {way_s:.0f} s there and back ({AUTO_SLOWER} times as planned, and {AROUND_S:.0f} s). Fix: a larger endurance_s, {FIX}",
                )
                if way_s >= vehicle.endurance_s:
                    return refusal
                break
            if items_n > vehicle.max_items:
                refusal = _Refusal(
                    sortie.begin_s,
                    sortie.end_s,
                    "max_items",
                    f"[vehicle] max_items = {vehicle.max_items}: even in {len(parts)} sorties one of them takes {items_n} items. "
                    f"Fix: a larger max_items, {FIX}",
                )
                break
        else:
            return flights
        parts = _cut(inspection, whole, len(parts) + 1)
    return refusal


def _flight(inspection: Inspection, sortie: Sortie) -> AutoSortie:
    """A sortie as a mission, whether it fits or not.

    Raises:
        LimitError: none keeps the clearance.
    """
    mission, heights = inspection.mission, inspection.site.heights
    whole = sortie.legs == inspection.tour
    route = inspection.trajectory if whole else inspection.route_from(inspection.home_enu_m, sortie)
    shots = inspection.shots if whole else _shots(inspection, sortie, route)
    stops_s = shot_stops_s(mission.camera.trigger, shots)

    def made(tolerance: Tolerance, *, turns: bool) -> MissionItems:
        thinned = thin(route, tolerance, stops_s, turns=turns)
        orders = camera_orders(
            mission.camera.trigger, shots, thinned, interval_min_s=mission.camera.min_interval_s
        )
        return mission_items(
            thinned,
            heights.frame,
            inspection.home_enu_m,
            autopilot=mission.vehicle.autopilot,
            camera=orders,
            gimbal=mission.camera.gimbal,
        )

    def best(turns: bool) -> Fit:
        return fitted(
            partial(made, turns=turns),
            mission.vehicle.max_items,
            Solids.of_map(heights),
            inspection.clearance_required_m,
        )

    def lacks(fit: Fit) -> tuple[bool, float]:
        return len(fit.mission.items) > mission.vehicle.max_items, fit.coarser

    fit = best(turns=mission.vehicle.autopilot == "ardupilot")
    if mission.vehicle.autopilot == "ardupilot" and lacks(fit) > (False, 1.0):
        fit = min(fit, best(turns=False), key=lacks)  # aims take fewer items than turns
    area = safe_area(
        route.sampled(CLEARANCE_GRID_S).position_enu_m,
        inspection.site,
        inspection.home_enu_m,
        margin_m=mission.limits.clearance_m,
        return_m=min(inspection.safe_height_enu_m, mission.limits.ceiling_m),
    )
    return AutoSortie(sortie, route, fit, area)


def _shots(inspection: Inspection, sortie: Sortie, route: Trajectory) -> Shots:
    """The sortie's shots, with their path times on its route."""
    t_s = shots_on(sortie, inspection.shots_s, route)
    states = route(t_s)
    return Shots(t_s, states.position_enu_m, states.yaw_enu_rad, states.gimbal_pitch_rad)


def _cut(inspection: Inspection, whole: AutoSortie, count: int) -> tuple[Sortie, ...]:
    """The sortie in `count` of about as many waypoints, with the overlap of sorties; nothing if that leaves too few shots."""
    sortie, shots_s = whole.sortie, inspection.shots_s
    shots_s = shots_s[(shots_s > sortie.begin_s) & (shots_s < sortie.end_s)]
    since_s = whole.fit.mission.thinned.t_s - whole.route.span_s("inspection")[0]
    wanted_s = np.nanquantile(sortie.inspection_s(since_s), np.linspace(0.0, 1.0, count + 1)[1:-1])
    rows = np.searchsorted(shots_s, wanted_s)
    if np.diff(rows, prepend=0, append=len(shots_s)).min() <= OVERLAP_SHOTS_N:
        return ()
    begins_s = [sortie.begin_s, *shots_s[rows - OVERLAP_SHOTS_N]]
    ends_s = [*shots_s[rows], sortie.end_s]
    return tuple(
        inspection.sortie(float(begin_s), float(end_s))
        for begin_s, end_s in zip(begins_s, ends_s, strict=True)
    )


def _auto_s(planned_s: float) -> float:
    """How long AUTO takes for what the plan flies in `planned_s`, from home to home."""
    return AUTO_SLOWER * planned_s + AROUND_S


def _words(inspection: Inspection, refusals: list[_Refusal]) -> tuple[str, ...]:
    """One line for each row of stretches that the same limit forbids."""
    told = []
    for _, row in groupby(refusals, key=lambda refusal: refusal.limit):
        stretches = list(row)
        told.append(
            f"no .plan for the inspection from {stretches[0].begin_s:.0f} to {stretches[-1].end_s:.0f} of "
            f"{inspection.duration_s:.0f} s: {stretches[-1].reason}"
        )
    return tuple(told)
