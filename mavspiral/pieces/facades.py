"""Façades that are flown to and fro, because a party wall or a close neighbour forbids the full turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mavspiral.arrays import FloatArray
from mavspiral.brief import smaller_clearance
from mavspiral.curve.meander import Row, meander
from mavspiral.frames import COMPASS
from mavspiral.pieces.candidate import Candidate, Setting
from mavspiral.shape.parts import Part
from mavspiral.shape.reach import Reach, arcs_of, reach_at
from mavspiral.shape.slicing import SolidDistance
from mavspiral.tour.passes import Piece
from mavspiral.tour.transit import STOPPING_MARGIN_M

__all__ = ["Facades", "facades_of", "hemmed_in"]

ROUNDED_M = 0.3
"""What rounding the corners of rows may take of the clearance."""
SPEED_STEPS = 16
SAME_PLACE_M = 2.0
SAME_ROW_M = 0.5
SHORTEST_M = 2.0
ABOVE_M = 0.05
APART_M = 0.25
MORE_ROWS = 8
SAMPLES = 3_000
SHARE = 0.05
"""Of a line, what must be nearer to the walls than the stand-off for the rows to be flown closer together."""


@dataclass(frozen=True, slots=True)
class Facades:
    """What is flown to and fro, from which height on the full turn is free, if at all, and what nobody can reach."""

    candidates: tuple[Candidate, ...]
    free_from_m: float | None
    told: tuple[str, ...]


def facades_of(setting: Setting, others: SolidDistance, part: Part, low_m: float, high_m: float) -> Facades:
    """The accessible arcs round a part between two heights, each chain of arcs one above the other a façade."""
    standoff_m = _nearest_standoff_m(setting, others, part, low_m)
    low_m, high_m = _nearer_band_m(setting, part, low_m, high_m, standoff_m)
    heights_m = _row_heights_m(setting, others, part, low_m, high_m, setting.rise_m(standoff_m))
    reaches = [_reach(setting, others, part, float(height_m)) for height_m in heights_m]
    blocked = [index for index, reach in enumerate(reaches) if reach is None or not reach.free]
    first_free = blocked[-1] + 1 if blocked else 0
    if first_free == len(heights_m) - 1:  # one turn alone is flown with the rows below it
        first_free += 1
    chains = _chains([reach for reach in reaches[:first_free] if reach is not None])
    free_from_m = float(heights_m[first_free]) if first_free < len(heights_m) else None
    joined = [rows for chain in chains for rows in _parted(setting, chain)]
    candidates = tuple(_candidate(setting, rows, standoff_m) for rows in joined)
    return Facades(
        candidates, free_from_m, _told(setting, [r for r in reaches[:first_free] if r is not None])
    )


def hemmed_in(setting: Setting, others: SolidDistance, height_m: float) -> str:
    """In words: where there is the most room beside the walls at a height, how much that is, and what would fit there."""
    solid, standoff_m = setting.solid, setting.standoff_m
    if standoff_m < (least_m := _kept_m(setting)):
        return (
            f"[inspection] standoff_m = {standoff_m:g}: other things on the map or keep-outs stand too near for a full turn, and what is "
            f"flown to and fro beside them keeps {least_m:.2f} m ({setting.required_m:.2f} m of clearance, the rest for corners and ways). "
            f"Fix: standoff_m ≥ {math.ceil(10.0 * least_m) / 10.0:.1f}"
        )
    walls_m, others_m = (
        distance.excess_m(distance.slice(height_m, standoff_m)) + standoff_m for distance in (solid, others)
    )
    room = np.where(walls_m <= standoff_m, np.minimum(walls_m, others_m), -1.0)
    row, col = np.unravel_index(int(np.argmax(room)), room.shape)
    room_m = float(room[row, col])
    place_enu_m = np.array([*(solid.origin_enu_m + np.array([col, row]) * solid.cell_m), height_m])
    place = setting.site.heights.frame.geo_point(place_enu_m)
    would_fit = smaller_clearance(setting.mission, room_m - (_kept_m(setting) - setting.required_m))
    return (
        f"other things on the map and keep-outs stand so near on all sides that no drone can fly along any wall: the most room is "
        f"{room_m:.1f} m on either side, at lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, {height_m:.1f} m up, and "
        f"{_kept_m(setting):.1f} m are needed. Fix: {f'{would_fit}, or ' if would_fit else ''}a band above them (bottom_m)"
    )


def _kept_m(setting: Setting) -> float:
    """What façades keep from everything."""
    return setting.joinable_m + 0.5 * ROUNDED_M


def _reach(setting: Setting, others: SolidDistance, part: Part, height_m: float) -> Reach | None:
    return reach_at(
        setting.solid,
        others,
        height_m=height_m,
        standoff_m=setting.standoff_m,
        clearance_m=min(setting.joinable_m + ROUNDED_M, setting.standoff_m),
        required_m=_kept_m(setting),
        anchor_enu_m=part.anchor_enu_m,
    )


def _nearest_standoff_m(setting: Setting, others: SolidDistance, part: Part, height_m: float) -> float:
    """The least distance from the walls along what is accessible at a height, unless it is hardly anywhere."""
    reach = _reach(setting, others, part, height_m)
    if reach is None or not reach.accessible.any():
        return setting.standoff_m
    return float(min(setting.standoff_m, np.quantile(reach.wall_m[reach.accessible], SHARE)))


def _nearer_band_m(
    setting: Setting, part: Part, low_m: float, high_m: float, standoff_m: float
) -> tuple[float, float]:
    """The band, wider where nothing else was asked for: from nearer, a picture shows less of the wall."""
    asked, limits = setting.mission.inspection, setting.mission.limits
    half_m = setting.half_m(standoff_m)
    if asked.bottom_m is None and part.base_m == 0.0:
        low_m = min(low_m, max(limits.clearance_m, half_m))
    if asked.top_m is None:
        high_m = min(limits.ceiling_m, max(high_m, part.top_m - half_m))
    return low_m, high_m


def _row_heights_m(
    setting: Setting, others: SolidDistance, part: Part, low_m: float, high_m: float, rise_m: float
) -> FloatArray:
    """Rows at the most `rise_m` apart, and one as low above each neighbour's roof as is safe, up to the part's own."""
    highest_m = high_m
    if setting.mission.inspection.top_m is None:
        highest_m = max(high_m, min(part.top_m, setting.mission.limits.ceiling_m))
    rows_m = np.linspace(low_m, high_m, int(np.ceil((high_m - low_m) / rise_m - 1e-9)) + 1)
    above_m = others.levels_m + setting.joinable_m + ROUNDED_M + ABOVE_M
    more_m = above_m[(above_m > low_m) & (above_m < highest_m)]
    more_m = more_m[:MORE_ROWS]
    inner_m = [row_m for row_m in rows_m[1:-1] if not (np.abs(more_m - row_m) < SAME_ROW_M).any()]
    return _apart_m(np.unique(np.concatenate([rows_m[[0, -1]], inner_m, more_m])), min(APART_M, rise_m / 2))


def _apart_m(rows_m: FloatArray, least_m: float) -> FloatArray:
    """Rising heights without those just below another: on the line that it went out on no curve comes back."""
    kept = [float(rows_m[-1])]
    for row_m in rows_m[-2::-1].tolist():
        if kept[-1] - row_m >= least_m:
            kept.append(row_m)
    return np.array(kept[::-1])


def _chains(reaches: list[Reach]) -> list[list[Row]]:
    """Arcs one above the other: an arc goes on with the longest one that lies within it below."""
    open_chains: list[list[Row]] = []
    done: list[list[Row]] = []
    for reach in reaches:
        rows = [
            Row(reach.points_enu_m[arc], reach.yaw_enu_rad[arc], len(arc) == len(reach.accessible))
            for arc in arcs_of(reach)
        ]
        going_on: list[list[Row]] = []
        for row in rows:
            below = [chain for chain in open_chains if _above(row, chain[-1])]
            if below:
                chain = max(below, key=lambda chain: len(chain[-1].points_enu_m))
                chain.append(row)
                going_on.append(chain)
                open_chains.remove(chain)
            else:
                going_on.append([row])
        done += open_chains
        open_chains = going_on
    return done + open_chains


def _above(row: Row, below: Row) -> bool:
    """Whether the middle of the row below lies under this one."""
    middle = below.points_enu_m[len(below.points_enu_m) // 2, :2]
    return float(np.hypot(*(row.points_enu_m[:, :2] - middle).T).min()) < SAME_PLACE_M


def _parted(setting: Setting, rows: list[Row]) -> list[list[Row]]:
    """A chain's rows in chains that keep the clearance: the way on from a row to the next one may lead past a neighbour."""
    count = len(rows)
    while count > 1 and not (_is_clear(setting, rows[:count]) and _is_clear(setting, _turned(rows[:count]))):
        count -= 1
    return [rows] if count == len(rows) else [rows[:count], *_parted(setting, rows[count:])]


