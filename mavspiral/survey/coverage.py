"""Is it seen: every piece of wall and roof, ray-cast from every shot.

A shot sees a patch when the patch is in its picture and faces it, at no more than the greatest incidence, when a
pixel there is no larger than the greatest GSD (`sight` has the formula), and when nothing of the height map stands
in between. A patch is seen when at least `views_min` shots see it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.headway import Headway, to_nobody
from mavspiral.shape.heightmap import Site
from mavspiral.survey import sight
from mavspiral.survey.camera import Camera
from mavspiral.survey.patches import Patches
from mavspiral.survey.shots import Shots

__all__ = [
    "NO_ROOM",
    "OUT_OF_BAND",
    "SEEABLE",
    "TOO_FAR",
    "UNKNOWN",
    "Coverage",
    "Demand",
    "measure_coverage",
    "unseen_because",
]

UNKNOWN, OUT_OF_BAND, NO_ROOM, TOO_FAR, SEEABLE = range(-1, 4)
"""How near any safe pose comes to seeing a patch: not looked for; no pose's height is allowed; no place that it looks at
is safe; some are, but none sees it well; it is seen from one."""

AT_ONCE = 64
"""So many shots are looked through before their headway is told."""


@dataclass(frozen=True, slots=True)
class Demand:
    """When a patch counts as seen."""

    gsd_max_m: float
    incidence_max_rad: float
    views_min: int


@dataclass(frozen=True, slots=True, eq=False)
class Coverage:
    """What the shots show of the patches.

    For each patch: how many shots see it, the finest GSD of these, and the incidence of that shot; infinity and
    NaN where there is none. `best_pose` is how near any safe pose comes to seeing it, from `UNKNOWN` to `SEEABLE`.
    """

    patches: Patches
    demand: Demand
    views: NDArray[np.int64]
    best_gsd_m: FloatArray
    incidence_rad: FloatArray
    best_pose: NDArray[np.int64]

    def __post_init__(self) -> None:
        """Locks the fields; what is seen can be seen."""
        object.__setattr__(self, "best_pose", np.where(self.seen, SEEABLE, self.best_pose))
        for column in (self.views, self.best_gsd_m, self.incidence_rad, self.best_pose):
            column.setflags(write=False)

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which patches enough shots see."""
        return np.asarray(self.views >= self.demand.views_min)

    @property
    def walls(self) -> float:
        """The share of the walls' area that is seen; NaN without walls."""
        return self._share(self.patches.is_wall, self.seen)

    @property
    def roof(self) -> float:
        """The share of the roofs' area that is seen; NaN without roofs."""
        return self._share(~self.patches.is_wall, self.seen)

    @property
    def walls_seeable(self) -> float:
        """The share of the walls' area that some safe pose could see; NaN without walls, or where that is not known."""
        return self._seeable(self.patches.is_wall)

    @property
    def roof_seeable(self) -> float:
        """The share of the roofs' area that some safe pose could see; NaN without roofs, or where that is not known."""
        return self._seeable(~self.patches.is_wall)

    @property
    def gsd_p95_m(self) -> float:
        """95 % of the seen wall shows pixels no larger than this; NaN where no wall is seen."""
        return self._quantile(self.best_gsd_m, 0.95)

    @property
    def incidence_p95_rad(self) -> float:
        """95 % of the seen wall is seen no more obliquely than this; NaN where no wall is seen."""
        return self._quantile(self.incidence_rad, 0.95)

    def summary(self) -> dict[str, float | None]:
        """The figures as `--json` has them: shares, mm and degrees; None for what there is nothing of, or not known.

        `…_seeable` is what some safe pose could see, of all; `…_of_seeable` what is seen, of that.
        """
        figures = {
            "walls": (self.walls, 4),
            "walls_seeable": (self.walls_seeable, 4),
            "walls_of_seeable": (_ratio(self.walls, self.walls_seeable), 4),
            "roof": (self.roof, 4),
            "roof_seeable": (self.roof_seeable, 4),
            "roof_of_seeable": (_ratio(self.roof, self.roof_seeable), 4),
            "gsd_p95_mm": (1e3 * self.gsd_p95_m, 3),
            "incidence_p95_deg": (math.degrees(self.incidence_p95_rad), 2),
        }
        return {
            name: round(value, digits) if math.isfinite(value) else None
            for name, (value, digits) in figures.items()
        }

    def _share(self, of: NDArray[np.bool_], which: NDArray[np.bool_]) -> float:
        area_m2 = self.patches.area_m2[of]
        return float(area_m2[which[of]].sum() / area_m2.sum()) if len(area_m2) else math.nan

    def _seeable(self, of: NDArray[np.bool_]) -> float:
        if (self.best_pose[of] == UNKNOWN).any():
            return math.nan
        return self._share(of, self.best_pose == SEEABLE)

    def _quantile(self, values: FloatArray, share: float) -> float:
        """The quantile over the seen walls, by area."""
        here = self.seen & self.patches.is_wall
        if not here.any():
            return math.nan
        order = np.argsort(values[here])
        area_m2 = np.cumsum(self.patches.area_m2[here][order])
        return float(values[here][order][np.searchsorted(area_m2, share * area_m2[-1])])


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else math.nan


