"""What is handed to an autopilot that flies by itself: the inspection as missions, and as `.plan` documents."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from mavspiral.errors import LimitError
from mavspiral.export.camera_items import camera_orders, shot_stops_s
from mavspiral.export.fences import safe_area
from mavspiral.export.fitting import Board, Fit, fitted
from mavspiral.export.items import MissionItems, mission_items
from mavspiral.export.own_plan import own_notes
from mavspiral.export.plan_file import plan_document
from mavspiral.export.sorties import sorties_of
from mavspiral.export.thinning import Thinned, Tolerance, thin
from mavspiral.planner import Inspection
from mavspiral.survey.solids import Solids

__all__ = ["inspection_documents", "inspection_missions", "mission_warnings"]


def inspection_missions(inspection: Inspection) -> Fit:
    """The inspection as the fewest missions that fit the board, as exact as it and the clearance allow.

    Raises:
        LimitError: there are none.
    """
    mission, trajectory, shots = inspection.mission, inspection.trajectory, inspection.shots
    stops_s = shot_stops_s(mission.camera.trigger, shots)
    orders = camera_orders(
        mission.camera.trigger,
        shots,
        interval_min_s=mission.camera.min_interval_s,
        speed_mps=float(np.sqrt((trajectory(shots.t_s).velocity_enu_mps ** 2).sum(axis=1)).max()),
    )

    @cache
    def whole(tolerance: Tolerance) -> Thinned:
        return thin(trajectory, tolerance, stops_s)

    def yaw_at(t_s: float) -> float:
        return float(trajectory(t_s).yaw_enu_rad)

    def made(tolerance: Tolerance, count: int) -> tuple[MissionItems, ...]:
        return tuple(
            mission_items(
                sortie,
                inspection.site.heights.frame,
                inspection.home_enu_m,
                autopilot=mission.vehicle.autopilot,
                camera=orders,
            )
            for sortie in sorties_of(whole(tolerance), count, inspection.way_home, tolerance, yaw_at)
        )

    board = Board(mission.vehicle.max_items, mission.vehicle.endurance_s)
    try:
        return fitted(made, board, Solids.of_map(inspection.site.heights), inspection.clearance_required_m)
    except LimitError as refusal:
        raise LimitError(f"{mission.name}: {refusal}") from None


def inspection_documents(inspection: Inspection, fit: Fit) -> tuple[dict[str, Any], ...]:
    """Those missions as `.plan` files, each complete."""
    mission, heights = inspection.mission, inspection.site.heights
    area = safe_area(
        inspection.clearance.position_enu_m,
        heights,
        inspection.home_enu_m,
        margin_m=mission.limits.clearance_m,
        return_m=min(inspection.safe_height_enu_m, mission.limits.ceiling_m),
    )
    count = len(fit.missions)
    return tuple(
        plan_document(
            items,
            heights.frame,
            area,
            own_notes(
                mission, items, sortie=(number, count), clearance_m=fit.clearance_m, fence=area.omitted
            ),
        )
        for number, items in enumerate(fit.missions, start=1)
    )


def mission_warnings(fit: Fit, items_max: int) -> tuple[str, ...]:
    """What it costs to fly the files rather than the stream, in words; nothing where it costs nothing out of the way."""
    told = []
    if fit.coarser > 1.0:
        chord_m = max(mission.thinned.chord_error_m for mission in fit.missions)
        heading_deg = math.degrees(max(mission.thinned.heading_error_rad for mission in fit.missions))
        told.append(
            f"[vehicle] max_items = {items_max}: the .plan's waypoints are up to {chord_m:.2f} m and {heading_deg:.0f}° off the "
            f"curve, its corners keep {fit.clearance_m:.2f} m of clearance"
        )
    if len(fit.missions) > 1:
        told.append(
            f"the mission is in {len(fit.missions)} sorties ([vehicle] max_items and endurance_s), each from take-off to return"
        )
    return tuple(told)