def _is_clear(setting: Setting, rows: list[Row]) -> bool:
    path, _ = meander(rows, smoothing_m=setting.pace.speed_mps)
    place = path(np.linspace(0.0, path.u_end_rad, SAMPLES))
    return bool(setting.everything.clear(place[:-1], np.diff(place, axis=0), setting.required_m).all())


def _candidate(setting: Setting, rows: list[Row], standoff_m: float) -> Candidate:
    def planned(name: str, start_enu_m: FloatArray) -> Piece:
        towards = _begun_nearer(rows, start_enu_m)
        path, gaze = meander(towards, smoothing_m=setting.pace.speed_mps)
        pace = setting.pace_at(standoff_m, np.inf)
        u = np.linspace(0.0, path.u_end_rad, SAMPLES)
        place, along, _, _ = path.jet(u)
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        pace = replace(pace, speed_mps=_stopping_mps(setting, place, along, pace.speed_mps))
        _, gaze = meander(towards, smoothing_m=pace.speed_mps)
        return Piece(
            name=name,
            kind="facade",
            path=path,
            gaze=gaze,
            rings=len(rows),
            harmonics=0,
            standoff_m=standoff_m,
            pace=pace,
        )

    middle = [row.points_enu_m[len(row.points_enu_m) // 2] for row in (rows[0], rows[-1])]
    return Candidate("facade", middle[0], middle[1], planned)


def _begun_nearer(rows: list[Row], start_enu_m: FloatArray) -> list[Row]:
    """The rows, the first of them begun at the end that is nearer."""
    first = rows[0]
    ends = np.hypot(*(first.points_enu_m[[0, -1], :2] - start_enu_m[:2]).T)
    if first.closed or ends[0] <= ends[1]:
        return rows
    return _turned(rows)


def _turned(rows: list[Row]) -> list[Row]:
    """The rows, the first of them begun at its other end."""
    first = rows[0]
    return [Row(first.points_enu_m[::-1], first.yaw_enu_rad[::-1], False), *rows[1:]]


def _stopping_mps(setting: Setting, place_enu_m: FloatArray, along: FloatArray, speed_mps: float) -> float:
    """The fastest speed from which, going straight on and braking, nothing is touched anywhere on the way."""
    least_m = setting.mission.vehicle.radius_m + STOPPING_MARGIN_M
    for share in np.linspace(1.0, 1.0 / SPEED_STEPS, SPEED_STEPS):
        run_on_m = setting.run_on_m(share * speed_mps)
        if setting.everything.distance_m(place_enu_m, run_on_m * along).min() >= least_m:
            return float(share * speed_mps)
    return speed_mps / SPEED_STEPS


def _told(setting: Setting, reaches: list[Reach]) -> tuple[str, ...]:
    """Each stretch of the lowest line that nobody can fly: where, which side of the building, how long, how high up."""
    if not reaches:
        return ()
    lowest = reaches[0]
    lines = []
    for run in _runs(~lowest.accessible):
        points = lowest.points_enu_m[run]
        length_m = float(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1)).sum())
        if length_m < SHORTEST_M:
            continue
        middle = points[len(points) // 2]
        outward = lowest.yaw_enu_rad[run][len(run) // 2] + np.pi
        side = COMPASS[int(np.round(outward / (np.pi / 4.0))) % 8]
        top_m = max(r.points_enu_m[0, 2] for r in reaches if not _reached(r, middle))
        place = setting.site.heights.frame.geo_point(middle)
        between = (
            f"from {middle[2]:.1f} to {top_m:.1f}" if top_m > middle[2] + SAME_ROW_M else f"{middle[2]:.1f}"
        )
        lines.append(
            f"no drone can pass the {side} side for {length_m:.0f} m about lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, "
            f"{between} m up: what else stands or rises there, or a keep-out, is too near for {setting.required_m:.1f} m of clearance"
        )
    return tuple(lines)


def _runs(mask: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """The runs of a ring's mask, in order."""
    if not mask.any():
        return []
    if mask.all():
        return [np.arange(len(mask))]
    order = np.roll(np.arange(len(mask)), -int(np.argmin(mask)))
    edges = np.flatnonzero(np.diff(mask[order].astype(np.int8), append=np.int8(0)))
    return [order[begin + 1 : end + 1] for begin, end in zip(edges[::2], edges[1::2], strict=True)]


def _reached(reach: Reach, place_enu_m: FloatArray) -> bool:
    """Whether a line can be flown where it is nearest to a place."""
    away = np.hypot(*(reach.points_enu_m[:, :2] - place_enu_m[:2]).T)
    return bool(reach.accessible[int(np.argmin(away))])
