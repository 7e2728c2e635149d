"""The proof of a plan: its certificate, and in words where it fails."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from mavspiral.brief import camera_of, limits_of
from mavspiral.mission import Mission
from mavspiral.motion.limits import Limits
from mavspiral.motion.trajectory import Trajectory, TrajectoryState, during
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
from mavspiral.tour.obstacle import nearest_obstacle
from mavspiral.tour.transit import REACTION_S

__all__ = ["CLEARANCE_GRID_S", "certificate_of", "failures_of", "proof_of", "remedy_of"]

GRID_S = 0.01
"""Limits are judged on this grid."""

CLEARANCE_GRID_S = 0.2
"""Clearance is that of the straight ways between places this far apart: at 5 m/s and 2 m/s² within 1 cm of the curve."""


def proof_of(
    mission: Mission, site: Site, trajectory: Trajectory, required_m: float
) -> tuple[Clearance, Certificate]:
    """The clearance all along a trajectory, and every limit of the mission against it."""
    limits = limits_of(mission)
    with ThreadPoolExecutor(max_workers=1) as beside:  # both are kernels that run without the interpreter
        measuring = beside.submit(
            measure_clearance,
            trajectory.sampled(CLEARANCE_GRID_S),
            site,
            reaction_s=REACTION_S,
            braking_mps2=limits.acceleration_mps2,
        )
        states = trajectory.sampled(GRID_S)
        clearance = measuring.result()
    return clearance, certificate_of(mission, trajectory, states, clearance, limits, required_m)


def certificate_of(
    mission: Mission,
    trajectory: Trajectory,
    states: TrajectoryState,
    clearance: Clearance,
    limits: Limits,
    required_m: float,
) -> Certificate:
    """Every limit of the mission against the states of its trajectory on a fine grid, and its clearance."""
    camera, allowed_px = camera_of(mission), mission.quality.blur_max_px
    blurs = [
        blur_figure(leg.sight, during(states, trajectory.span_s(leg.name)), camera, allowed_px)
        for leg in trajectory.legs
        if leg.sight is not None
    ]
    return Certificate(
        (
            *motion_figures(states, limits),
            max(blurs, key=lambda figure: figure.worst),
            gimbal_figure(states),
            *clearance_figures(clearance, required_m=required_m, vehicle_radius_m=mission.vehicle.radius_m),
            ceiling_figure(states, mission.limits.ceiling_m),
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


def remedy_of(certificate: Certificate) -> str:
    """In words: what to change for a plan that fails; where something is too near, which clearance would do."""
    near = certificate["clearance"]
    elsewhere = "another standoff_m, or another band (bottom_m, top_m) away from it"
    if near.ok:
        return elsewhere
    kept_m = math.floor(10.0 * near.worst) / 10.0
    return (
        f"a required clearance of {kept_m:.1f} m (now {near.allowed:.1f} m; [limits] clearance_m, or what the vehicle and its "
        f"errors take) is what this plan keeps; or {elsewhere}"
    )
