"""A building and flight paths as a parallel projection, drawn from back to front.

Matplotlib's own 3-D axes sort whole collections and let paths shine through walls; here every wall, roof and
piece of path is one face that is sorted by its depth.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import cv2
import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.polygons import signed_area_m2

__all__ = ["Scene"]

LEVELS_MAX = 24
LIGHT_ENU = np.array([-0.45, -0.75, 0.5])
BUILDING_RGB = np.array([0.80, 0.79, 0.76])
UPWARD = np.array([0.0, 0.0, 1.0])
OBSTACLE_RGB = np.array([0.72, 0.77, 0.82])


@dataclass(frozen=True, slots=True, eq=False)
class _Face:
    depth: float
    outline: FloatArray
    colour: tuple[float, ...]


@dataclass(slots=True, eq=False)
class Scene:
    """Faces and lines seen from `azimuth_deg` (clockwise from north, where the eye is) and `elevation_deg`."""

    azimuth_deg: float = 215.0
    elevation_deg: float = 24.0
    faces: list[_Face] = field(default_factory=list)
    lines: list[tuple[float, FloatArray, tuple[float, ...], float]] = field(default_factory=list)

    def project(self, position_enu_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Picture coordinates `(…, 2)` in metres and depth `(…)`, larger is nearer."""
        azimuth, elevation = np.radians([self.azimuth_deg, self.elevation_deg])
        eye = np.array([np.sin(azimuth), np.cos(azimuth)])
        toward = position_enu_m[..., :2] @ eye
        right = position_enu_m[..., :2] @ np.array([-eye[1], eye[0]])
        up = position_enu_m[..., 2] * np.cos(elevation) - toward * np.sin(elevation)
        depth = toward * np.cos(elevation) + position_enu_m[..., 2] * np.sin(elevation)
        return np.stack([right, up], axis=-1), depth

    def add_site(self, site: Site) -> None:
        """The site's blocks: a wall face for each side of each outline, a roof for each level."""
        for heights_m, rgb in (
            (site.obstacle_height_m, OBSTACLE_RGB),
            (site.building_height_m, BUILDING_RGB),
        ):
            for outline, bottom_m, top_m, is_hole in _blocks(heights_m, site.heights):
                self._add_walls(outline, bottom_m, top_m, rgb)
                if not is_hole:
                    self._add_face(np.column_stack([outline, np.full(len(outline), top_m)]), UPWARD, rgb)

    def add_path(self, position_enu_m: FloatArray, colours: FloatArray, width: float) -> None:
        """A polyline `(n, 3)` whose pieces carry `colours` `(n, 3 or 4)`."""
        picture, depth = self.project(position_enu_m)
        for i, (a, b) in enumerate(pairwise(picture)):
            near = max(depth[i], depth[i + 1])
            self.lines.append((float(near), np.array([a, b]), tuple(colours[i]), width))

    def draw(self, axes: object) -> None:
        """Everything onto matplotlib `axes`, far things first."""
        from matplotlib.axes import Axes
        from matplotlib.collections import LineCollection, PolyCollection

        assert isinstance(axes, Axes)
        items = sorted(
            [(face.depth, face) for face in self.faces] + [(line[0], line) for line in self.lines],
            key=lambda i: i[0],
        )
        order = 1.0
        for is_face, run in _runs([item for _, item in items]):
            if is_face:
                axes.add_collection(
                    PolyCollection(
                        [f.outline for f in run],
                        facecolors=[f.colour for f in run],
                        edgecolors=[f.colour for f in run],
                        linewidths=0.4,
                        zorder=order,
                    )
                )
            else:
                axes.add_collection(
                    LineCollection(
                        [line[1] for line in run],
                        colors=[line[2] for line in run],
                        linewidths=[line[3] for line in run],
                        capstyle="round",
                        zorder=order,
                    )
                )
            order += 1e-3
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.set_axis_off()

    def _add_walls(self, outline_m: FloatArray, bottom_m: float, top_m: float, rgb: FloatArray) -> None:
        following = np.roll(outline_m, -1, axis=0)
        for (x0, y0), (x1, y1) in zip(outline_m, following, strict=True):
            wall = np.array([[x0, y0, bottom_m], [x1, y1, bottom_m], [x1, y1, top_m], [x0, y0, top_m]])
            normal = np.array([y1 - y0, x0 - x1, 0.0])
            length = float(np.hypot(normal[0], normal[1]))
            if length > 0:
                self._add_face(wall, normal / length, rgb)

    def _add_face(self, corners_m: FloatArray, normal: FloatArray, rgb: FloatArray) -> None:
        azimuth, elevation = np.radians([self.azimuth_deg, self.elevation_deg])
        eye = np.array(
            [np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)]
        )
        if normal @ eye <= 0:
            return
        picture, depth = self.project(corners_m)
        light = 0.62 + 0.38 * max(0.0, float(normal @ (LIGHT_ENU / np.linalg.norm(LIGHT_ENU))))
        self.faces.append(_Face(float(depth.mean()), picture, (*np.clip(rgb * light, 0, 1), 1.0)))


def _blocks(heights_m: FloatArray, grid: HeightMap) -> Iterator[tuple[FloatArray, float, float, bool]]:
    """Outlines of the superlevel sets (holes clockwise), the heights they reach between, whether it is a hole."""
    levels = np.unique(heights_m[heights_m > 0])
    if len(levels) > LEVELS_MAX:
        levels = np.unique(np.quantile(levels, np.linspace(0, 1, LEVELS_MAX)))
    below = 0.0
    for level in levels:
        mask = (heights_m >= level).astype(np.uint8)
        contours, hierarchy = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        for contour, (_, _, _, parent) in zip(contours, hierarchy[0], strict=True):
            simple = cv2.approxPolyDP(contour, 1.0, True)[:, 0, :].astype(np.float64)
            if len(simple) < 3:
                continue
            is_hole = parent >= 0
            if (signed_area_m2(simple) > 0) == is_hole:
                simple = simple[::-1]
            yield (simple + 0.5) * grid.cell_m + grid.origin_enu_m, below, float(level), is_hole
        below = float(level)


def _runs(items: list) -> Iterator[tuple[bool, list]]:
    """Neighbours of one kind together, so that each becomes one collection."""
    run: list = []
    for item in items:
        if run and isinstance(item, _Face) != isinstance(run[0], _Face):
            yield isinstance(run[0], _Face), run
            run = []
        run.append(item)
    if run:
        yield isinstance(run[0], _Face), run
