"""A building and flight paths as a parallel projection.

Matplotlib's own 3-D axes sort whole collections, so paths shine through walls. Here every point of the picture knows
which wall or roof it meets, and a piece of path is drawn only where nothing stands between it and the eye.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.heightmap import Site
from mavspiral.survey.sight import gap_m

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["AZIMUTH_DEG", "Scene", "shaded"]

LIGHT_ENU = np.array([-0.44, -0.73, 0.52])
UP_ENU = np.array([0.0, 0.0, 1.0])
BUILDING_RGB = np.array([0.84, 0.82, 0.78])
OBSTACLE_RGB = np.array([0.72, 0.77, 0.82])
HIDDEN_SHARE = 0.16
AZIMUTH_DEG = 240.0


class Scene:
    """A site seen from `azimuth_deg` (clockwise from north, where the eye is) and `elevation_deg`."""

    def __init__(self, site: Site, *, azimuth_deg: float = AZIMUTH_DEG, elevation_deg: float = 24.0) -> None:
        azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
        toward = np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
        self._right_enu = np.array([-toward[1], toward[0], 0.0])
        self._eye_enu = toward * np.cos(elevation) + UP_ENU * np.sin(elevation)
        self._up_enu = UP_ENU * np.cos(elevation) - toward * np.sin(elevation)
        self._site = site

    def draw_path(self, axes: Axes, position_enu_m: FloatArray, rgba: FloatArray, width: float) -> None:
        """A polyline `(n, 3)` with a colour `(n, 4)` for each piece; what is behind something is faint."""
        from matplotlib.collections import LineCollection

        picture = self._picture(position_enu_m)
        pieces = np.stack([picture[:-1], picture[1:]], axis=1)
        colours = rgba[:-1].copy()
        colours[~self._visible(0.5 * (position_enu_m[:-1] + position_enu_m[1:])), 3] *= HIDDEN_SHARE
        axes.add_collection(LineCollection(list(pieces), colors=colours, linewidths=width, capstyle="butt"))

    def extent_m(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the picture of everything that stands there, and half a metre more."""
        heights = self._site.heights
        row, col = np.nonzero(heights.height_agl_m > 0.0)
        corners = np.array([[c, r] for c in (col.min(), col.max() + 1) for r in (row.min(), row.max() + 1)])
        plan = heights.origin_enu_m + corners * heights.cell_m
        box = np.vstack([np.column_stack([plan, np.full(4, z)]) for z in (0.0, heights.top_m)])
        low, high = self._picture(box).min(axis=0) - 0.5, self._picture(box).max(axis=0) + 0.5
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])

    def first_met(self, picture_m: FloatArray) -> FloatArray:
        """The place `(n, 3)` on a wall or a roof at each point `(n, 2)` of the picture; NaN where only ground is."""
        heights, slope = self._site.heights, self._eye_enu[2]
        top_m = heights.top_m + 1.0
        flat = picture_m[:, :1] * self._right_enu + picture_m[:, 1:] * self._up_enu
        start = flat + ((top_m - flat[:, 2]) / slope)[:, None] * self._eye_enu
        reach_m = top_m / slope
        grid = np.array([*heights.origin_enu_m, heights.cell_m, heights.top_m])
        way_m = gap_m(start, np.tile(-self._eye_enu, (len(start), 1)), reach_m, heights.height_agl_m, grid)
        place: FloatArray = start - way_m[:, None] * self._eye_enu
        place[way_m >= reach_m] = np.nan
        # A ray enters the cell of a roof above it: on to the roof.
        cell, side = self.faces_at(place[way_m < reach_m])
        over_m = place[way_m < reach_m, 2] - heights.height_agl_m[cell[:, 0], cell[:, 1]]
        place[way_m < reach_m] -= (np.where(side == 4, over_m, 0.0) / slope)[:, None] * self._eye_enu
        return place

    def faces_at(self, place_enu_m: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Row and column `(n, 2)` of the cell that a ray meets at each place, and by which side: E, N, W, S or up."""
        heights = self._site.heights
        ahead = place_enu_m - 1e-6 * self._eye_enu
        cell = np.clip(heights.index(ahead), 0, np.array(heights.shape) - 1)
        inside = (ahead[:, :2] - heights.origin_enu_m) / heights.cell_m - cell[:, ::-1]
        from_east, from_north = self._eye_enu[0] > 0.0, self._eye_enu[1] > 0.0
        east = 1.0 - inside[:, 0] if from_east else inside[:, 0]
        north = 1.0 - inside[:, 1] if from_north else inside[:, 1]
        side = np.where(east < north, 0 if from_east else 2, 1 if from_north else 3)
        roof = place_enu_m[:, 2] >= heights.height_agl_m[cell[:, 0], cell[:, 1]] - 1e-9
        return cell, np.where(roof, 4, side)

    def shows(self, place_enu_m: FloatArray, normal_enu: FloatArray) -> FloatArray:
        """How large a piece of surface at each place `(n, 3)` is in the picture, of its area: 0 where it is hidden."""
        facing = np.maximum(0.0, normal_enu @ self._eye_enu)
        facing[facing > 0.0] *= self._visible(place_enu_m[facing > 0.0])
        return np.asarray(facing)

    def _picture(self, position_enu_m: FloatArray) -> FloatArray:
        return np.stack([position_enu_m @ self._right_enu, position_enu_m @ self._up_enu], axis=-1)

    def _visible(self, position_enu_m: FloatArray) -> NDArray[np.bool_]:
        """Whether nothing of the height map lies between each position and the eye, looked at every half cell."""
        heights = self._site.heights
        highest_m = float(position_enu_m[:, 2].min(initial=heights.top_m))
        reach_m = max(0.0, heights.top_m - highest_m) / self._eye_enu[2]
        visible = np.ones(len(position_enu_m), dtype=np.bool_)
        for along_m in np.arange(heights.cell_m, reach_m, max(0.5 * heights.cell_m, reach_m / 800)):
            place = position_enu_m[visible] + along_m * self._eye_enu
            visible[visible] = heights.sample(place) <= place[:, 2]
        return visible


def shaded(rgb: FloatArray, normal_enu: FloatArray) -> FloatArray:
    """Colours `(…, 3)` of faces with these normals `(…, 3)` in the light."""
    shade = 0.6 + 0.4 * np.maximum(0.0, normal_enu @ LIGHT_ENU)
    return np.asarray(np.clip(rgb * shade[..., None], 0.0, 1.0))
