"""A mission in the planner's own values: SI, ENU, and what follows from them on this site."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import InputError, LimitError
from mavspiral.frames import LocalFrame
from mavspiral.mission import Keepout, Mission
from mavspiral.motion.limits import Limits
from mavspiral.shape.heightmap import Site
from mavspiral.shape.keepout import circle_ring_m, with_obstacle
from mavspiral.shape.readers import MapRequest
from mavspiral.survey.camera import Camera
from mavspiral.survey.clearance import ClearanceBudget
from mavspiral.survey.coverage import Demand
from mavspiral.survey.seeable import Room
from mavspiral.survey.solids import Solids

__all__ = [
    "band_m",
    "budget_of",
    "camera_of",
    "demand_of",
    "home_enu_m",
    "keepout_ring_m",
    "limits_of",
    "map_request",
    "pace_of",
    "room_of",
    "sharpness_of",
    "smaller_clearance",
    "with_keepouts",
]

HOME_AWAY_M, HOME_SEARCHED_M = 35.0, 500.0
HOME_SPARE_M = 5.0
"""A home that nobody named is so far from the building or, on a way of so much, the first place that has so much to spare."""
REACH_M = 2000.0
"""Homes and keep-outs farther from the building than this are taken for slips."""

TURNS_MAX = 120
HOME_LOWER_M = 3.0
SLOWEST_MPS = 0.05
NAVIGATION_SIGMA_M = {"rtk": 0.05, "standard": 1.0}
TRACKING_SIGMA_M = 0.15


def map_request(mission: Mission) -> MapRequest:
    """Which building of which map."""
    b = mission.building
    return MapRequest(
        path=mission.map_path,
        cell_m=b.cell_m,
        ground_amsl_m=b.ground_amsl_m,
        at=b.at,
        id=b.id,
        dtm=mission.dtm_path,
        units=b.units,
        up=b.up,
        heading_deg=b.heading_deg,
        crs=b.crs,
    )


def with_keepouts(mission: Mission, site: Site) -> Site:
    """The site with the mission's keep-out volumes standing in it."""
    for keepout in mission.keepout:
        ring = keepout_ring_m(keepout, site.heights.frame)
        away_m = float(np.sqrt((ring**2).sum(axis=1)).max())
        if away_m > REACH_M:
            raise InputError(
                f"[keepout] {keepout.circle or keepout.polygon}: reaches {away_m / 1000:.1f} km from the building. "
                "Fix: places are [latitude, longitude], a radius is in metres"
            )
        site = with_obstacle(site, ring, keepout.height_m[1])
    if mission.keepout and not site.building.any():
        raise InputError("[keepout] the keep-outs cover the whole building. Fix: make them smaller or lower")
    return site


def keepout_ring_m(keepout: Keepout, frame: LocalFrame) -> FloatArray:
    """The outline of a keep-out in plan, `(n, 2)`."""
    alt_amsl_m = frame.origin.alt_amsl_m
    if keepout.circle is not None:
        lat, lon, radius_m = keepout.circle
        x, y, _ = frame.to_enu(lat, lon, alt_amsl_m)
        return circle_ring_m(float(x), float(y), radius_m)
    corners = np.array(keepout.polygon)
    return np.asarray(frame.to_enu(corners[:, 0], corners[:, 1], alt_amsl_m)[:, :2])


def camera_of(mission: Mission) -> Camera:
    """The mission's camera in metres."""
    c = mission.camera
    return Camera(
        focal_length_m=c.focal_length_mm / 1e3,
        sensor_m=(c.sensor_mm[0] / 1e3, c.sensor_mm[1] / 1e3),
        image_px=c.image_px,
        exposure_s=c.exposure_s,
        min_interval_s=c.min_interval_s,
        gimbal=c.gimbal,
    )


def demand_of(mission: Mission) -> Demand:
    """When a piece of wall counts as seen."""
    q = mission.quality
    return Demand(q.gsd_max_mm / 1e3, math.radians(q.incidence_max_deg), q.views_min)


def limits_of(mission: Mission) -> Limits:
    """The mission's limits; the yaw rate may change by itself within a second."""
    m = mission.limits
    yaw_rate_radps = math.radians(m.yaw_rate_dps)
    return Limits(
        speed_mps=m.speed_mps,
        climb_mps=m.climb_mps,
        descent_mps=m.descent_mps,
        acceleration_mps2=m.acceleration_mps2,
        jerk_mps3=m.jerk_mps3,
        yaw_rate_radps=yaw_rate_radps,
        yaw_acceleration_radps2=yaw_rate_radps / 1.0,
    )


def sharpness_of(mission: Mission, camera: Camera) -> Callable[[float], float]:
    """How fast a wall may pass through the picture, by its distance: for sharp pictures and for the shutter."""

    def sharp_mps(standoff_m: float) -> float:
        return camera.speed_limit_mps(
            standoff_m, mission.inspection.side_overlap, mission.quality.blur_max_px
        )

    return sharp_mps


