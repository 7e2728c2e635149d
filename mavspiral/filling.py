"""A plan's gaps, filled: lines and turns for what is unseen though some safe pose could see it, kept only if they help."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.brief import camera_of, limits_of, pace_of, room_of, sharpness_of
from mavspiral.errors import LimitError
from mavspiral.headway import Headway, to_nobody, within
from mavspiral.inspection import Inspection
from mavspiral.motion.limits import Limits
from mavspiral.pieces.filler import WORTH_SHARE, Filler
from mavspiral.proof import failures_of, proof_of, survey_of
from mavspiral.shape.courts import enclosed_ground
from mavspiral.survey.coverage import Coverage
from mavspiral.survey.seeable import Room, with_best_poses
from mavspiral.tour.order import quickest_order
from mavspiral.tour.passes import Pass, flown_in_order, tour_of
from mavspiral.tour.route import route_of
from mavspiral.tour.transit import JOINABLE_M, MARGIN_M, Ways

__all__ = ["filled", "flyable", "unasked_courts", "with_seeable"]

ROUNDS = 2
"""Fills are looked for, flown and measured so often at the most: a plan with gaps costs so many more proofs and surveys."""


def with_seeable(inspection: Inspection, ways: Ways, headway: Headway = to_nobody) -> Inspection:
    """The inspection with what any safe pose could see."""
    mission = inspection.mission
    coverage = with_best_poses(
        inspection.coverage,
        inspection.site,
        ways.solids,
        camera_of(mission),
        room_of(mission, ways.clearance_m),
        roofs=mission.inspection.roof,
        headway=headway,
    )
    return replace(inspection, coverage=coverage)


def filled(plain: Inspection, ways: Ways, headway: Headway = to_nobody) -> Inspection:
    """The inspection, which knows what is seeable, with a pass more for each gap that is worth one.

    In the paper's mode, which is there for comparison, nothing is added.
    """
    mission, inspection, made = plain.mission, plain, 0
    if mission.inspection.mode == "paper":
        return plain
    pace = pace_of(mission, camera_of(mission), limits_of(mission))
    filler = _filler(plain, ways, pace)
    for number in range(ROUNDS):
        looking = within(headway, number / ROUNDS, (number + 0.5) / ROUNDS)
        surveying = within(headway, (number + 0.5) / ROUNDS, (number + 1) / ROUNDS)
        pieces = filler.pieces(inspection.coverage, made + 1, looking)
        made += len(pieces)
        if not pieces:
            break
        joined, told = _joined(inspection, flown_in_order(pieces, filler.sharp_mps), ways, pace)
        inspection = replace(inspection, warnings=(*inspection.warnings, *told))
        if joined is None:
            break
        before = inspection.coverage
        shots, coverage = survey_of(
            mission,
            plain.site,
            joined.passes,
            joined.trajectory,
            before.patches,
            before.best_pose,
            surveying,
        )
        if _seen(coverage) < _seen(before) + WORTH_SHARE:
            break
        inspection = replace(joined, shots=shots, coverage=coverage, warnings=inspection.warnings)
    return inspection


def flyable(inspection: Inspection, plain: Inspection) -> Inspection:
    """The inspection if batteries last for it, else the plain one.

    Raises:
        LimitError: no battery lasts for that one either.
    """
    try:
        inspection.sorties()
        return inspection
    except LimitError as error:
        plain.sorties()
        told = f"not flown: the passes for what is unseen, with which no battery lasts: {error}"
        return replace(plain, warnings=(*plain.warnings, told))


def unasked_courts(inspection: Inspection) -> NDArray[np.bool_]:
    """Which cells `(rows, cols)` are in courtyards, if nobody asked for these."""
    building = inspection.site.building
    asked = inspection.mission.inspection.courtyards
    return np.zeros_like(building) if asked else enclosed_ground(building)


def _filler(inspection: Inspection, ways: Ways, pace: Limits) -> Filler:
    """What fills the gaps of this inspection: within its band, and not inside courtyards unasked."""
    mission, site = inspection.mission, inspection.site
    camera, asked = camera_of(mission), mission.inspection
    safe = room_of(mission, ways.clearance_m)
    wished = Room(
        safe.clearance_m + MARGIN_M + JOINABLE_M,
        safe.lowest_m if asked.bottom_m is None else asked.bottom_m,
        safe.highest_m if asked.top_m is None else asked.top_m,
    )
    return Filler(
        site=site,
        closed=unasked_courts(inspection),
        solids=ways.solids,
        camera=camera,
        room=wished,
        pace=pace,
        sharp_mps=sharpness_of(mission, camera),
        side_overlap=asked.side_overlap,
        radius_m=mission.vehicle.radius_m,
        roofs=asked.roof,
        home_enu_m=inspection.home_enu_m,
    )


def _joined(
    inspection: Inspection, fills: tuple[Pass, ...], ways: Ways, pace: Limits
) -> tuple[Inspection | None, tuple[str, ...]]:
    """The inspection with the fills among its passes, its survey aside, and in words which are left out.

    Left out are those that no safe way joins, or that fail a limit.
    """
    mission, site, home_enu_m = inspection.mission, inspection.site, inspection.home_enu_m

    def tried(more: tuple[Pass, ...]) -> Inspection:
        passes = _in_order((*inspection.passes, *more), home_enu_m, pace)
        tour = tour_of(passes, ways)
        trajectory = route_of(site, tour, home_enu_m, ways)
        clearance, certificate = proof_of(mission, ways.solids, trajectory, ways.clearance_m)
        if not certificate.ok:
            raise LimitError("; ".join(failures_of(mission, site, trajectory, certificate)))
        return replace(
            inspection,
            passes=passes,
            tour=tour,
            trajectory=trajectory,
            clearance=clearance,
            certificate=certificate,
        )

    try:
        return tried(fills), ()
    except LimitError:  # not all of them: one after the other
        joined, kept, told = None, list[Pass](), list[str]()
        for fill in fills:
            try:
                joined = tried((*kept, fill))
                kept.append(fill)
            except LimitError as error:
                place = site.heights.frame.geo_point(fill.path(0.0))
                told.append(
                    f"not flown: a pass for what is unseen, from lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, "
                    f"{fill.path(0.0)[2]:.1f} m up: {error}"
                )
        return joined, tuple(told)


def _in_order(passes: tuple[Pass, ...], home_enu_m: FloatArray, pace: Limits) -> tuple[Pass, ...]:
    """The passes in the quickest order, each with a leg of its own name."""
    order = quickest_order(
        np.array([part.path(0.0) for part in passes]),
        np.array([part.path(part.path.u_end_rad) for part in passes]),
        home_enu_m,
        pace,
    )
    named = [replace(part, leg=replace(part.leg, name=part.leg_name)) for part in passes]
    return tuple(named[i] for i in order)


def _seen(coverage: Coverage) -> float:
    """The shares of walls and roofs that are seen, added up."""
    return float(np.nansum([coverage.walls, coverage.roof]))
