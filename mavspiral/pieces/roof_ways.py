"""The best way above a roof: a line, or a spiral at one of several insets, and what it sees.

A way is judged before it has a gaze: every cell is looked at from the place of the way that is nearest to it in plan.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.curve.aim import Belonging, roof_gaze
from mavspiral.curve.insets import STANDING_M, insets_of
from mavspiral.curve.line import LinePath
from mavspiral.curve.roof import RoofPath, Standoff, roof_spiral
from mavspiral.motion.limits import Limits
from mavspiral.shape.roofs import Roof, RoofGrid
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import Demand
from mavspiral.tour.passes import Piece

__all__ = ["RoofLook", "RoofWay", "best_way"]

HIGHEST = 1.6
"""Stand-offs above a roof: a path that something else beside it forces higher shows nothing."""
POOR_SHARE = 0.03
"""Of a roof: when a path sees no more of it too coarsely or too obliquely, no other is tried."""
POOR_LINE_SHARE = 0.15
"""The same for a line, which is so much shorter than a spiral."""
BETTER_SHARE = 0.02
"""So much more of it must a later try see than one before: lines are tried before spirals."""
PASSABLE_SHARE = 0.3
"""The same for going nearer to walls; what is left of a roof has a path of its own."""
RISE_MIN = 0.1
"""A roof that rises less to its middle is looked at from straight above."""
SLACK_M = 0.5
"""A ring beside a wall keeps this much more than must be: for the truncated series and for what flying leaves of it."""
THIN_M = 1.0
"""A ring no wider than this, both its sides taken together, is flown as the line that it nearly is."""
SAMPLE_M = 0.6
SHOWN = 0.52
"""Of a picture's height: what is no farther from the way in plan is shown by it."""
SHARP = 0.95
"""Of the largest pixel allowed, what is planned for."""


@dataclass(frozen=True, slots=True)
class RoofLook:
    """What a picture of a roof shows across the way, how far apart ways are, and what is kept from what."""

    picture_m: float
    spacing_m: float
    standoff_m: float
    beside_m: float
    nearest_m: float
    reach_m: float
    cosine_min: float

    @classmethod
    def of(
        cls,
        camera: Camera,
        demand: Demand,
        *,
        standoff_m: float,
        overlap: float,
        side_overlap: float,
        required_m: float,
    ) -> RoofLook:
        """What a camera on a gimbal needs for a demand, `overlap` between turns, `side_overlap` between shots.

        A pixel is g·R/cos at the range R, with g that of a metre straight ahead: R²/depth ≤ `reach_m` is fine enough.
        """
        reach_m = SHARP * demand.gsd_max_m / camera.gsd_m(1.0)
        aside_m = 0.5 * camera.shot_spacing_m(standoff_m, side_overlap)
        sharp_m = math.sqrt(max(0.0, reach_m * standoff_m - standoff_m**2 - aside_m**2))
        square_m = standoff_m * math.tan(demand.incidence_max_rad)
        return cls(
            picture_m=camera.footprint_m(standoff_m)[1],
            spacing_m=camera.rise_m(standoff_m, overlap),
            standoff_m=standoff_m,
            beside_m=max(required_m + SLACK_M, min(standoff_m, sharp_m, square_m)),
            nearest_m=required_m + SLACK_M,
            reach_m=reach_m,
            cosine_min=math.cos(demand.incidence_max_rad),
        )


def best_way(
    grid: RoofGrid,
    roof: Roof,
    part: NDArray[np.bool_],
    look: RoofLook,
    pace: Limits,
    wall_m: FloatArray,
    start_enu_m: FloatArray,
) -> RoofWay | None:
    """The way above a part of a roof that sees it best.

    Where there is no room for one that sees most of it, it goes nearer to the walls beside it, or around what stands there.
    """
    best: RoofWay | None = None
    free = bool((wall_m[part] > look.beside_m).all())
    for share, encircled in ((1.0, False), (0.5, False), (0.0, False), (1.0, True)):
        here = replace(look, beside_m=look.nearest_m + share * (look.beside_m - look.nearest_m))
        standoff = Standoff(here.standoff_m, here.beside_m - 0.8 * SLACK_M, roof.high_m + STANDING_M)
        line = None if encircled else _line(grid, part, standoff, here, start_enu_m)
        if line is not None:
            way = RoofWay.of(line, grid, roof.cells, part, here, wall_m, 0.0)
            best = way if best is None or way.poor < best.poor - BETTER_SHARE else best
            if best.poor <= POOR_LINE_SHARE:
                return best
        for outward_m in _outward_m(grid, part, here):
            spiral = _spiral(grid, part, standoff, here, pace, start_enu_m, outward_m, encircled)
            if spiral is not None:
                way = RoofWay.of(spiral, grid, roof.cells, part, here, wall_m, outward_m)
                best = way if best is None or way.poor < best.poor - BETTER_SHARE else best
                if best.poor <= POOR_SHARE:
                    return best
        if best and (best.poor <= PASSABLE_SHARE or free):
            return best
    return best