def pace_of(mission: Mission, camera: Camera, limits: Limits) -> Limits:
    """The limits on the spiral: no faster than sharp pictures and the shutter allow.

    Raises:
        InputError: that is too slow to be meant, or pictures from the stand-off are too coarse at any pace.
    """
    standoff_m, gsd_max_m = mission.inspection.standoff_m, mission.quality.gsd_max_mm / 1e3
    if (gsd_m := camera.gsd_m(standoff_m)) > gsd_max_m:
        fits_m = _tenths_m(standoff_m * gsd_max_m / gsd_m)
        raise InputError(
            f"[inspection] standoff_m = {standoff_m:g}: a pixel on the wall is {1e3 * gsd_m:.1f} mm from there, [quality] "
            f"gsd_max_mm = {mission.quality.gsd_max_mm:g}. Fix: standoff_m ≤ {fits_m:g}, a longer focal_length_mm, or a larger gsd_max_mm"
        )
    sharp_mps = sharpness_of(mission, camera)(mission.inspection.standoff_m)
    if sharp_mps < SLOWEST_MPS:
        raise InputError(
            f"[camera] exposure_s = {camera.exposure_s:g} and min_interval_s = {camera.min_interval_s:g} allow "
            f"{sharp_mps:.3f} m/s at standoff_m = {mission.inspection.standoff_m:g} for [quality] blur_max_px = "
            f"{mission.quality.blur_max_px:g}, slower than {SLOWEST_MPS:g} m/s. Fix: a shorter exposure_s, or a larger blur_max_px"
        )
    return limits if sharp_mps >= limits.speed_mps else replace(limits, speed_mps=sharp_mps)


def _tenths_m(length_m: float) -> float:
    """Rounded down, as a pilot is told what fits."""
    return math.floor(10.0 * length_m + 1e-9) / 10.0


def band_m(mission: Mission, site: Site, camera: Camera) -> tuple[float, float]:
    """The heights of the lowest and the highest turn.

    By default the lowest shot shows the foot of the wall and the highest its top, but for what the
    clearance above ground and the building's own height forbid.
    """
    half_m = camera.footprint_m(mission.inspection.standoff_m)[1] / 2
    asked = mission.inspection
    top_of_building_m = site.building_top_m
    bottom_m = asked.bottom_m if asked.bottom_m is not None else max(mission.limits.clearance_m, half_m)
    top_m = asked.top_m if asked.top_m is not None else max(bottom_m, top_of_building_m - half_m)
    if bottom_m < mission.limits.clearance_m:
        raise InputError(
            f"[inspection] bottom_m = {bottom_m:g} is nearer to the ground than [limits] clearance_m = "
            f"{mission.limits.clearance_m:g}. Fix: bottom_m ≥ {mission.limits.clearance_m:g}"
        )
    if bottom_m > top_m:
        raise InputError(
            f"[inspection] the lowest turn at {bottom_m:g} m (bottom_m) is above the highest at {top_m:g} m (top_m). "
            f"Fix: top_m ≥ {bottom_m:g}, or a lower bottom_m"
        )
    if bottom_m >= top_of_building_m + mission.inspection.standoff_m:
        if asked.bottom_m is None and half_m > mission.limits.clearance_m:
            raise InputError(
                f"[camera] shows {2 * half_m:.3g} m of the wall at {asked.standoff_m:g} m, and the whole building ends at "
                f"{top_of_building_m:g} m. Fix: a longer focal_length_mm, a smaller standoff_m, or a bottom_m"
            )
        raise InputError(
            f"[inspection] bottom_m = {bottom_m:g} is above the whole building, which ends at {top_of_building_m:g} m. "
            f"Fix: bottom_m ≤ {top_of_building_m:g}"
        )
    ceiling_m = mission.limits.ceiling_m
    if bottom_m > ceiling_m:
        raise InputError(_above_the_ceiling(mission, bottom_m, half_m))
    turns = (top_m - bottom_m) / camera.rise_m(asked.standoff_m, asked.overlap)
    if turns > TURNS_MAX:
        raise InputError(
            f"[camera] shows {2 * half_m:.3g} m of the wall at {asked.standoff_m:g} m, so the spiral would take "
            f"{turns:.0f} turns, at most {TURNS_MAX} are flown. Fix: a shorter focal_length_mm or a larger standoff_m"
        )
    if top_m > ceiling_m:
        raise LimitError(
            f"the highest turn is {top_m:.1f} m above ground, [limits] ceiling_m = {ceiling_m:g}. "
            f"Fix: ceiling_m ≥ {math.ceil(top_m)}, or [inspection] top_m = {ceiling_m:g}"
        )
    return bottom_m, top_m


