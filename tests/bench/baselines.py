"""Our spiral against what others fly: `python tests/bench/baselines.py [MISSION…]`. Same limits, camera, heights, measure.

    spiral     as planned
    circles    a level ring at each of the spiral's heights, joined by straight lines (Cheng et al. 2008); its corners
               cannot be flown without stopping, so rest at both ends of each join is the fastest that the limits allow
    scan       QGroundControl's structure scan: one polygon around the building, offset by the stand-off with mitres,
               flown at the same heights; it stops at each vertex and turns there to the next wall
    scan/shot  the same, stopping for each picture too

From the first moment of the inspection to its last, without the ways from home and back. Blur is the way of the picture on
the sensor during the exposure of a shot, at the stand-off.
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

import cv2
import numpy as np

from mavspiral import load_mission, plan
from mavspiral.brief import camera_of, limits_of, pace_of
from mavspiral.curve.gaze import inward_gaze
from mavspiral.curve.line import LinePath
from mavspiral.curve.spiral import plan_spiral
from mavspiral.inspection import Inspection
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze
from mavspiral.shape.heightmap import Site
from mavspiral.shape.parts import parts_of
from mavspiral.shape.slicing import solid_distance
from mavspiral.survey.shots import Shots, shots_of
from mavspiral.survey.solids import Solids

ROOT = Path(__file__).parents[2]
MISSIONS = ("torre", "asilo", "kiosk")
STRAIGHT_M = 1.0
"""The scan's polygon leaves the footprint by no more than this."""
TURNING_M = 0.05
"""A vehicle that turns on the spot is given this much way, for a law wants some."""


def heights_m(inspection: Inspection) -> np.ndarray:
    """The spiral's lowest level turn, one for each turn that it climbs, its highest."""
    (part,) = inspection.passes
    ends = part.path([0.0, part.path.u_end_rad])[:, 2]
    return np.linspace(ends[0], ends[1], part.rings + 1)


def straight(name: str, start: np.ndarray, end: np.ndarray, yaws: tuple[float, float], limits: Limits) -> Leg:
    path, gaze = LinePath(start, end), TurnGaze(*yaws)
    return Leg(name, path, gaze, fastest_law(path, gaze, limits))


def circles(inspection: Inspection, pace: Limits) -> Trajectory:
    mission, legs = inspection.mission, []
    standoff_m, corner_radius_m = mission.inspection.standoff_m, pace.speed_mps**2 / pace.acceleration_mps2
    solid = solid_distance(inspection.site, reach_m=2.0 * standoff_m + corner_radius_m)
    (part,) = parts_of(solid, standoff_m=standoff_m, worth=lambda base_m, top_m: False)
    for number, height_m in enumerate(heights_m(inspection)):
        ring = plan_spiral(
            solid,
            part,
            standoff_m=standoff_m,
            rise_m=1.0,
            bottom_m=height_m,
            top_m=height_m,
            clearance_m=mission.limits.clearance_m,
            corner_radius_m=corner_radius_m,
            start_enu_m=inspection.home_enu_m[:2],
        ).path
        gaze = inward_gaze(ring, smoothing_m=pace.speed_mps)
        leg = Leg(f"inspection-{number}", ring, gaze, fastest_law(ring, gaze, pace))
        if legs:
            before = legs[-1]
            yaws = float(before.gaze(before.path.u_end_rad)), float(gaze(0.0))
            legs.append(
                straight(
                    f"join-{number}", before.path(before.path.u_end_rad), ring(0.0), yaws, limits_of(mission)
                )
            )
        legs.append(leg)
    return Trajectory(tuple(legs))


