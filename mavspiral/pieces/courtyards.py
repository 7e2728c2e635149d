"""The spirals inside courtyards, and which courtyards are too narrow for one.

A court behind a gate that no turn can pass is one too: it is entered from above.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.brief import band_m
from mavspiral.curve.court import plan_court
from mavspiral.curve.spiral import TOLERANCE_M
from mavspiral.errors import LimitError
from mavspiral.pieces.candidate import Candidate, Setting
from mavspiral.pieces.spirals import roof_standoff_m, spiral_piece
from mavspiral.shape.courts import Court, courts_of
from mavspiral.tour.passes import Piece

__all__ = ["courtyards_of"]

ROOM_M = 1.5
"""Half the width of a turn in the narrowest court that is flown."""
GATE_M = 1.5
"""Half the width of a gate that is shut for any drone, however narrow the court behind it."""
ROUNDING = 0.7
"""Of half the width of a turn, the radius of its corners at the most."""
FREE_SAMPLES = 2_000


def courtyards_of(setting: Setting) -> tuple[list[Candidate], tuple[str, ...]]:
    """A spiral inside each courtyard that is wide enough, and in words which are not.

    Where the stand-off does not fit, a nearer one is flown, down to what the clearance allows.
    """
    found: list[Candidate] = []
    told: list[str] = []
    least_m = setting.joinable_m + TOLERANCE_M
    shut_m = tuple(gate_m for gate_m in (GATE_M, least_m, setting.standoff_m) if gate_m <= setting.standoff_m)
    for court in courts_of(setting.solid, shut_m=shut_m, room_m=ROOM_M):
        standoff_m = min(setting.standoff_m, court.half_width_m - ROOM_M)
        if standoff_m < least_m:
            told.append(_too_narrow(setting, court, 2.0 * (least_m + ROOM_M)))
            continue
        radius_m = ROUNDING * (court.half_width_m - standoff_m)
        low_m, high_m = _band_m(setting, court, standoff_m)
        if court.rim_m + setting.half_m(standoff_m) <= low_m or low_m > court.rim_m:
            continue
        candidate = _candidate(setting, court, standoff_m, radius_m, low_m, high_m)
        try:
            trial = candidate.planned("courtyard", candidate.entry_enu_m)
        except LimitError as error:
            told.append(f"{_where(setting, court)}: not flown, {error}")
            continue
        free_m = _free_m(setting, trial)
        if free_m < setting.joinable_m - TOLERANCE_M:
            told.append(
                f"{_where(setting, court)}: not flown, something in it comes within {free_m:.1f} m of the turns"
            )
            continue
        found.append(candidate)
    return found, tuple(told)


def _candidate(
    setting: Setting, court: Court, standoff_m: float, radius_m: float, low_m: float, high_m: float
) -> Candidate:
    def planned(name: str, start_enu_m: FloatArray) -> Piece:
        pace = setting.pace_at(standoff_m, standoff_m)
        path = plan_court(
            replace(setting.solid, roof_ratio=standoff_m / roof_standoff_m(setting, standoff_m)),
            court,
            standoff_m=standoff_m,
            rise_m=setting.rise_m(standoff_m),
            bottom_m=low_m,
            top_m=high_m,
            corner_radius_m=min(radius_m, pace.speed_mps**2 / pace.acceleration_mps2),
            start_enu_m=start_enu_m[:2],
        )
        return spiral_piece(path, name, "courtyard", standoff_m, pace)

    return Candidate(
        "courtyard",
        np.array([*court.place_enu_m, low_m]),
        np.array([*court.place_enu_m, high_m]),
        planned,
    )


def _band_m(setting: Setting, court: Court, standoff_m: float) -> tuple[float, float]:
    """The lowest and the highest turn: safe above the floor, and so high that its walls are in the picture.

    What stands more than the stand-off above the lowest rim is seen from outside.
    """
    asked = setting.mission.inspection
    half_m = setting.half_m(standoff_m)
    bottom_m, top_m = band_m(setting.mission, setting.site, setting.camera)
    if asked.bottom_m is None:
        bottom_m = max(setting.mission.limits.clearance_m, half_m)
    low_m = max(bottom_m, court.floor_m + roof_standoff_m(setting, standoff_m)) if court.floor_m else bottom_m
    limit_m = top_m if asked.top_m is not None else setting.mission.limits.ceiling_m
    return low_m, max(low_m, min(limit_m, court.wall_m - half_m, court.rim_m + standoff_m))


def _free_m(setting: Setting, piece: Piece) -> float:
    """How near anything comes to the curve, neighbours and keep-outs among it."""
    u = np.linspace(0.0, piece.path.u_end_rad, FREE_SAMPLES)
    return float(setting.everything.distance_m(piece.path(u)).min())


def _where(setting: Setting, court: Court) -> str:
    place = setting.site.heights.frame.geo_point(np.array([*court.place_enu_m, court.floor_m]))
    return f"courtyard at lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}"


def _too_narrow(setting: Setting, court: Court, needed_m: float) -> str:
    return (
        f"{_where(setting, court)} is {2.0 * court.half_width_m:.1f} m wide, "
        f"{needed_m:.1f} m are needed for a turn inside with {setting.required_m:.1f} m of clearance: not flown"
    )
