"""The building as the survey saw it: a picture of its skin, coloured by the finest pixel on every patch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.shape.heightmap import Site
from mavspiral.show.scene import AZIMUTH_DEG, BUILDING_RGB, OBSTACLE_RGB, Scene, shaded
from mavspiral.survey.coverage import Coverage
from mavspiral.survey.patches import SIDES_ENU, Patches

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["UNSEEN_RGB", "Skin", "gsd_rgb"]

UNSEEN_RGB = np.array([0.80, 0.16, 0.22])
GSD_RGB = np.array(
    [[0.05, 0.36, 0.42], [0.16, 0.53, 0.54], [0.49, 0.70, 0.62], [0.80, 0.83, 0.68], [0.95, 0.92, 0.74]]
)
"""From the finest pixel to the coarsest that is allowed."""

SIZE_PX = 1400, 1600
"""Drawn at most so large: twice as fine as the figure shows it, and averaged: smooth edges."""

VIEWS, BETTER, ASKED = 12, 1.25, 500


def gsd_rgb(share: FloatArray) -> FloatArray:
    """Colours `(…, 3)` of pixels of a size between 0 and 1, the greatest allowed."""
    stops = np.linspace(0.0, 1.0, len(GSD_RGB))
    return np.stack([np.interp(share, stops, GSD_RGB[:, c]) for c in range(3)], axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """What a survey showed of a site: its patches' colours. Roofs are coloured only if they were to be seen."""

    site: Site
    coverage: Coverage
    roofs: bool

    def azimuth_deg(self) -> float:
        """From where most of the building's walls is in sight; the usual side, unless it shows much less than the best."""
        patches = self.coverage.patches
        some = np.flatnonzero(patches.is_wall)[:: 1 + len(patches) // ASKED]
        azimuths_deg = [(AZIMUTH_DEG + k * 360.0 / VIEWS) % 360.0 for k in range(VIEWS)]
        shown_m2 = []
        for azimuth_deg in azimuths_deg:
            shares = Scene(self.site, azimuth_deg=azimuth_deg).shows(
                patches.before_enu_m[some], patches.normal_enu[some]
            )
            shown_m2.append(float(shares @ patches.area_m2[some]))
        best = int(np.argmax(shown_m2))
        return azimuths_deg[best] if shown_m2[best] > BETTER * shown_m2[0] else AZIMUTH_DEG

    def draw(self, axes: Axes, scene: Scene) -> None:
        """The site onto the axes, each pixel by what a ray of sight meets there."""
        extent = scene.extent_m()
        west, east, low, high = extent
        px_m = min(SIZE_PX[0] / (east - west), SIZE_PX[1] / (high - low))
        width, height = (2 * max(1, round(0.5 * px_m * size)) for size in (east - west, high - low))
        x = west + (np.arange(width) + 0.5) / width * (east - west)
        y = high - (np.arange(height) + 0.5) / height * (high - low)
        place = scene.first_met(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
        rgba = np.zeros((len(place), 4), dtype=np.float32)
        met = np.isfinite(place[:, 0])
        rgba[met, :3], rgba[met, 3] = self._colours(place[met], scene), 1.0
        image = rgba.reshape(height, width, 4)
        image[..., :3] *= image[..., 3:]
        image = cv2.resize(image, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
        image[..., :3] /= np.maximum(image[..., 3:], 1e-6)
        axes.imshow(np.clip(image, 0.0, 1.0), extent=extent, interpolation="antialiased")

    def _colours(self, place_enu_m: FloatArray, scene: Scene) -> FloatArray:
        """Colours `(n, 3)` of places on the surface of the site's boxes."""
        patches = self.coverage.patches
        cell, side = scene.faces_at(place_enu_m)
        own = self.site.building[cell[:, 0], cell[:, 1]]
        rgb = np.where(own[:, None], BUILDING_RGB, OBSTACLE_RGB)
        normal = SIDES_ENU[side].copy()
        index = _patch_at(patches, self.site, cell, side, place_enu_m[:, 2])
        # A step too low for a wall, such as those of a gable's cells, is a piece of its roof.
        low = np.flatnonzero(own & (index < 0) & (side < 4))
        side[low] = 4
        roof_m = self.site.heights.height_agl_m[cell[low, 0], cell[low, 1]]
        index[low] = _patch_at(patches, self.site, cell[low], side[low], roof_m)
        known = index >= 0
        normal[known] = patches.normal_enu[index[known]]
        if not self.roofs:
            known &= side < 4
        gsd_share = self.coverage.best_gsd_m[index[known]] / self.coverage.demand.gsd_max_m
        seen = self.coverage.seen[index[known], None]
        rgb[known] = np.where(seen, gsd_rgb(np.minimum(gsd_share, 1.0)), UNSEEN_RGB)
        return shaded(rgb, normal)


def _patch_at(
    patches: Patches, site: Site, cell: NDArray[np.int64], side: NDArray[np.int64], height_m: FloatArray
) -> NDArray[np.int64]:
    """The patch on that side of each cell `(n, 2)` at that height, -1 where there is none."""
    _, cols = site.heights.shape
    inward = (
        patches.centre_enu_m - 0.25 * patches.cell_m * SIDES_ENU[patches.side] * (patches.side < 4)[:, None]
    )
    own = site.heights.index(inward)
    step_m = site.heights.top_m + 1.0
    face = (own[:, 0] * cols + own[:, 1]) * 5 + patches.side
    low_m = patches.centre_enu_m[:, 2] - 0.5 * patches.height_m
    key = face * step_m + low_m
    order = np.argsort(key)
    wanted_face = (cell[:, 0] * cols + cell[:, 1]) * 5 + side
    at = np.searchsorted(key[order], wanted_face * step_m + height_m + 1e-6, side="right") - 1
    found = order[np.maximum(at, 0)]
    return np.where((at >= 0) & (face[found] == wanted_face), found, -1)