def mitred(site: Site, standoff_m: float) -> np.ndarray:
    """The footprint's polygon, counter-clockwise, each side moved out by the stand-off, cut at the sharp corners."""
    contours, _ = cv2.findContours(site.building.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    largest = max(contours, key=cv2.contourArea)
    cell_m = site.heights.cell_m
    corners = cv2.approxPolyDP(largest, STRAIGHT_M / cell_m, closed=True)[:, 0, :].astype(float)
    if cv2.contourArea(corners.astype(np.float32), oriented=True) < 0.0:
        corners = corners[::-1]
    corners = site.heights.origin_enu_m + (corners + 0.5) * cell_m
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.hypot(*along.T)[:, None]
    out = np.column_stack([along[:, 1], -along[:, 0]])
    moved = corners + (standoff_m + 0.5 * cell_m) * out
    vertices = []
    for k in range(len(corners)):
        step = moved[k] - moved[k - 1]
        share = np.linalg.solve(np.column_stack([along[k - 1], -along[k]]), step)[0]
        vertices.append(moved[k - 1] + share * along[k - 1])
    return np.array(vertices)


def scan(inspection: Inspection, pace: Limits, spacing_m: float) -> Trajectory:
    """The structure scan; with a finite spacing it stops at each shot too."""
    mission, legs, number = inspection.mission, [], 0
    limits = limits_of(mission)
    plan_m = mitred(inspection.site, mission.inspection.standoff_m)
    sides = np.roll(plan_m, -1, axis=0) - plan_m
    yaws = np.arctan2(sides[:, 1], sides[:, 0]) + 0.5 * np.pi
    heights = heights_m(inspection)
    for height_m in heights:
        for k, side in enumerate(sides):
            start, end = np.append(plan_m[k], height_m), np.append(plan_m[k] + side, height_m)
            if legs:
                # On the spot, or up to the next layer: at the first vertex of each.
                before = legs[-1]
                turning = start + TURNING_M * np.append(side, 0.0) / np.hypot(*side)
                here = before.path(before.path.u_end_rad)
                if k == 0:
                    yaw = float(before.gaze(1.0))
                    legs.append(straight(f"join-{number}-up", here, start, (yaw, yaw), limits))
                turn = straight(f"join-{number}", start, turning, (yaws[k - 1], yaws[k]), limits)
                legs.append(turn)
                start = turning
            stops = int(np.ceil(np.linalg.norm(end - start) / spacing_m)) if np.isfinite(spacing_m) else 1
            places = start + np.linspace(0.0, 1.0, stops + 1)[:, None] * (end - start)
            for a, b in itertools.pairwise(places):
                number += 1
                legs.append(straight(f"inspection-{number}", a, b, (yaws[k], yaws[k]), pace))
    return Trajectory(tuple(legs))


def at_stops(trajectory: Trajectory) -> Shots:
    """A shot at each end of each leg of the inspection."""
    t_s = np.unique(np.round(np.array(trajectory.spans_s("inspection")).ravel(), 6))
    states = trajectory(t_s)
    return Shots(t_s, states.position_enu_m, states.yaw_enu_rad, states.gimbal_pitch_rad)


def blur_px(trajectory: Trajectory, shots: Shots, inspection: Inspection) -> np.ndarray:
    """How far the place that the camera looks at, the stand-off ahead, moves on across its axis, in pixels."""
    camera, standoff_m = camera_of(inspection.mission), inspection.mission.inspection.standoff_m
    states = trajectory(shots.t_s)
    left = np.column_stack([-np.sin(states.yaw_enu_rad), np.cos(states.yaw_enu_rad)])
    across = (states.velocity_enu_mps[:, :2] * left).sum(axis=1) + standoff_m * states.yaw_rate_enu_radps
    pixels = [m / px for m, px in zip(camera.footprint_m(standoff_m), camera.image_px, strict=True)]
    return camera.exposure_s * np.hypot(across / pixels[0], states.velocity_enu_mps[:, 2] / pixels[1])


def row(name: str, trajectory: Trajectory, shots: Shots, inspection: Inspection) -> str:
    states = trajectory.sampled(0.01)
    jerk = np.linalg.norm(states.jerk_enu_mps3, axis=1)
    way_m = np.linalg.norm(np.diff(states.position_enu_m, axis=0), axis=1).sum()
    walls = inspection.coverage_from(shots).walls
    blur = blur_px(trajectory, shots, inspection)
    near_m = Solids.of_map(inspection.site.heights).distance_m(trajectory.sampled(0.1).position_enu_m).min()
    return (
        f"{name:10}{walls:9.1%}{len(shots):8}{way_m:9.0f} m{trajectory.duration_s:9.0f} s{jerk.max():11.2f}"
        f"{np.sqrt((jerk**2).mean()):9.2f}{np.quantile(blur, 0.95):11.2f}{blur.max():7.2f}{near_m:10.1f} m"
    )


def main() -> None:
    for name in sys.argv[1:] or MISSIONS:
        mission = load_mission(ROOT / "missions" / f"{name}.toml")
        inspection = plan(mission)
        camera, asked = camera_of(mission), mission.inspection
        pace = pace_of(mission, camera, limits_of(mission))
        spacing_m = camera.shot_spacing_m(asked.standoff_m, asked.side_overlap)

        def shots(trajectory: Trajectory, camera=camera, asked=asked) -> Shots:
            return shots_of(
                trajectory,
                camera,
                standoffs_m=[asked.standoff_m] * len(trajectory.spans_s("inspection")),
                side_overlap=asked.side_overlap,
            )

        spiral = Trajectory(tuple(part.leg for part in inspection.passes))
        stopping = scan(inspection, pace, spacing_m)
        flights = {"spiral": spiral, "circles": circles(inspection, pace)}
        flights["scan"] = scan(inspection, pace, np.inf)
        print(
            f"\n{name:10}{'walls':>9}{'shots':>8}{'way':>11}{'time':>11}{'peak jerk':>11}{'RMS':>9}{'blur 95 %':>11}"
            f"{'max':>7}{'clearance':>12}"
        )
        for kind, trajectory in flights.items():
            print(row(kind, trajectory, shots(trajectory), inspection))
        print(row("scan/shot", stopping, at_stops(stopping), inspection))


if __name__ == "__main__":
    main()
