"""What a plan leaves unseen though some safe pose could see it, and what other poses would show of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.motion.turn import Gaze
from mavspiral.shape.heightmap import Site
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import Coverage
from mavspiral.survey.glimpses import gsd_m, shown

__all__ = ["Fill", "Gap", "Pose", "worth_flying"]

GAP_N = 2
"""A fill goes on over so many shots that show nothing new."""


class Pose(NamedTuple):
    """A pose that shows a patch well: from where, how the camera is turned and tilted, and the patch's centre and normal."""

    place_enu_m: FloatArray
    yaw_enu_rad: float
    pitch_rad: float
    centre_enu_m: FloatArray
    normal_enu: FloatArray

    @property
    def range_m(self) -> float:
        """How far away the patch is."""
        return float(np.linalg.norm(self.centre_enu_m - self.place_enu_m))


@dataclass(frozen=True, slots=True, eq=False)
class Fill:
    """A curve through a pose, its gaze, the tilt all along it, and which of a gap's patches its shots show."""

    path: Path
    gaze: Gaze
    pose: Pose
    harmonics: int
    length_m: float
    shows: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Gap:
    """The patches `left` of a coverage, and what each is worth to be shown: 1 in all is worth a flight."""

    site: Site
    camera: Camera
    coverage: Coverage
    left: NDArray[np.int64]
    worth: FloatArray

    def shows(
        self, place_enu_m: FloatArray, yaw_enu_rad: FloatArray, pitch_rad: FloatArray
    ) -> NDArray[np.bool_]:
        """Which of the patches each pose shows, `(poses, left)`."""
        patches = self.coverage.patches
        gsd = gsd_m(
            patches.centre_enu_m[self.left],
            patches.normal_enu[self.left],
            place_enu_m[:, None],
            yaw_enu_rad[:, None],
            pitch_rad[:, None],
            self.camera,
            self.coverage.demand,
        )
        pose, patch = np.nonzero(np.isfinite(gsd))
        sees = np.zeros(gsd.shape, dtype=np.bool_)
        sees[pose, patch] = shown(
            self.site, patches.before_enu_m[self.left[patch]], place_enu_m[pose], gsd[pose, patch]
        )
        return sees

    def without(self, shown_patches: NDArray[np.bool_]) -> Gap:
        """What is left of it once these are shown."""
        return replace(self, left=self.left[~shown_patches], worth=self.worth[~shown_patches])


def worth_flying(shows: NDArray[np.bool_], here: int) -> tuple[int, int]:
    """From which to which of the shots `(n, left)` on a way: out from `here` to the last that shows what none before did."""
    had, ends = shows[here].copy(), [here, here]
    for side, way in ((0, -1), (1, 1)):
        k = here + way
        while 0 <= k < len(shows) and abs(k - ends[side]) <= GAP_N + 1:
            if (shows[k] & ~had).any():
                had |= shows[k]
                ends[side] = k
            k += way
    return ends[0], ends[1]
