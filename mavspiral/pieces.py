"""What there is to fly around: every part of the building with its band of heights, each one smooth curve."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import band_m, demand_of
from mavspiral.curve.gaze import inward_gaze
from mavspiral.curve.paper import plan_paper
from mavspiral.curve.spiral import TOLERANCE_M, plan_spiral
from mavspiral.mission import Mission
from mavspiral.motion.limits import Limits
from mavspiral.order import quickest_order
from mavspiral.passes import Piece
from mavspiral.roofs import roof_pieces
from mavspiral.shape.heightmap import Site
from mavspiral.shape.parts import LeftOut, Part, parts_of
from mavspiral.shape.slicing import SolidDistance, solid_distance
from mavspiral.survey.camera import Camera
from mavspiral.transit import MARGIN_M

__all__ = ["Pieces", "pieces_of"]

PAPER_TERMS = 12
"""Harmonics of a ring in the paper's mode, unless [inspection] terms says otherwise."""
ROOF_GONE_M = 0.01
"""So much above its stand-off a roof has certainly dropped out of the slice."""


@dataclass(frozen=True, slots=True)
class Pieces:
    """The pieces in the order of flight, and what a pilot is told about them: what is left out, for the most part."""

    pieces: tuple[Piece, ...]
    told: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Band:
    """A part and the heights of its lowest and its highest turn."""

    part: Part
    bottom_m: float
    top_m: float

    def place_enu_m(self, height_m: float) -> FloatArray:
        return np.array([*self.part.anchor_enu_m, height_m])


def pieces_of(
    mission: Mission, site: Site, camera: Camera, pace: Limits, home_enu_m: FloatArray, required_m: float
) -> Pieces:
    """A spiral around each part of the building and what its roofs take, in the quickest order from home and back.

    Each spiral begins where it is nearest to where the one before ends.

    Raises:
        InputError: the mission on this map contradicts itself.
        LimitError: a curve cannot keep the clearance.
    """
    if mission.inspection.mode == "paper":
        return _as_the_paper_has_it(mission, site, camera, pace)
    standoff_m = mission.inspection.standoff_m
    corner_radius_m = pace.speed_mps**2 / pace.acceleration_mps2
    solid = solid_distance(site, reach_m=2.0 * standoff_m + corner_radius_m)
    bands, left_out = _bands(mission, site, camera, solid, required_m)
    order = quickest_order(
        np.array([band.place_enu_m(band.bottom_m) for band in bands]),
        np.array([band.place_enu_m(band.top_m) for band in bands]),
        home_enu_m,
        pace,
    )
    over_roofs = replace(solid, roof_ratio=standoff_m / _roof_standoff_m(standoff_m, required_m))
    pieces: list[Piece] = []
    here_enu_m = home_enu_m
    for band, name in zip([bands[i] for i in order], _names([bands[i].part for i in order]), strict=True):
        path = plan_spiral(
            solid if band.part.parent is None else over_roofs,
            band.part,
            standoff_m=standoff_m,
            rise_m=camera.rise_m(standoff_m, mission.inspection.overlap),
            bottom_m=band.bottom_m,
            top_m=band.top_m,
            clearance_m=mission.limits.clearance_m,
            corner_radius_m=corner_radius_m,
            start_enu_m=here_enu_m[:2],
        ).path
        gaze = inward_gaze(path, smoothing_m=pace.speed_mps)
        pieces.append(Piece(name, "spiral", path, gaze, path.rings, path.harmonics))
        here_enu_m = path(path.u_end_rad)
    roofs = _roofs(mission, site, camera, pace, home_enu_m, required_m)
    if not roofs:
        return Pieces(tuple(pieces), left_out)
    whole = [*pieces, *roofs]
    order = quickest_order(
        np.array([piece.path(0.0) for piece in whole]),
        np.array([piece.path(piece.path.u_end_rad) for piece in whole]),
        home_enu_m,
        pace,
    )
    return Pieces(tuple(whole[i] for i in order), left_out)