def _outward_m(grid: RoofGrid, part: NDArray[np.bool_], look: RoofLook) -> tuple[float, ...]:
    """How far out the first ring may go: not at all, and where the part rises to its middle, to look square at it."""
    if np.ptp(grid.height_agl_m[part]) < STANDING_M:
        return (0.0,)
    inside_m = -grid.distance_m(part)
    inward = np.stack([np.gradient(inside_m, grid.cell_m, axis=axis)[part] for axis in (1, 0)], axis=1)
    rise = float((grid.slope_enu(part) * inward).sum(axis=1).mean())
    if rise < RISE_MIN:
        return (0.0,)
    square_m = look.standoff_m * math.sin(math.atan(rise))
    return (0.0, 0.5 * square_m, square_m)


@dataclass(frozen=True, slots=True, eq=False)
class RoofWay:
    """A path above a roof, sampled; which cells belong to which place of it, and the share of the part that it does not see well."""

    path: Path
    u_rad: FloatArray
    jet: FloatArray
    belonging: Belonging
    near_wall: NDArray[np.bool_]
    picture_rad: float
    poor: float

    @classmethod
    def of(
        cls,
        path: Path,
        grid: RoofGrid,
        cells: NDArray[np.bool_],
        part: NDArray[np.bool_],
        look: RoofLook,
        wall_m: FloatArray,
        outward_m: float,
    ) -> RoofWay:
        """The way along `path`, and how it sees `part` of the roof of `cells`; its first ring is `outward_m` farther out."""
        ends = path.jet(np.linspace(0.0, path.u_end_rad, 64))[1]
        length_m = float(np.sqrt((ends**2).sum(axis=1)).mean()) * path.u_end_rad
        u = np.linspace(0.0, path.u_end_rad, max(64, math.ceil(length_m / SAMPLE_M)))
        jet = path.jet(u)
        reach_m = np.where(
            wall_m <= look.beside_m, look.beside_m + grid.cell_m, SHOWN * look.picture_m + outward_m
        )
        belonging = Belonging.of(jet[0], grid, cells, reach_m)
        toward = jet[0][belonging.place] - belonging.cell_enu_m
        normal = np.column_stack([-grid.slope_enu(belonging.cells), np.ones(len(toward))])
        range2 = (toward**2).sum(axis=1)
        square_m = (toward * normal).sum(axis=1) / np.sqrt((normal**2).sum(axis=1))
        poor = (range2 > look.reach_m * square_m) | (square_m < look.cosine_min * np.sqrt(range2))
        near_wall = wall_m[grid.index(jet[0, :, :2])] <= look.beside_m + SLACK_M + grid.cell_m
        picture_rad = math.atan(0.5 * look.picture_m / look.standoff_m)
        well = part[belonging.cells] & ~poor
        share = 1.0 - float(well.sum()) / float(part.sum())
        return cls(path, u, jet, belonging, near_wall, picture_rad, share)

    def piece(self, name: str, standoff_m: float, pace: Limits) -> Piece:
        """The path with its gaze."""
        yaw, pitch = roof_gaze(
            self.u_rad,
            self.jet,
            self.belonging,
            near_wall=self.near_wall,
            picture_rad=self.picture_rad,
            smoothing_m=pace.speed_mps,
            speed_mps=pace.speed_mps,
        )
        harmonics = self.path.harmonics if isinstance(self.path, RoofPath) else 0
        return Piece(
            name=name,
            kind="roof",
            path=self.path,
            gaze=yaw,
            rings=0,
            harmonics=harmonics,
            standoff_m=standoff_m,
            pace=pace,
            gimbal_pitch=pitch,
        )


