"""The spirals round the parts of a building: which parts, between which heights."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import band_m
from mavspiral.curve.gaze import inward_gaze
from mavspiral.curve.paper import PaperPath
from mavspiral.curve.spiral import TOLERANCE_M, SpiralPath, TooNearError, plan_spiral
from mavspiral.errors import LimitError
from mavspiral.motion.limits import Limits
from mavspiral.pieces.candidate import Candidate, Setting
from mavspiral.pieces.facades import facades_of, hemmed_in
from mavspiral.shape.parts import LeftOut, Part, parts_of
from mavspiral.tour.passes import Kind, Piece

__all__ = ["roof_standoff_m", "spiral_piece", "spirals_of"]

FREE_SAMPLES = 4_000
FREE_MARGIN_M = 0.1
ROOF_GONE_M = 0.01
"""So much above its stand-off a roof has certainly dropped out of the slice."""


@dataclass(frozen=True, slots=True, eq=False)
class _Band:
    """A part and the heights of its lowest and its highest turn."""

    part: Part
    bottom_m: float
    top_m: float

    def place_enu_m(self, height_m: float) -> FloatArray:
        return np.array([*self.part.anchor_enu_m, height_m])


def spirals_of(setting: Setting) -> tuple[list[Candidate], tuple[str, ...]]:
    """A spiral around each part, façades to and fro where something stands too near for that, and in words what has none.

    Raises:
        LimitError: nothing of the building can be flown along.
    """
    bands, told = _bands(setting)
    if not bands:
        bottom_m, _ = band_m(setting.mission, setting.site, setting.camera)
        top_m = setting.site.building_top_m
        raise LimitError(
            f"[inspection] the lowest turn at {bottom_m:g} m (bottom_m) is too high above the building, which ends at "
            f"{top_m:g} m, for any turn {setting.standoff_m:g} m from it. Fix: bottom_m = {top_m:g} or less"
        )
    alone = len(bands) == 1
    candidates: list[Candidate] = []
    for band in bands:
        word = "building" if alone else _word(band.part)
        if setting.others is None or _is_free(setting, band):
            candidates.append(_candidate(setting, band, word))
            continue
        facades = facades_of(setting, setting.others, band.part, band.bottom_m, band.top_m)
        candidates += facades.candidates
        told += facades.told
        if facades.free_from_m is not None:
            above = replace(band, bottom_m=facades.free_from_m, top_m=max(band.top_m, facades.free_from_m))
            candidates.append(_candidate(setting, above, word))
    if not candidates and setting.others is not None:
        raise LimitError(hemmed_in(setting, setting.others, bands[0].bottom_m))
    return candidates, told


def _candidate(setting: Setting, band: _Band, word: str) -> Candidate:
    return Candidate(
        word,
        band.place_enu_m(band.bottom_m),
        band.place_enu_m(band.top_m),
        lambda name, start_enu_m: _piece(setting, band, name, start_enu_m),
    )


def spiral_piece(
    path: SpiralPath | PaperPath, name: str, kind: Kind, standoff_m: float, pace: Limits
) -> Piece:
    """The piece that is flown along a spiral, looking to its left, where the walls are."""
    return Piece(
        name=name,
        kind=kind,
        path=path,
        gaze=inward_gaze(path, smoothing_m=pace.speed_mps),
        rings=path.rings,
        harmonics=path.harmonics,
        standoff_m=standoff_m,
        pace=pace,
    )


def _is_free(setting: Setting, band: _Band) -> bool:
    """Whether nothing comes too near to the spiral all the way round."""
    path = _piece(setting, band, "trial", band.place_enu_m(band.bottom_m)).path
    place = path(np.linspace(0.0, path.u_end_rad, FREE_SAMPLES))
    return bool((setting.everything.distance_m(place) >= setting.required_m + FREE_MARGIN_M).all())


def roof_standoff_m(setting: Setting, standoff_m: float) -> float:
    """How far a curve stays above a roof below it: less than the stand-off, which is for pictures.

    A curve that comes nearer than meant by its tolerance can still be joined by a transit.
    """
    return min(standoff_m, setting.joinable_m * standoff_m / (standoff_m - TOLERANCE_M)) + ROOF_GONE_M


def _piece(setting: Setting, band: _Band, name: str, start_enu_m: FloatArray) -> Piece:
    standoff_m, pace = setting.standoff_m, setting.pace
    over_roofs_m = roof_standoff_m(setting, standoff_m) - ROOF_GONE_M
    solid = setting.solid
    if band.part.parent is not None:
        solid = replace(solid, roof_ratio=standoff_m / over_roofs_m)
    try:
        path = plan_spiral(
            solid,
            band.part,
            standoff_m=standoff_m,
            rise_m=setting.rise_m(standoff_m),
            bottom_m=band.bottom_m,
            top_m=band.top_m,
            clearance_m=setting.mission.limits.clearance_m,
            corner_radius_m=setting.corner_radius_m,
            start_enu_m=start_enu_m[:2],
        ).path
    except TooNearError as error:
        raise LimitError(_too_near(setting, error)) from error
    return spiral_piece(path, name, "spiral", standoff_m, pace)


def _too_near(setting: Setting, error: TooNearError) -> str:
    place = setting.site.heights.frame.geo_point(error.place_enu_m)
    return (
        f"the spiral comes within {error.nearest_m:.2f} m of the building at lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, "
        f"{error.place_enu_m[2]:.1f} m up, and {error.required_m:.2f} m are wanted at standoff_m = {setting.standoff_m:g}. "
        f"Fix: a lower [limits] speed_mps (now {setting.pace.speed_mps:.3g}), whose turns are tighter, or a larger standoff_m"
    )


def _bands(setting: Setting) -> tuple[list[_Band], tuple[str, ...]]:
    """Every part with its band, and what has none.

    A part goes as high as its own roof; one that others stand on, so high that theirs go on. They begin at the
    lowest height that is safe above the roof below them.
    """
    mission, standoff_m = setting.mission, setting.standoff_m
    asked = mission.inspection
    bottom_m, top_m = band_m(mission, setting.site, setting.camera)
    half_m, rise_m = setting.half_m(standoff_m), setting.rise_m(standoff_m)
    above_m = roof_standoff_m(setting, standoff_m)
    limit_m = mission.limits.ceiling_m if asked.top_m is None else asked.top_m

    def lowest_m(base_m: float) -> float:
        return max(bottom_m, base_m + above_m) if base_m > 0.0 else bottom_m

    def worth(base_m: float, part_top_m: float) -> bool:
        if base_m > 0.0:
            return lowest_m(base_m) <= min(part_top_m, limit_m)
        return part_top_m > bottom_m - half_m

    bands: list[_Band] = []
    left_out: list[str] = []
    for part in parts_of(setting.solid, standoff_m=standoff_m, worth=worth):
        low_m = lowest_m(part.base_m)
        high_m = top_m
        if part.top_m < setting.solid.levels_m[-1]:
            high_m = min(limit_m, part.top_m - half_m)
        if part.forks:
            high_m = min(limit_m, max(high_m, lowest_m(part.top_m) - rise_m))
        left_out += [_told(setting, piece) for piece in part.left_out]
        if part.top_m + half_m > low_m:
            bands.append(_Band(part, low_m, max(low_m, high_m)))
    return bands, tuple(left_out)


def _word(part: Part) -> str:
    if part.forks:
        return "podium"
    return "block" if part.parent is None else "tower"


def _told(setting: Setting, piece: LeftOut) -> str:
    west, south, east, north = piece.bounds_enu_m
    middle = np.array([0.5 * (west + east), 0.5 * (south + north), piece.top_m])
    place = setting.site.heights.frame.geo_point(middle)
    return (
        f"left out: a part of the building {piece.top_m:.1f} m high, east {west:.0f} to {east:.0f} m and "
        f"north {south:.0f} to {north:.0f} m of the origin (lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}), "
        f"is not flown around above {piece.base_m:.1f} m, where what is left of it is too low for a spiral of its own"
    )
