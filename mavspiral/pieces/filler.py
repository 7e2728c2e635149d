"""Lines and turns that show what the other passes leave unseen, the camera turned and tilted as it is best seen.

Patches that are unseen, though some safe pose could see them, are asked for such poses. A pose is drawn out to a level line
beside the wall, and along a level turn round the building, as far as it stays safe and shows more of them. What shows most for
its time is taken, and so on, while one is worth its flight.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.headway import Headway, to_nobody
from mavspiral.motion.limits import Limits
from mavspiral.motion.turn import TurnGaze
from mavspiral.pieces.fill_lines import lines_through
from mavspiral.pieces.fill_turns import Round, turn_through
from mavspiral.pieces.gap import Fill, Gap, Pose
from mavspiral.shape.heightmap import Site
from mavspiral.shape.slicing import solid_distance
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import SEEABLE, Coverage
from mavspiral.survey.seeable import Glimpses, Room, glimpses_of
from mavspiral.survey.solids import Solids
from mavspiral.tour.passes import Piece
from mavspiral.tour.transit import stopping_pace

__all__ = ["WORTH_M2", "WORTH_SHARE", "Filler"]

WORTH_M2 = 1.0
WORTH_SHARE = 0.005
"""Of all walls, or of all roofs: what shows less, or less than `WORTH_M2`, is not flown."""
FILLS_MAX = 8
LEFT_MAX = 1200
"""Of more patches than this, evenly chosen ones stand for all."""
SEEDS_MAX = 40
POSES_MAX = 300
DRAWN_OUT = 8
"""So many of the poses are drawn out to lines and turns."""
SPARE_M = 0.05
"""A pose keeps so much more than a fill: what it is drawn out along is never quite even."""
DETOUR_S = 15.0
"""What a fill costs beside its own length: the way to it, and from rest to rest."""


@dataclass(frozen=True, slots=True, eq=False)
class Filler:
    """What gaps are filled for: the site, the camera, where it may be, how fast, and for which walls or also roofs.

    `sharp_mps` tells how fast what is so far away may pass through the picture. Walls that stand on `closed` cells
    `(rows, cols)` are left alone: courtyards that nobody asked for. Turns begin near `home_enu_m`.
    """

    site: Site
    closed: NDArray[np.bool_]
    solids: Solids
    camera: Camera
    room: Room
    pace: Limits
    sharp_mps: Callable[[float], float]
    side_overlap: float
    radius_m: float
    roofs: bool
    home_enu_m: FloatArray

    def pieces(self, coverage: Coverage, first: int = 1, headway: Headway = to_nobody) -> tuple[Piece, ...]:
        """The fills for what this coverage leaves unseen, numbered from `first`; none where none is worth its flight."""
        gap = self._gap(coverage)
        fills: list[Fill] = []
        if gap.worth.sum() < 1.0:
            return ()
        around = self._round(gap)
        while len(fills) < FILLS_MAX and gap.worth.sum() >= 1.0:
            fill = self._best(gap, around)
            if fill is None:
                break
            fills.append(fill)
            gap = gap.without(fill.shows)
            headway(len(fills) / FILLS_MAX)
        return tuple(self._piece(f"fill {number}", fill) for number, fill in enumerate(fills, start=first))

    def _gap(self, coverage: Coverage) -> Gap:
        """What is unseen and worth a look."""
        patches = coverage.patches
        wanted = ~coverage.seen & (coverage.best_pose == SEEABLE) & (patches.is_wall | self.roofs)
        row, col = np.moveaxis(self.site.heights.index(patches.before_enu_m), -1, 0)
        rows, cols = self.closed.shape
        wanted &= ~(patches.is_wall & self.closed[np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)])
        left = np.flatnonzero(wanted)
        every = 1 + len(left) // LEFT_MAX
        left, worth = left[::every], np.zeros(len(patches))
        for kind in (patches.is_wall, ~patches.is_wall):
            least_m2 = max(WORTH_M2, WORTH_SHARE * float(patches.area_m2[kind].sum()))
            worth[kind] = every * patches.area_m2[kind] / least_m2
        return Gap(self.site, self.camera, coverage, left, worth[left])

    def _round(self, gap: Gap) -> Round:
        """What turns need to know; no pose that sees well is farther from the building than a pixel allows."""
        reach_m = gap.coverage.demand.gsd_max_m / self.camera.gsd_m(1.0)
        corner_m = self.pace.speed_mps**2 / self.pace.acceleration_mps2
        building = solid_distance(self.site, reach_m=2.0 * reach_m + corner_m)
        return Round(building, self.solids, self.room.clearance_m, self.pace, self.home_enu_m)

    def _best(self, gap: Gap, around: Round) -> Fill | None:
        """What shows most of the gap for its time, None if nothing shows enough."""
        best, best_value = None, 0.0
        for fill in self._drawn_out(gap, around):
            gain = float(gap.worth[fill.shows].sum())
            value = gain / (DETOUR_S + fill.length_m / self._pace(fill).speed_mps)
            if gain >= 1.0 and value > best_value:
                best, best_value = fill, value
        return best

    def _drawn_out(self, gap: Gap, around: Round) -> Iterator[Fill]:
        """The lines and turns through poses that show most between them."""
        coverage, left = gap.coverage, gap.left
        seeds = left[np.unique(np.linspace(0, len(left) - 1, SEEDS_MAX).astype(np.int64))]
        room = replace(self.room, clearance_m=self.room.clearance_m + SPARE_M)
        glimpses = glimpses_of(
            coverage.patches, seeds, self.site, self.solids, self.camera, coverage.demand, room
        )
        poses = _some(glimpses, POSES_MAX)
        shows = gap.shows(poses.place_enu_m, poses.yaw_enu_rad, poses.pitch_rad)
        for number in _apart(shows, gap.worth):
            pose = _pose(gap, poses, number)
            spacing_m = self.camera.shot_spacing_m(pose.range_m, self.side_overlap)
            yield from lines_through(pose, gap, solids=self.solids, room=self.room, spacing_m=spacing_m)
            if (turn := turn_through(pose, gap, around, spacing_m=spacing_m)) is not None:
                yield turn

    def _pace(self, fill: Fill) -> Limits:
        end_enu_m = fill.path(fill.path.u_end_rad)
        begin_enu_m = end_enu_m - fill.path(fill.path.u_end_rad, 1)
        pace = stopping_pace(self.solids, begin_enu_m, end_enu_m, self.pace, self.radius_m)
        return replace(pace, speed_mps=min(pace.speed_mps, self.sharp_mps(fill.pose.range_m)))

    def _piece(self, name: str, fill: Fill) -> Piece:
        pose = fill.pose
        pitch = TurnGaze(pose.pitch_rad, pose.pitch_rad)
        return Piece(
            name=name,
            kind="fill",
            path=fill.path,
            gaze=fill.gaze,
            rings=0,
            harmonics=fill.harmonics,
            standoff_m=pose.range_m,
            pace=self._pace(fill),
            gimbal_pitch=pitch,
        )


def _pose(gap: Gap, poses: Glimpses, number: int) -> Pose:
    """One of the poses."""
    patches, seed = gap.coverage.patches, int(poses.patch[number])
    centre, place = patches.centre_enu_m[seed], poses.place_enu_m[number]
    yaw, pitch = float(poses.yaw_enu_rad[number]), float(poses.pitch_rad[number])
    return Pose(place, yaw, pitch, centre, patches.normal_enu[seed])


def _apart(shows: NDArray[np.bool_], worth: FloatArray) -> list[int]:
    """`DRAWN_OUT` of the poses: the one that shows most, then the one that shows most of what that does not, and so on."""
    chosen: list[int] = []
    worth = worth.copy()
    while len(chosen) < min(DRAWN_OUT, len(shows)):
        gain = shows @ worth
        chosen.append(int(np.argmax(gain)))
        worth[shows[chosen[-1]]] = 0.0
    return chosen


def _some(poses: Glimpses, count: int) -> Glimpses:
    """No more than so many of the poses, evenly."""
    if len(poses.patch) <= count:
        return poses
    rows = np.linspace(0, len(poses.patch) - 1, count).astype(np.int64)
    return Glimpses(
        poses.patch[rows],
        poses.place_enu_m[rows],
        poses.yaw_enu_rad[rows],
        poses.pitch_rad[rows],
        poses.gsd_m[rows],
    )