def _spiral(
    grid: RoofGrid,
    part: NDArray[np.bool_],
    standoff: Standoff,
    look: RoofLook,
    pace: Limits,
    start_enu_m: FloatArray,
    outward_m: float,
    encircled: bool,
) -> RoofPath | LinePath | None:
    """The spiral above a part of a roof, a line where its only ring is one; None where there is no room for either, or only high above."""
    insets = insets_of(
        grid,
        part,
        standoff.high_m,
        picture_m=look.picture_m,
        spacing_m=look.spacing_m,
        beside_m=look.beside_m,
        corner_radius_m=min(4.0, pace.speed_mps**2 / pace.acceleration_mps2),
        outward_m=outward_m,
        encircled=encircled,
    )
    if insets is None:
        return None
    if not insets.turns and (ends := _ends_of_thin(insets.rings[0].points_enu_m)) is not None:
        return _straight(grid, standoff, look, *ends, start_enu_m)
    path = roof_spiral(grid, insets, standoff, start_enu_m=start_enu_m)
    while path is None and insets.turns:
        insets = insets.shortened()
        path = roof_spiral(grid, insets, standoff, start_enu_m=start_enu_m)
    too_high = path is not None and path.height_m.knots.max() > standoff.high_m + HIGHEST * look.standoff_m
    return None if too_high else path


def _line(
    grid: RoofGrid,
    part: NDArray[np.bool_],
    standoff: Standoff,
    look: RoofLook,
    start_enu_m: FloatArray,
) -> LinePath | None:
    """The line along a part that one strip of pictures shows; None where it is wider, bent, or beside a wall."""
    places = grid.centres_enu_m(part)
    middle = places.mean(axis=0)
    axes = np.linalg.eigh((places - middle).T @ (places - middle))[1].T[::-1]
    along, across = ((places - middle) @ axis for axis in axes)
    length_m, width_m = np.ptp(along) + grid.cell_m, np.ptp(across) + grid.cell_m
    if width_m > 0.9 * look.picture_m or len(places) * grid.cell_m**2 < 0.6 * length_m * width_m:
        return None
    half_m = max(1.0, 0.5 * (length_m - look.spacing_m))
    centre = (
        middle + 0.5 * (along.min() + along.max()) * axes[0] + 0.5 * (across.min() + across.max()) * axes[1]
    )
    return _straight(grid, standoff, look, centre + half_m * axes[0], centre - half_m * axes[0], start_enu_m)


def _ends_of_thin(ring_enu_m: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """The two far ends of a ring so thin that both its sides see the same; None of any other."""
    x, y = (ring_enu_m - ring_enu_m[0]).T
    along_m = float(np.hypot(*(np.roll(ring_enu_m, -1, axis=0) - ring_enu_m).T).sum())
    width_m = abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) / along_m
    if width_m > THIN_M:
        return None
    one = ring_enu_m[int(np.argmax(np.hypot(*(ring_enu_m - ring_enu_m.mean(axis=0)).T)))]
    other = ring_enu_m[int(np.argmax(np.hypot(*(ring_enu_m - one).T)))]
    return (one, other) if np.hypot(*(one - other)) > THIN_M else None


def _straight(
    grid: RoofGrid,
    standoff: Standoff,
    look: RoofLook,
    one_enu_m: FloatArray,
    other_enu_m: FloatArray,
    start_enu_m: FloatArray,
) -> LinePath | None:
    """The level line between two places `(2,)`, begun at the one nearer to the start; None if it would be high above."""
    ends = [one_enu_m, other_enu_m]
    ends.sort(key=lambda end: float(np.hypot(*(end - start_enu_m))))
    share = np.linspace(0.0, 1.0, 2 + int(np.hypot(*(ends[1] - ends[0])) / grid.cell_m))[:, None]
    height_m = float(standoff.heights_m(grid, ends[0] + share * (ends[1] - ends[0])).max())
    if height_m > standoff.high_m + HIGHEST * look.standoff_m:
        return None
    return LinePath(np.append(ends[0], height_m), np.append(ends[1], height_m))