def _roofs(
    mission: Mission, site: Site, camera: Camera, pace: Limits, home_enu_m: FloatArray, required_m: float
) -> tuple[Piece, ...]:
    """The pieces above the roofs, if they are asked for and the camera can look down."""
    asked = mission.inspection
    if not (asked.roof and camera.gimbal):
        return ()
    return roof_pieces(
        site,
        camera,
        demand_of(mission),
        standoff_m=asked.standoff_m,
        overlap=asked.overlap,
        side_overlap=asked.side_overlap,
        required_m=required_m + MARGIN_M,
        pace=pace,
        start_enu_m=home_enu_m,
    )


def _as_the_paper_has_it(mission: Mission, site: Site, camera: Camera, pace: Limits) -> Pieces:
    """The largest contour of every slice, and nothing else."""
    asked = mission.inspection
    bottom_m, top_m = band_m(mission, site, camera)
    spiral = plan_paper(
        site,
        standoff_m=asked.standoff_m,
        rise_m=camera.rise_m(asked.standoff_m, asked.overlap),
        bottom_m=bottom_m,
        top_m=top_m,
        terms=asked.terms or PAPER_TERMS,
    )
    path = spiral.path
    gaze = inward_gaze(path, smoothing_m=pace.speed_mps)
    return Pieces((Piece("building", "spiral", path, gaze, path.rings, path.harmonics),), spiral.notices)


def _roof_standoff_m(standoff_m: float, required_m: float) -> float:
    """How far a spiral stays above the roof that its part stands on: less than the stand-off, which is for pictures.

    A curve that comes nearer than meant by its tolerance still has the clearance of a transit.
    """
    return min(standoff_m, (required_m + MARGIN_M + 0.1) * standoff_m / (standoff_m - TOLERANCE_M))


def _bands(
    mission: Mission, site: Site, camera: Camera, solid: SolidDistance, required_m: float
) -> tuple[list[_Band], tuple[str, ...]]:
    """Every part with its band, and what has none.

    A part goes as high as its own roof; one that others stand on, so high that theirs go on. They begin at the
    lowest height that is safe above the roof below them.
    """
    asked, standoff_m = mission.inspection, mission.inspection.standoff_m
    bottom_m, top_m = band_m(mission, site, camera)
    half_m = camera.footprint_m(standoff_m)[1] / 2
    rise_m = camera.rise_m(standoff_m, asked.overlap)
    above_m = _roof_standoff_m(standoff_m, required_m)
    limit_m = mission.limits.ceiling_m if asked.top_m is None else asked.top_m

    def lowest_m(base_m: float) -> float:
        return max(bottom_m, base_m + above_m + ROOF_GONE_M) if base_m > 0.0 else bottom_m

    def worth(base_m: float, part_top_m: float) -> bool:
        if base_m > 0.0:
            return lowest_m(base_m) <= min(part_top_m, limit_m)
        return part_top_m > bottom_m - half_m

    bands: list[_Band] = []
    left_out: list[str] = []
    for part in parts_of(solid, standoff_m=standoff_m, worth=worth):
        low_m = lowest_m(part.base_m)
        high_m = top_m
        if part.top_m < solid.levels_m[-1]:
            high_m = min(limit_m, part.top_m - half_m)
        if part.forks:
            high_m = min(limit_m, max(high_m, lowest_m(part.top_m) - rise_m))
        left_out += [_told(piece) for piece in part.left_out]
        if part.top_m + half_m > low_m:
            bands.append(_Band(part, low_m, max(low_m, high_m)))
    return bands, tuple(left_out)


def _names(parts: list[Part]) -> list[str]:
    """What each part is called, numbered in this order where there are several of a kind."""
    kinds = [_kind(part, alone=len(parts) == 1) for part in parts]
    count, seen = Counter(kinds), Counter[str]()
    names = []
    for kind in kinds:
        seen[kind] += 1
        names.append(kind if count[kind] == 1 else f"{kind} {seen[kind]}")
    return names


def _kind(part: Part, *, alone: bool) -> str:
    if alone:
        return "building"
    if part.forks:
        return "podium"
    return "block" if part.parent is None else "tower"


def _told(piece: LeftOut) -> str:
    west, south, east, north = piece.bounds_enu_m
    return (
        f"left out: a part of the building {piece.top_m:.1f} m high, east {west:.0f} to {east:.0f} m and "
        f"north {south:.0f} to {north:.0f} m of the origin, is not flown around above {piece.base_m:.1f} m"
    )
