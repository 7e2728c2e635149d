"""A plan's gaps, filled: lines for what is unseen though some safe pose could see it, kept only if they help."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.brief import camera_of, demand_of, limits_of, pace_of, room_of, sharpness_of
from mavspiral.errors import LimitError
from mavspiral.mission import Mission
from mavspiral.motion.limits import Limits
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.pieces.fill_lines import WORTH_SHARE, Filler
from mavspiral.proof import failures_of, proof_of
from mavspiral.shape.courts import enclosed_ground
from mavspiral.shape.heightmap import Site
from mavspiral.survey.certificate import Certificate
from mavspiral.survey.clearance import Clearance
from mavspiral.survey.coverage import Coverage, measure_coverage
from mavspiral.survey.patches import Patches
from mavspiral.survey.seeable import Room, with_best_poses
from mavspiral.survey.shots import Shots, shots_of
from mavspiral.tour.order import quickest_order
from mavspiral.tour.passes import Pass, flown_in_order, tour_of
from mavspiral.tour.route import route_of
from mavspiral.tour.transit import MARGIN_M, Ways

__all__ = ["Draft", "filled", "survey_of", "with_seeable"]

ROUNDS = 2
"""Lines are looked for, flown and measured so often at the most: a plan with gaps costs so many more proofs and surveys."""
JOINABLE_M = 0.1
"""A line keeps so much more than the clearance of the transits that join it."""


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A plan so far: what is flown, and its proof."""

    passes: tuple[Pass, ...]
    tour: tuple[Leg, ...]
    trajectory: Trajectory
    clearance: Clearance
    certificate: Certificate
    shots: Shots
    coverage: Coverage
    told: tuple[str, ...] = ()


def survey_of(
    mission: Mission,
    site: Site,
    passes: tuple[Pass, ...],
    trajectory: Trajectory,
    patches: Patches,
    best_pose: NDArray[np.int64] | None = None,
) -> tuple[Shots, Coverage]:
    """The shots of a trajectory along these passes, and what they show of the patches, whose best poses may be known."""
    camera = camera_of(mission)
    shots = shots_of(
        trajectory,
        camera,
        standoffs_m=[part.standoff_m for part in passes],
        side_overlap=mission.inspection.side_overlap,
    )
    return shots, measure_coverage(patches, shots, site, camera, demand_of(mission), best_pose)


def with_seeable(draft: Draft, mission: Mission, site: Site, ways: Ways) -> Draft:
    """The draft with what any safe pose could see."""
    room = room_of(mission, ways.clearance_m)
    roofs = mission.inspection.roof
    return replace(
        draft,
        coverage=with_best_poses(draft.coverage, site, ways.solids, camera_of(mission), room, roofs=roofs),
    )


def filled(draft: Draft, mission: Mission, site: Site, home_enu_m: FloatArray, ways: Ways) -> Draft:
    """The draft, which knows what is seeable, with a line for each gap that is worth one.

    In the paper's mode, which is there for comparison, nothing is added.
    """
    camera, asked = camera_of(mission), mission.inspection
    if asked.mode == "paper":
        return draft
    safe = room_of(mission, ways.clearance_m)
    wished = Room(
        safe.clearance_m + MARGIN_M + JOINABLE_M,
        safe.lowest_m if asked.bottom_m is None else asked.bottom_m,
        safe.highest_m if asked.top_m is None else asked.top_m,
    )
    sharp_mps, pace = sharpness_of(mission, camera), pace_of(mission, camera, limits_of(mission))
    filler = Filler(
        site,
        np.zeros_like(site.building) if asked.courtyards else enclosed_ground(site.building),
        ways.solids,
        camera,
        wished,
        pace,
        sharp_mps,
        asked.side_overlap,
        mission.vehicle.radius_m,
        asked.roof,
    )
    made = 0
    for _ in range(ROUNDS):
        lines = filler.pieces(draft.coverage, first=made + 1)
        made += len(lines)
        if not lines:
            break
        joined, told = _joined(draft, flown_in_order(lines, sharp_mps), mission, site, home_enu_m, ways, pace)
        draft = replace(draft, told=(*draft.told, *told))
        if joined is None:
            break
        passes, flight = joined
        survey = survey_of(
            mission, site, passes, flight.trajectory, draft.coverage.patches, draft.coverage.best_pose
        )
        with_lines = Draft(passes, *flight, *survey, draft.told)
        if _seen(with_lines) < _seen(draft) + WORTH_SHARE:
            break
        draft = with_lines
    return draft


class _Flight(NamedTuple):
    tour: tuple[Leg, ...]
    trajectory: Trajectory
    clearance: Clearance
    certificate: Certificate


def _joined(
    draft: Draft,
    lines: tuple[Pass, ...],
    mission: Mission,
    site: Site,
    home_enu_m: FloatArray,
    ways: Ways,
    pace: Limits,
) -> tuple[tuple[tuple[Pass, ...], _Flight] | None, tuple[str, ...]]:
    """The draft's passes with the lines among them, and in words which are left out: those that no safe way joins, or that fail a limit."""

    def tried(more: tuple[Pass, ...]) -> tuple[tuple[Pass, ...], _Flight]:
        passes = _in_order((*draft.passes, *more), home_enu_m, pace)
        tour = tour_of(passes, ways)
        trajectory = route_of(site, tour, home_enu_m, ways)
        flight = _Flight(tour, trajectory, *proof_of(mission, site, trajectory, ways.clearance_m))
        if not flight.certificate.ok:
            raise LimitError("; ".join(failures_of(mission, site, trajectory, flight.certificate)))
        return passes, flight

    try:
        return tried(lines), ()
    except LimitError:  # not all of them: one after the other
        joined, kept, told = None, list[Pass](), list[str]()
        for line in lines:
            try:
                joined = tried((*kept, line))
                kept.append(line)
            except LimitError as error:
                place = site.heights.frame.geo_point(line.path(0.0))
                told.append(
                    f"not flown: a line for what is unseen at lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, "
                    f"{line.path(0.0)[2]:.1f} m up: {error}"
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


def _seen(draft: Draft) -> float:
    """The shares of walls and roofs that are seen, added up."""
    shares = np.array([draft.coverage.walls, draft.coverage.roof])
    return float(np.nansum(shares))
