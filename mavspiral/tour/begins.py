"""Where spirals are begun: so that the real ways to them, from one to the next and back take the least time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.curve.gaze import inward_gaze
from mavspiral.curve.spiral import TOLERANCE_M, SpiralPath
from mavspiral.motion.limits import Limits
from mavspiral.tour.passes import Piece
from mavspiral.tour.route import TAKEOFF_M
from mavspiral.tour.transit import MARGIN_M, STEP_M, Ways

__all__ = ["begun_where_ways_are_short", "ways_s"]

PHASES = 24
"""So many places on its first turn a spiral may be begun at."""
WON_S = 0.5
"""It is begun elsewhere than planned for no less."""
SAMPLE_RAD = np.pi / 64
SLACK_M = 0.01
"""What sampling leaves open of a distance."""


def begun_where_ways_are_short(
    pieces: Sequence[Piece], home_enu_m: FloatArray, ways: Ways
) -> tuple[Piece, ...]:
    """The pieces in the same order, each spiral begun where the ways between all of them and home are quickest together.

    A spiral whose outlines change with its height is another curve when it is begun elsewhere: where that comes nearer to
    anything than its stand-off and than the planned one does, the planned one stays.
    """
    places = [_ends(piece.path) for piece in pieces]
    above_home_m = home_enu_m[None] + np.array([0.0, 0.0, TAKEOFF_M])
    return tuple(
        _begun(piece, choice, ways) if choice else piece
        for piece, choice in zip(
            pieces, _quickest([*places, (above_home_m, above_home_m)], ways), strict=True
        )
    )


def ways_s(ways: Ways, start_enu_m: FloatArray, end_enu_m: FloatArray) -> FloatArray:
    """About how long the lowest safe way takes from each start to each end, both `(n, 3)`.

    They are those of `safe_way`: straight, else up, across and down. What is safe stays safe straight up, so the lowest
    height is found by halving. Infinity where there is none below the ceiling.
    """
    took_s = _line_s(end_enu_m - start_enu_m, ways.limits)
    hindered = np.flatnonzero(~_safe(ways, start_enu_m, end_enu_m - start_enu_m))
    start, end = start_enu_m[hindered], end_enu_m[hindered]
    lowest_m = np.maximum(start[:, 2], end[:, 2])
    highest_m = np.minimum(ways.ceiling_m, np.maximum(lowest_m, ways.top_m + ways.clearance_m + MARGIN_M))
    heights = np.ceil((highest_m - lowest_m) / STEP_M).astype(np.int64) + 1
    low, high = np.zeros(len(start), dtype=np.int64), heights.copy()
    across = end - start
    across[:, 2] = 0.0
    while (open_ := np.flatnonzero(low < high)).size:
        middle = (low[open_] + high[open_]) // 2
        above = np.column_stack(
            [start[open_, :2], np.minimum(lowest_m[open_] + STEP_M * middle, highest_m[open_])]
        )
        safe = _safe(ways, above, across[open_])
        low[open_] = np.where(safe, low[open_], middle + 1)
        high[open_] = np.where(safe, middle, high[open_])
    height_m = np.minimum(lowest_m + STEP_M * low, highest_m)
    up = np.column_stack([np.zeros((len(start), 2)), height_m - start[:, 2]])
    down = np.column_stack([np.zeros((len(start), 2)), end[:, 2] - height_m])
    took_s[hindered] = sum(_line_s(side, ways.limits) for side in (up, across, down))
    joinable = _safe(ways, start, np.zeros(3)) & _safe(ways, end, np.zeros(3))
    took_s[hindered[~joinable | (low >= heights)]] = np.inf
    return took_s


def _safe(ways: Ways, start_enu_m: FloatArray, sweep_m: FloatArray) -> NDArray[np.bool_]:
    """Which straight lines keep what `safe_way` keeps."""
    return ways.solids.clear(start_enu_m, sweep_m, ways.clearance_m + MARGIN_M - 1e-9)


def _line_s(sides_m: FloatArray, limits: Limits) -> FloatArray:
    """How long straight lines `(n, 3)` take from rest to rest."""
    rise_m = sides_m[:, 2]
    vertical_s = np.where(rise_m > 0.0, rise_m / limits.climb_mps, -rise_m / limits.descent_mps)
    length_m = np.sqrt((sides_m**2).sum(axis=1))
    halting_s = np.where(length_m > 0.0, limits.speed_mps / limits.acceleration_mps2, 0.0)
    return np.asarray(np.maximum(length_m / limits.speed_mps, vertical_s) + halting_s)


def _ends(path: Path) -> tuple[FloatArray, FloatArray]:
    """Where a path may begin, and where it then ends, `(n, 3)` each; as it is planned first of all."""
    if not isinstance(path, SpiralPath):
        return path(np.array([0.0])), path(np.array([path.u_end_rad]))
    phases_rad = np.linspace(0.0, 2.0 * np.pi, PHASES, endpoint=False)
    return path.places_begun(0.0, phases_rad), path.places_begun(path.u_end_rad, phases_rad)


def _quickest(places: Sequence[tuple[FloatArray, FloatArray]], ways: Ways) -> list[int]:
    """Which of its places each stop of a round trip is visited at, the last stop being where it begins and ends."""
    took_s = np.zeros(1)
    came: list[NDArray[np.intp]] = []
    _, exits = places[-1]
    for entries, leaving in places:
        rows, cols = np.divmod(np.arange(len(exits) * len(entries)), len(entries))
        way_s = ways_s(ways, exits[rows], entries[cols]).reshape(len(exits), len(entries))
        way_s[:, 1:] += WON_S
        came.append(np.argmin(took_s[:, None] + way_s, axis=0))
        took_s = (took_s[:, None] + way_s).min(axis=0)
        exits = leaving
    chosen = [0]
    for before in came[:0:-1]:
        chosen.append(int(before[chosen[-1]]))
    return chosen[:0:-1]


def _begun(piece: Piece, choice: int, ways: Ways) -> Piece:
    """A spiral begun at one of its places, or as it is where that comes too near."""
    assert isinstance(piece.path, SpiralPath)
    path = piece.path.begun(2.0 * np.pi * choice / PHASES)
    if not _is_as_far(path, piece, ways):
        return piece
    return replace(piece, path=path, gaze=inward_gaze(path, smoothing_m=piece.pace.speed_mps))


def _is_as_far(path: SpiralPath, planned: Piece, ways: Ways) -> bool:
    """Whether a path keeps the stand-off from everything, or at least as much as the planned one."""
    ways_m = _straight_ways_m(path)
    if ways.solids.clear(*ways_m, planned.standoff_m - TOLERANCE_M).all():
        return True
    nearest_m = float(ways.solids.distance_m(*_straight_ways_m(planned.path)).min())
    return bool(ways.solids.clear(*ways_m, nearest_m - SLACK_M).all())


def _straight_ways_m(path: Path) -> tuple[FloatArray, FloatArray]:
    """A path as straight ways, their beginnings and sweeps `(n, 3)`."""
    place = path(np.linspace(0.0, path.u_end_rad, int(path.u_end_rad / SAMPLE_RAD) + 2))
    return place[:-1], np.diff(place, axis=0)
