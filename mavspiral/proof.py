"""The proof of a plan: its certificate, what it sees, and in words where it fails."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mavspiral.brief import camera_of, demand_of, limits_of, smaller_clearance
from mavspiral.errors import LimitError
from mavspiral.headway import Headway, to_nobody
from mavspiral.mission import Mission
from mavspiral.motion.trajectory import Trajectory
from mavspiral.shape.heightmap import Site
from mavspiral.survey.certificate import (
    STRAIGHT_ON,
    Certificate,
    blur_figure,
    ceiling_figure,
    clearance_figures,
    gimbal_figure,
    motion_figures,
)
from mavspiral.survey.clearance import Clearance, measure_clearance, run_on_m
from mavspiral.survey.coverage import Coverage, measure_coverage
from mavspiral.survey.patches import Patches
from mavspiral.survey.peaks import peaks_of
from mavspiral.survey.shots import Shots, shots_of
from mavspiral.survey.solids import Solids
from mavspiral.tour.obstacle import nearest_obstacle
from mavspiral.tour.passes import Pass
from mavspiral.tour.transit import REACTION_S

__all__ = ["CLEARANCE_GRID_S", "failures_of", "judge_limits", "judge_sight", "proof_of", "survey_of"]

GRID_S = 0.01
"""Limits are judged on this grid."""

CLEARANCE_GRID_S = 0.2
"""Clearance is that of the straight ways between places this far apart: at 5 m/s and 2 m/s² within 1 cm of the curve."""


def proof_of(
    mission: Mission, solids: Solids, trajectory: Trajectory, required_m: float
) -> tuple[Clearance, Certificate]:
    """The clearance from the solids all along a trajectory, and every limit of the mission against it."""
    limits = limits_of(mission)
    peaks = peaks_of(trajectory, trajectory.grid_s(GRID_S))
    clearance = measure_clearance(
        trajectory.sampled(CLEARANCE_GRID_S),
        solids,
        reaction_s=REACTION_S,
        braking_mps2=limits.acceleration_mps2,
    )
    return clearance, Certificate(
        (
            *motion_figures(peaks, limits),
            blur_figure(peaks, camera_of(mission), mission.quality.blur_max_px),
            gimbal_figure(peaks),
            *clearance_figures(clearance, required_m=required_m, vehicle_radius_m=mission.vehicle.radius_m),
            ceiling_figure(peaks, mission.limits.ceiling_m),
        )
    )


def failures_of(
    mission: Mission, site: Site, trajectory: Trajectory, certificate: Certificate
) -> tuple[str, ...]:
    """Each limit that does not hold: value, limit, moment, place on earth, and what is too near."""
    told = []
    for figure in certificate.figures:
        if figure.ok:
            continue
        place = site.heights.frame.geo_point(np.array(figure.at_enu_m))
        line = f"{figure} (lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f})"
        if figure.at_least:
            states = trajectory.sampled(CLEARANCE_GRID_S)
            row = int(np.argmin(np.abs(states.t_s - figure.at_t_s)))
            if figure.name == STRAIGHT_ON:
                sweep_m = run_on_m(states.velocity_enu_mps[row], REACTION_S, mission.limits.acceleration_mps2)
            else:
                after = states.position_enu_m[min(row + 1, len(states.t_s) - 1)]
                sweep_m = after - states.position_enu_m[row]
            line += f", from {nearest_obstacle(mission, site, states.position_enu_m[row], sweep_m)}"
        told.append(line)
    return tuple(told)


def judge_limits(mission: Mission, site: Site, trajectory: Trajectory, certificate: Certificate) -> None:
    """Refuses a plan that fails its limits.

    Raises:
        LimitError: with each limit, the place, and what would do.
    """
    if certificate.ok:
        return
    failures = "; ".join(failures_of(mission, site, trajectory, certificate))
    raise LimitError(
        f"{mission.name}: the plan fails its limits: {failures}. Fix: {_remedy(mission, certificate)}"
    )


def judge_sight(mission: Mission, coverage: Coverage) -> None:
    """Refuses a plan that sees no wall at all, or has none to see.

    Raises:
        LimitError: with what a pixel is, and what would do.
    """
    if math.isnan(coverage.walls) and not (mission.inspection.roof and mission.camera.gimbal):
        raise LimitError(
            f"{mission.name}: the building has no wall of its own to be seen: all that stands around it is as high. "
            "Fix: another [building] at or id, a map that tells the building from what stands beside it, or roof = true"
        )
    if coverage.walls == 0.0:
        quality, standoff_m = mission.quality, mission.inspection.standoff_m
        raise LimitError(
            f"{mission.name}: no wall is seen as [quality] asks, in views_min = {quality.views_min} pictures of gsd_max_mm = "
            f"{quality.gsd_max_mm:g} (at standoff_m = {standoff_m:g} a pixel is {1e3 * camera_of(mission).gsd_m(standoff_m):.1f} mm) "
            f"and incidence_max_deg = {quality.incidence_max_deg:g}. Fix: ask for less, or a band (bottom_m, top_m) beside the walls"
        )


def survey_of(
    mission: Mission,
    site: Site,
    passes: tuple[Pass, ...],
    trajectory: Trajectory,
    patches: Patches,
    best_pose: NDArray[np.int64] | None = None,
    headway: Headway = to_nobody,
) -> tuple[Shots, Coverage]:
    """The shots of a trajectory along these passes, and what they show of the patches, whose best poses may be known.

    `headway` is told how many of the shots have been looked through.
    """
    camera = camera_of(mission)
    shots = shots_of(
        trajectory,
        camera,
        standoffs_m=[part.standoff_m for part in passes],
        side_overlap=mission.inspection.side_overlap,
    )
    return shots, measure_coverage(patches, shots, site, camera, demand_of(mission), best_pose, headway)


def _remedy(mission: Mission, certificate: Certificate) -> str:
    """In words: what to change for a plan that fails; where something is too near, which clearance would do."""
    near, height = certificate["clearance"], certificate["height"]
    if not height.ok:
        return f"[limits] ceiling_m ≥ {math.ceil(height.worst)}, or a lower top_m, and above a roof [inspection] roof = false"
    elsewhere = "another standoff_m, or another band (bottom_m, top_m) away from it"
    if near.ok:
        return elsewhere
    would_do = smaller_clearance(mission, near.worst)
    return f"{would_do} is what this plan keeps; or {elsewhere}" if would_do else elsewhere
