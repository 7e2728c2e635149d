"""What there is to fly along on a site, each piece one smooth curve, in the quickest order."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import band_m, demand_of
from mavspiral.curve.paper import plan_paper
from mavspiral.mission import Mission
from mavspiral.motion.limits import Limits
from mavspiral.pieces.candidate import Setting
from mavspiral.pieces.courtyards import courtyards_of
from mavspiral.pieces.roof_ways import RoofLook
from mavspiral.pieces.roofs import roof_pieces
from mavspiral.pieces.spirals import spiral_piece, spirals_of
from mavspiral.shape.heightmap import Site
from mavspiral.shape.slicing import obstacle_distance, solid_distance
from mavspiral.survey.camera import Camera
from mavspiral.tour.begins import begun_where_ways_are_short
from mavspiral.tour.order import quickest_order
from mavspiral.tour.passes import Piece
from mavspiral.tour.transit import MARGIN_M, Ways

__all__ = ["Pieces", "pieces_of"]

PAPER_TERMS = 12
"""Harmonics of a ring in the paper's mode, unless [inspection] terms says otherwise."""


@dataclass(frozen=True, slots=True)
class Pieces:
    """The pieces in the order of flight, and what a pilot is told about them: what is left out, for the most part."""

    pieces: tuple[Piece, ...]
    told: tuple[str, ...]


def pieces_of(
    mission: Mission,
    site: Site,
    camera: Camera,
    pace: Limits,
    home_enu_m: FloatArray,
    ways: Ways,
) -> Pieces:
    """Spirals around the parts of the building and inside its courtyards, in the quickest order from home and back.

    Spirals begin where the ways to them, between them and back are short.

    Raises:
        InputError: the mission on this map contradicts itself.
        LimitError: a curve cannot keep the clearance.
    """
    asked = mission.inspection
    if asked.mode == "paper":
        return _as_the_paper_has_it(mission, site, camera, pace)
    reach_m = 2.0 * asked.standoff_m + pace.speed_mps**2 / pace.acceleration_mps2
    solid = solid_distance(site, reach_m=reach_m)
    others = obstacle_distance(site, solid)
    setting = Setting(
        mission=mission,
        site=site,
        camera=camera,
        pace=pace,
        required_m=ways.clearance_m,
        solid=solid,
        others=others,
        everything=ways.solids,
    )
    candidates, told = spirals_of(setting)
    if asked.courtyards:
        inner, narrow = courtyards_of(setting)
        candidates, told = candidates + inner, told + narrow
    entries = np.array([candidate.entry_enu_m for candidate in candidates])
    exits = np.array([candidate.exit_enu_m for candidate in candidates])
    ordered = [candidates[index] for index in quickest_order(entries, exits, home_enu_m, pace)]
    pieces: list[Piece] = []
    here_enu_m = home_enu_m
    for candidate, name in zip(ordered, _names([candidate.word for candidate in ordered]), strict=True):
        piece = candidate.planned(name, here_enu_m)
        pieces.append(piece)
        here_enu_m = piece.path(piece.path.u_end_rad)
    roofs = _roofs(setting, home_enu_m)
    if not roofs:
        return Pieces(begun_where_ways_are_short(pieces, home_enu_m, ways), told)
    whole = [*pieces, *roofs]
    order = quickest_order(
        np.array([piece.path(0.0) for piece in whole]),
        np.array([piece.path(piece.path.u_end_rad) for piece in whole]),
        home_enu_m,
        pace,
    )
    return Pieces(begun_where_ways_are_short([whole[i] for i in order], home_enu_m, ways), told)


def _roofs(setting: Setting, home_enu_m: FloatArray) -> tuple[Piece, ...]:
    """The pieces above the roofs, if they are asked for and the camera can look down."""
    asked = setting.mission.inspection
    if not (asked.roof and setting.camera.gimbal):
        return ()
    look = RoofLook.of(
        setting.camera,
        demand_of(setting.mission),
        standoff_m=asked.standoff_m,
        overlap=asked.overlap,
        side_overlap=asked.side_overlap,
        required_m=setting.required_m + MARGIN_M,
    )
    return roof_pieces(setting.site, look, setting.pace, start_enu_m=home_enu_m)


def _names(words: list[str]) -> list[str]:
    """Each word, numbered where there are several of it."""
    count, seen = Counter(words), Counter[str]()
    names = []
    for word in words:
        seen[word] += 1
        names.append(word if count[word] == 1 else f"{word} {seen[word]}")
    return names


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
    piece = spiral_piece(spiral.path, "building", "spiral", asked.standoff_m, pace)
    return Pieces((piece,), spiral.notices)
