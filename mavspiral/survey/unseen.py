"""Where a survey leaves gaps, and why, in words: a few lines that a pilot can act upon."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.frames import COMPASS
from mavspiral.shape.heightmap import Site
from mavspiral.survey import sight
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import (
    NO_ROOM,
    OUT_OF_BAND,
    SEEABLE,
    TOO_FAR,
    UNKNOWN,
    Coverage,
    unseen_because,
)
from mavspiral.survey.patches import Patches
from mavspiral.survey.seeable import Room
from mavspiral.survey.shots import Shots

__all__ = ["unseen_lines"]

LINES_MAX = 6
SMALL_SHARE = 0.001
"""What is less of the walls than this is summed up in one line."""

NARROW, TOO_FEW, IN_COURT = 100, 101, 102
NO_POSE = 1000
"""Beyond this, what hinders every safe pose, not a shot."""
WORDS = {
    sight.OUT_OF_REACH: "too far: no shot comes within {reach:.0f} m",
    sight.BEHIND: "turned away from every shot near enough",
    sight.ABOVE: "above the pictures (the highest shot is {highest:.1f} m up)",
    sight.BELOW: "below the pictures (the lowest shot is {lowest:.1f} m up)",
    sight.ASIDE: "beside the pictures",
    sight.OBLIQUE: "seen only at more than {incidence:.0f}° from square",
    sight.COARSE: "too far: a pixel is more than {gsd:.1f} mm",
    sight.OCCLUDED: "hidden behind something nearer to the camera",
    NARROW: "facing something {near}; turns at this speed only go in where it is {narrow:.0f} m",
    TOO_FEW: "seen by fewer than {views} shots",
    IN_COURT: "in a courtyard, which courtyards = false leaves alone",
    NO_POSE
    + OUT_OF_BAND: "out of the picture from every height that is safe, {lowest_safe:g} to {ceiling:g} m",
    NO_POSE + NO_ROOM: "facing something {near}; a drone needs {clearance:.1f} m of clearance on each side",
    NO_POSE
    + TOO_FAR: "from {clearance:.1f} m away or more at no more than {incidence:.0f}° from square no pixel is as fine as {gsd:.1f} mm",
}


def unseen_lines(
    coverage: Coverage,
    shots: Shots,
    site: Site,
    camera: Camera,
    *,
    narrow_m: float,
    room: Room,
    roofs: bool,
    closed: NDArray[np.bool_],
) -> tuple[str, ...]:
    """One line for each cause of unseen walls, the largest first: how much, why, which sides, between which heights.

    Args:
        coverage: what the shots show.
        shots: the shots.
        site: what stands there.
        camera: the camera.
        narrow_m: the turns do not go in between walls that are nearer to each other than this.
        room: where a pose is safe.
        roofs: whether unseen roofs are to be told of, too.
        closed: which cells `(rows, cols)` are in courtyards that nobody asked for.
    """
    patches = coverage.patches
    wanted = np.ones(len(patches), dtype=np.bool_) if roofs else patches.is_wall
    if bool((coverage.seen | ~wanted).all()):
        return ()
    causes = _causes(coverage, shots, site, camera, narrow_m, closed)
    facts: dict[str, float | str] = {
        "reach": coverage.demand.gsd_max_m / camera.gsd_m(1.0),
        "lowest": float(shots.position_enu_m[:, 2].min(initial=math.inf)),
        "highest": float(shots.position_enu_m[:, 2].max(initial=-math.inf)),
        "incidence": math.degrees(coverage.demand.incidence_max_rad),
        "gsd": 1e3 * coverage.demand.gsd_max_m,
        "narrow": narrow_m,
        "clearance": room.clearance_m,
        "lowest_safe": room.lowest_m,
        "ceiling": room.highest_m,
        "views": coverage.demand.views_min,
    }
    walls = _lines_of("wall", patches.is_wall, coverage, causes, facts)
    return (*walls, *_lines_of("roof", ~patches.is_wall & wanted, coverage, causes, facts))


class _Causes(NamedTuple):
    """Why patches are unseen.

    Args:
        unseen: the patches that are.
        because: of each of them, a key of `WORDS`.
        gaps_m: how far away what each of them faces is.
    """

    unseen: NDArray[np.int64]
    because: NDArray[np.int64]
    gaps_m: FloatArray


def _causes(
    coverage: Coverage, shots: Shots, site: Site, camera: Camera, narrow_m: float, closed: NDArray[np.bool_]
) -> _Causes:
    patches = coverage.patches
    index, because, gaps_m = unseen_because(coverage, shots, site, camera, narrow_m)
    because = np.where(coverage.views[index] > 0, TOO_FEW, because)
    because = np.where((gaps_m < narrow_m) & (because != TOO_FEW), NARROW, because)
    row, col = np.moveaxis(site.heights.index(patches.before_enu_m[index]), -1, 0)
    rows, cols = closed.shape
    in_court = closed[np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)] & patches.is_wall[index]
    because = np.where(in_court, IN_COURT, because)
    best_pose = coverage.best_pose[index]
    because = np.where((best_pose != UNKNOWN) & (best_pose != SEEABLE), NO_POSE + best_pose, because)
    return _Causes(index, because, gaps_m)


def _lines_of(
    what: str, of: NDArray[np.bool_], coverage: Coverage, causes: _Causes, facts: Mapping[str, float | str]
) -> tuple[str, ...]:
    """The lines on walls or roofs, `what`, which are the patches `of`; the small causes are summed up in the last."""
    patches, (index, because, gaps_m) = coverage.patches, causes
    whole_m2 = float(patches.area_m2[of].sum())
    told: list[tuple[float, str]] = []
    rest_m2 = 0.0
    for reason in np.unique(because[of[index]]):
        here = index[of[index] & (because == reason)]
        area_m2 = float(patches.area_m2[here].sum())
        if area_m2 < SMALL_SHARE * whole_m2:
            rest_m2 += area_m2
            continue
        near_m = float(gaps_m[because == reason].min())
        near = f"{near_m:.0f} m away or more" if near_m >= 0.5 else "that may lean on it"
        cause = WORDS[int(reason)].format(near=near, **facts)
        sides = _sides(patches, here) if what == "wall" else ""
        low, high = _heights_m(patches.centre_enu_m[here, 2], patches.height_m[here])
        line = (
            f"unseen {what}: {_area(area_m2)} ({_share(area_m2 / whole_m2)}) {_known(coverage, here)}{cause}; "
            f"{sides}{_between(low, high)} m up"
        )
        told.append((area_m2, line))
    told.sort(reverse=True)
    rest_m2 += sum(area for area, _ in told[LINES_MAX:])
    lines = tuple(line for _, line in told[:LINES_MAX])
    if rest_m2 < 0.1:
        return lines
    return (*lines, f"unseen {what}: {_area(rest_m2)} ({_share(rest_m2 / whole_m2)}) in scattered places")


def _known(coverage: Coverage, here: NDArray[np.int64]) -> str:
    """Whether patches that are unseen for the same reason could be seen, where that is known."""
    if coverage.best_pose[here[0]] == UNKNOWN:
        return ""
    return (
        "seeable, not seen by this plan: "
        if coverage.best_pose[here[0]] == SEEABLE
        else "no safe pose sees it: "
    )


def _sides(patches: Patches, index: NDArray[np.int64]) -> str:
    """The compass sides that these patches face, most of them first; few of a side are not told."""
    sides = _facing(patches, index)
    if len(sides) > 2 and set(sides) >= set(_facing(patches, np.flatnonzero(patches.is_wall))):
        return "all sides, "
    return f"{_listed([COMPASS[k] for k in sides])} side{'s' * (len(sides) > 1)}, "


def _facing(patches: Patches, index: NDArray[np.int64]) -> list[int]:
    normal = patches.normal_enu[index]
    sector = np.round(np.arctan2(normal[:, 1], normal[:, 0]) / (np.pi / 4)).astype(np.int64) % 8
    areas_m2 = np.bincount(sector, weights=patches.area_m2[index], minlength=8)
    return [int(k) for k in np.argsort(-areas_m2, kind="stable") if areas_m2[k] > 0.05 * areas_m2.sum()]


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _heights_m(centre_m: FloatArray, height_m: FloatArray) -> tuple[float, float]:
    return float((centre_m - 0.5 * height_m).min()), float((centre_m + 0.5 * height_m).max())


def _between(low_m: float, high_m: float) -> str:
    low, high = f"{low_m:.1f}", f"{high_m:.1f}"
    return low if low == high else f"{low} to {high}"


def _area(area_m2: float) -> str:
    return f"{area_m2:.0f} m²" if area_m2 >= 10 else f"{area_m2:.1f} m²"


def _share(share: float) -> str:
    return f"{100 * share:.1f} %" if share >= 0.001 else "less than 0.1 %"