def measure_coverage(
    patches: Patches,
    shots: Shots,
    site: Site,
    camera: Camera,
    demand: Demand,
    best_pose: NDArray[np.int64] | None = None,
    headway: Headway = to_nobody,
) -> Coverage:
    """What `shots` show of `patches`, with everything on the site in the way; `best_pose` of each, where that is known.

    `headway` is told how many of the shots have been looked through.
    """
    axes, optics, scene = _axes(shots), _optics(camera, demand), _grid(site)
    views = np.zeros(len(patches), dtype=np.int64)
    best_gsd_m, cosine = np.full(len(patches), np.inf), np.zeros(len(patches))
    for first in range(0, len(shots), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        more, gsd_m, its_cosine = sight.look(
            patches.centre_enu_m,
            patches.before_enu_m,
            patches.normal_enu,
            shots.position_enu_m[some],
            axes[some],
            optics,
            *scene,
        )
        views += more
        finer = gsd_m < best_gsd_m
        best_gsd_m[finer], cosine[finer] = gsd_m[finer], its_cosine[finer]
        headway(min(first + AT_ONCE, len(shots)) / len(shots))
    incidence_rad = np.where(views > 0, np.arccos(np.clip(cosine, 0.0, 1.0)), np.nan)
    known = np.full(len(patches), UNKNOWN) if best_pose is None else best_pose
    return Coverage(patches, demand, views, best_gsd_m, incidence_rad, known)


def unseen_because(
    coverage: Coverage, shots: Shots, site: Site, camera: Camera, reach_m: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """The index of every unseen patch, what hinders its best shot, and how far it looks before something, to `reach_m`.

    The reasons are those of `sight`. A patch that some shots see, but too few, is told by what hinders the others.
    """
    index = np.flatnonzero(~coverage.seen)
    centre, normal = coverage.patches.centre_enu_m[index], coverage.patches.normal_enu[index]
    because = sight.reasons(
        centre, normal, shots.position_enu_m, _axes(shots), _optics(camera, coverage.demand)
    )
    gaps_m = sight.gap_m(coverage.patches.before_enu_m[index], normal, reach_m, *_grid(site))
    return index, because, gaps_m


def _grid(site: Site) -> tuple[FloatArray, FloatArray]:
    heights = site.heights
    return heights.height_agl_m, np.array([*heights.origin_enu_m, heights.cell_m, heights.top_m])


def _axes(shots: Shots) -> FloatArray:
    """Ahead, right and up of each picture, `(n, 3, 3)`."""
    sin_yaw, cos_yaw = np.sin(shots.yaw_enu_rad), np.cos(shots.yaw_enu_rad)
    sin_pitch, cos_pitch = np.sin(shots.pitch_rad), np.cos(shots.pitch_rad)
    level = np.zeros_like(sin_yaw)
    ahead = np.stack([cos_pitch * cos_yaw, cos_pitch * sin_yaw, sin_pitch], axis=1)
    right = np.stack([sin_yaw, -cos_yaw, level], axis=1)
    up = np.stack([-sin_pitch * cos_yaw, -sin_pitch * sin_yaw, cos_pitch], axis=1)
    return np.ascontiguousarray(np.stack([ahead, right, up], axis=1))


def _optics(camera: Camera, demand: Demand) -> FloatArray:
    """The camera and the demand as `sight.judge` wants them.

    The reach: a pixel on a surface square to its ray has the sides z·p·√(1+y²)/|d| and z·p·√(1+x²)/|d|, and no
    surface has smaller ones. So GSD ≤ g puts the range z·|d| within g·f/p·|d|²/√(1 + max(x, y)²).
    """
    f = camera.focal_length_m
    half = [side / (2 * f) for side in camera.sensor_m]
    pixel = [side / (f * px) for side, px in zip(camera.sensor_m, camera.image_px, strict=True)]
    stretch = math.sqrt(1 + max(half) ** 2) + min(half) ** 2
    reach_m = demand.gsd_max_m / min(pixel) * stretch
    return np.array([*half, *pixel, demand.gsd_max_m, math.cos(demand.incidence_max_rad), reach_m])
