"""Straight lines that show what the other passes leave unseen, the camera turned and tilted as it is best seen.

Patches that are unseen, though some safe pose could see them, are asked for such poses. A pose is drawn out to a level line
beside the wall as far as it stays safe and shows more of them. The line that shows most for its time is taken, and so
on, while one is worth its flight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve.line import LinePath
from mavspiral.motion.limits import Limits
from mavspiral.motion.turn import TurnGaze
from mavspiral.shape.heightmap import Site
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import SEEABLE, Coverage
from mavspiral.survey.glimpses import gsd_m, shown
from mavspiral.survey.seeable import Glimpses, Room, glimpses_of
from mavspiral.survey.solids import Solids
from mavspiral.tour.passes import Piece
from mavspiral.tour.transit import stopping_pace

__all__ = ["WORTH_M2", "WORTH_SHARE", "Filler"]

WORTH_M2 = 1.0
WORTH_SHARE = 0.005
"""Of all walls, or of all roofs: what shows less, or less than `WORTH_M2`, is not flown."""
LINES_MAX = 8
LEFT_MAX = 1200
"""Of more patches than this, evenly chosen ones stand for all."""
SEEDS_MAX = 40
POSES_MAX = 300
DRAWN_OUT = 8
"""So many of the poses, those that show most, are drawn out to lines."""
AWAY_N = 40
"""A line goes so many shots to either side at the most."""
GAP_N = 2
"""It goes on over so many shots that show nothing."""
DETOUR_S = 15.0
"""What a line costs beside its own length: the way to it, and from rest to rest."""
SHORTEST_M = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    start_enu_m: FloatArray
    end_enu_m: FloatArray
    yaw_enu_rad: float
    pitch_rad: float
    range_m: float
    shows: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Filler:
    """What lines are made for: the site, the camera, where it may be, how fast, and for which walls or also roofs.

    `sharp_mps` tells how fast what is so far away may pass through the picture. Walls that stand on `closed` cells
    `(rows, cols)` are left alone: courtyards that nobody asked for.
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

    def pieces(self, coverage: Coverage, first: int = 1) -> tuple[Piece, ...]:
        """The lines for what this coverage leaves unseen, numbered from `first`; none where none is worth its flight."""
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
        lines: list[_Line] = []
        while len(lines) < LINES_MAX and worth[left].sum() >= 1.0:
            line = self._best_line(coverage, left, worth[left])
            if line is None:
                break
            lines.append(line)
            left = left[~line.shows]
        return tuple(self._piece(f"fill {number}", line) for number, line in enumerate(lines, start=first))

    def _best_line(self, coverage: Coverage, left: NDArray[np.int64], worth: FloatArray) -> _Line | None:
        """The line that shows most of what is left for its time, None if none shows enough."""
        patches = coverage.patches
        seeds = left[np.unique(np.linspace(0, len(left) - 1, SEEDS_MAX).astype(np.int64))]
        poses = glimpses_of(patches, seeds, self.site, self.solids, self.camera, coverage.demand, self.room)
        poses = _some(poses, POSES_MAX)
        shows = self._shows(coverage, left, poses.place_enu_m, poses.yaw_enu_rad, poses.pitch_rad)
        best, best_value = None, 0.0
        for number in np.argsort(-(shows @ worth), kind="stable")[:DRAWN_OUT]:
            for line in self._drawn_out(coverage, left, poses, int(number)):
                gain = float(worth[line.shows].sum())
                length_m = float(np.linalg.norm(line.end_enu_m - line.start_enu_m))
                value = gain / (DETOUR_S + length_m / self._pace(line).speed_mps)
                if gain >= 1.0 and value > best_value:
                    best, best_value = line, value
        return best

    def _drawn_out(
        self, coverage: Coverage, left: NDArray[np.int64], poses: Glimpses, number: int
    ) -> list[_Line]:
        """The lines through a pose, along the wall that it looks at and square to where it looks."""
        patches, seed = coverage.patches, int(poses.patch[number])
        place = poses.place_enu_m[number]
        yaw, pitch = float(poses.yaw_enu_rad[number]), float(poses.pitch_rad[number])
        range_m = float(np.linalg.norm(patches.centre_enu_m[seed] - place))
        normal = patches.normal_enu[seed, :2]
        ways = [np.array([-np.sin(yaw), np.cos(yaw), 0.0])]
        if (upright := float(np.hypot(*normal))) > 0.05:
            ways.append(np.array([-normal[1], normal[0], 0.0]) / upright)
        lines = []
        for along in ways:
            places, here = self._safe_along(
                place, self.camera.shot_spacing_m(range_m, self.side_overlap) * along
            )
            n = len(places)
            shows = self._shows(coverage, left, places, np.full(n, yaw), np.full(n, pitch))
            first, last = _showing(shows, here)
            start, end = places[first], places[last]
            if first == last:
                sides = np.array([along, -along]) * SHORTEST_M
                safe = self.solids.distance_m(np.array([start, start]), sides) >= self.room.clearance_m
                if not safe.any():
                    continue
                end = start + sides[int(np.argmax(safe))]
            shown_by_it = np.asarray(shows[first : last + 1].any(axis=0))
            lines.append(_Line(start, end, yaw, pitch, range_m, shown_by_it))
        return lines

    def _safe_along(self, place_enu_m: FloatArray, step_m: FloatArray) -> tuple[FloatArray, int]:
        """Places a step apart `(n, 3)` on the line through one, as far as it stays safe, and which of them that one is."""
        places = place_enu_m + np.arange(-AWAY_N, AWAY_N + 1)[:, None] * step_m
        safe = self.solids.distance_m(places[:-1], np.diff(places, axis=0)) >= self.room.clearance_m
        before = int(np.argmin(np.append(safe[:AWAY_N][::-1], False)))
        after = int(np.argmin(np.append(safe[AWAY_N:], False)))
        return places[AWAY_N - before : AWAY_N + after + 1], before

    def _shows(
        self,
        coverage: Coverage,
        left: NDArray[np.int64],
        place_enu_m: FloatArray,
        yaw_enu_rad: FloatArray,
        pitch_rad: FloatArray,
    ) -> NDArray[np.bool_]:
        """Which of the patches `left` each pose shows, `(poses, left)`."""
        patches = coverage.patches
        gsd = gsd_m(
            patches.centre_enu_m[left],
            patches.normal_enu[left],
            place_enu_m[:, None],
            yaw_enu_rad[:, None],
            pitch_rad[:, None],
            self.camera,
            coverage.demand,
        )
        pose, patch = np.nonzero(np.isfinite(gsd))
        sees = np.zeros(gsd.shape, dtype=np.bool_)
        sees[pose, patch] = shown(
            self.site, patches.before_enu_m[left[patch]], place_enu_m[pose], gsd[pose, patch]
        )
        return sees

    def _pace(self, line: _Line) -> Limits:
        pace = stopping_pace(self.solids, line.start_enu_m, line.end_enu_m, self.pace, self.radius_m)
        return replace(pace, speed_mps=min(pace.speed_mps, self.sharp_mps(line.range_m)))

    def _piece(self, name: str, line: _Line) -> Piece:
        return Piece(
            name,
            "fill",
            LinePath(line.start_enu_m, line.end_enu_m),
            TurnGaze(line.yaw_enu_rad, line.yaw_enu_rad),
            0,
            0,
            line.range_m,
            self._pace(line),
            TurnGaze(line.pitch_rad, line.pitch_rad),
        )


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


def _showing(shows: NDArray[np.bool_], here: int) -> tuple[int, int]:
    """From which to which shot of a line it is worth flying: out from `here` to the last that shows what none before did."""
    had, ends = shows[here].copy(), [here, here]
    for side, way in ((0, -1), (1, 1)):
        k = here + way
        while 0 <= k < len(shows) and abs(k - ends[side]) <= GAP_N + 1:
            if (shows[k] & ~had).any():
                had |= shows[k]
                ends[side] = k
            k += way
    return ends[0], ends[1]
