"""Sight by another road, slowly: pixels as pairs of rays, boxes as slabs, every patch against every shot and box."""

from __future__ import annotations

import numpy as np


def looks(patches, shots, site, camera, demand):
    """Views, finest GSD and its incidence of each patch."""
    n = len(patches)
    views, best_gsd, incidence = np.zeros(n, dtype=int), np.full(n, np.inf), np.full(n, np.nan)
    boxes = _boxes(site)
    for s in range(len(shots)):
        eye = shots.position_enu_m[s]
        R_enu_camera = _rotation(shots.yaw_enu_rad[s], shots.pitch_rad[s])
        for k in range(n):
            place, normal = patches.centre_enu_m[k], patches.normal_enu[k]
            x, y, z = R_enu_camera.T @ (place - eye)
            if x <= 0 or normal @ (eye - place) <= 0:
                continue
            px = np.array([-y, z]) / x * camera.focal_length_m / camera.sensor_m * camera.image_px
            if (abs(px) > 0.5 * np.array(camera.image_px)).any():
                continue
            ray = eye - place
            angle = np.arccos(min(1.0, normal @ ray / np.linalg.norm(ray)))
            gsd = max(
                np.linalg.norm(
                    _on_plane(camera, R_enu_camera, eye, px + 0.5 * step, place, normal)
                    - _on_plane(camera, R_enu_camera, eye, px - 0.5 * step, place, normal)
                )
                for step in 1e-3 * np.eye(2)
            )
            gsd *= 1e3
            if angle > demand.incidence_max_rad or gsd > demand.gsd_max_m:
                continue
            if _hits(boxes, patches.before_enu_m[k], eye):
                continue
            views[k] += 1
            if gsd < best_gsd[k]:
                best_gsd[k], incidence[k] = gsd, angle
    return views, best_gsd, incidence


def _rotation(yaw_rad, pitch_rad):
    """Columns ahead, left, up: a turn about up, then the nose raised."""
    cy, sy, cp, sp = np.cos(yaw_rad), np.sin(yaw_rad), np.cos(pitch_rad), np.sin(pitch_rad)
    return np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]])


def _on_plane(camera, R_enu_camera, eye, px, place, normal):
    """Where the ray through the picture's point `px`, right and up of its middle, meets the plane."""
    right, up = px * camera.sensor_m / camera.image_px / camera.focal_length_m
    ray = R_enu_camera @ np.array([1.0, -right, up])
    return eye + ray * (normal @ (place - eye)) / (normal @ ray)


def _boxes(site):
    grid = site.heights
    boxes = []
    for row, col in np.argwhere(grid.height_agl_m > 0):
        low = np.array([*(grid.origin_enu_m + np.array([col, row]) * grid.cell_m), 0.0])
        high = low + np.array([grid.cell_m, grid.cell_m, grid.height_agl_m[row, col]])
        boxes.append((low, high))
    low, high = zip(*boxes, strict=True)
    return np.array(low), np.array(high)


def _hits(boxes, start, end):
    """Whether the way passes through the inside of a box."""
    low, high = boxes
    way = np.where(end == start, 1e-15, end - start)
    t = np.stack([(low - start) / way, (high - start) / way])
    enter, leave = t.min(axis=0).max(axis=1), t.max(axis=0).min(axis=1)
    return bool((np.minimum(leave, 1.0) - np.maximum(enter, 0.0) > 1e-9).any())