def _above_the_ceiling(mission: Mission, bottom_m: float, half_m: float) -> str:
    """In words: why the lowest turn at `bottom_m` is above the ceiling, and what would do."""
    asked, clearance_m, ceiling_m = mission.inspection, mission.limits.clearance_m, mission.limits.ceiling_m
    if asked.bottom_m is not None:
        return f"[inspection] bottom_m = {bottom_m:g} is above [limits] ceiling_m = {ceiling_m:g}. Fix: bottom_m ≤ {ceiling_m:g}"
    if clearance_m > ceiling_m:
        return (
            f"[limits] clearance_m = {clearance_m:g}, which is kept from the ground too, is above ceiling_m = {ceiling_m:g}. "
            f"Fix: clearance_m ≤ {ceiling_m:g}, or a higher ceiling_m"
        )
    fits_m = _tenths_m(asked.standoff_m * ceiling_m / half_m)
    return (
        f"[inspection] standoff_m = {asked.standoff_m:g}: a picture shows {2 * half_m:.3g} m of the wall from there, so the lowest "
        f"turn, which shows its foot, is {bottom_m:.1f} m up, above [limits] ceiling_m = {ceiling_m:g}. "
        f"Fix: standoff_m ≤ {fits_m:g}, a longer focal_length_mm, or bottom_m ≤ {ceiling_m:g}"
    )


def room_of(mission: Mission, required_m: float) -> Room:
    """Where a pose is safe: no lower than the clearance above ground, no higher than the ceiling."""
    return Room(required_m, mission.limits.clearance_m, mission.limits.ceiling_m)


def budget_of(mission: Mission) -> ClearanceBudget:
    """What may go wrong between the curve and a wall, from the mission's own figures."""
    return ClearanceBudget(
        vehicle_radius_m=mission.vehicle.radius_m,
        map_sigma_m=mission.building.map_error_m,
        navigation_sigma_m=NAVIGATION_SIGMA_M[mission.vehicle.gps],
        tracking_sigma_m=TRACKING_SIGMA_M,
    )


def smaller_clearance(mission: Mission, wanted_m: float) -> str:
    """In words: what to set for a required clearance of `wanted_m`, rounded down; nothing where the vehicle takes more by itself.

    `clearance_m` alone does not lower it where the errors govern.
    """
    fits_m, budget = _tenths_m(wanted_m), budget_of(mission)
    sets = [f"[limits] clearance_m = {fits_m:g}"] if mission.limits.clearance_m > fits_m > 0.0 else []
    if budget.total_m > fits_m:
        for gps in dict.fromkeys((mission.vehicle.gps, "rtk")):
            others_m = math.hypot(NAVIGATION_SIGMA_M[gps], budget.tracking_sigma_m)
            spare2_m2 = max(0.0, (fits_m - budget.vehicle_radius_m) / 3.0) ** 2 - others_m**2
            if spare2_m2 >= 0.0:
                break
        else:
            return ""
        if gps != mission.vehicle.gps:
            sets.append('[vehicle] gps = "rtk", if it has that')
        if (map_m := math.floor(100.0 * math.sqrt(spare2_m2)) / 100.0) < budget.map_sigma_m:
            sets.append(f"[building] map_error_m = {map_m:g}, if the map is so good")
    now_m = budget.required_m(mission.limits.clearance_m)
    return f"a required clearance of {fits_m:.1f} m (now {now_m:.2f} m): {' and '.join(sets)}" if sets else ""


def home_enu_m(mission: Mission, site: Site, solids: Solids, required_m: float) -> FloatArray:
    """The mission's home, else the first free place south-west of the building, 35 m away or more, and 3 m lower."""
    frame = site.heights.frame
    if mission.vehicle.home is not None:
        alt_amsl_m = frame.origin.alt_amsl_m + mission.vehicle.home_height_m
        home = frame.to_enu(*mission.vehicle.home, alt_amsl_m)
        if (distance_m := float(np.hypot(home[0], home[1]))) > REACH_M:
            raise InputError(
                f"[vehicle] home = {list(mission.vehicle.home)} is {distance_m / 1000:.1f} km from the building, at most "
                f"{REACH_M / 1000:g} km are flown. Fix: home is [latitude, longitude]"
            )
        return home
    away_m = np.arange(HOME_AWAY_M, HOME_AWAY_M + HOME_SEARCHED_M, 1.0)
    places = np.column_stack(
        [-away_m / math.sqrt(2), -away_m / math.sqrt(2), np.full(len(away_m), -HOME_LOWER_M)]
    )
    free = np.flatnonzero(solids.distance_m(places) >= required_m + HOME_SPARE_M)
    if not len(free):
        raise InputError("no free place for a home was found. Fix: set [vehicle] home = [lat, lon]")
    return np.asarray(places[free[0]])
