"""What the estimator does at the horizon in one frame, as one kernel: `Ekf` does the same step by step.

Predict, then fuse what was measured at the frame's end. To the bit what `Ekf` makes of the same with its filter's kernels;
a test holds both equal.
"""

from __future__ import annotations

import numpy as np

from sitl.estimator.error_state import STATES, field_frd, predict_covariance, set_cross
from sitl.estimator.filters import gated_update
from sitl.estimator.observer import follow
from sitl.estimator.strapdown import HAS_BARO, HAS_FIX, HAS_MAG, PREDICT_S, RING, catch_up
from sitl.geo import ned_of_geodetic
from sitl.kernels import FloatArray, kernel

__all__ = [
    "ALONE_FRAMES",
    "BARO",
    "BARO_BIAS_TIME_S",
    "BOOK",
    "DEAD_RECKONING_FRAMES",
    "FIX_S",
    "MAG",
    "PLACE",
    "RESET_AFTER",
    "SHEET",
    "SPEED",
    "fuse_frame",
    "reset_to",
]

RESET_AFTER = 70  # fixes, 7 s: PX4's reset_timeout_max
BARO_BIAS_TIME_S = 30.0
FIX_S = 0.1
DEAD_RECKONING_FRAMES = 500  # PX4's EKF2_NOAID_TOUT, 5 s
ALONE_FRAMES = 100  # so long without fixes, and the height is the barometer's, which drifts

BOOK = np.dtype(
    [
        ("origin", "f8", 3),  # lat_deg, lon_deg, alt_amsl_m
        ("baro_bias_m", "f8"),
        ("baro_alt_m", "f8"),
        ("heights", "i8"),  # from which the barometer's offset was learnt
        ("rejected", "i8"),  # fixes in a row
        ("fix_frame", "i8"),  # of the last fix that was used
        ("aligning", "i8"),  # frames that were averaged
        ("sum", "f8", 9),  # specific force, rate, field
    ]
)
"""What the estimator remembers beside the filter."""

SHEET = np.dtype(
    [
        ("process_noise", "f8", STATES),
        ("fix_variance", "f8", 6),  # of place and speed
        ("baro_variance_m2", "f8"),
        ("baro_drift_m2", "f8"),
        ("mag_variance_gauss2", "f8"),
        ("field_ned_gauss", "f8", 3),
        ("gate", "f8", 4),  # in sigmas, by what is fused
        ("wander_m2", "f8", 3),  # the variance of the receiver's frame
        ("eph_max_m2", "f8"),
    ]
)
"""By what the estimator judges its senses."""

SPEED, PLACE, BARO, MAG = range(4)
"""What is fused, in this order."""


@kernel
def reset_to(navs: np.ndarray, P: FloatArray, variance: FloatArray, z: FloatArray) -> None:
    """Believe the fix `z`: position and velocity start anew from it, with its `variance`; both are (6,)."""
    for i in range(6):
        for j in range(STATES):
            P[i, j] = P[j, i] = 0.0
    for i in range(6):
        P[i, i] = variance[i]
        navs[0].pose[i] = z[i]


@kernel
def _take_fix(nav: np.record, book: np.record, work: np.record, slot: int) -> None:
    """Write place and speed of the fix in that slot into `work`."""
    origin, fix, ned = book.origin, nav.fix, work.fix_ned
    place = (fix[slot, 0], fix[slot, 1], fix[slot, 2])
    ned[0], ned[1], ned[2] = ned_of_geodetic((origin[0], origin[1], origin[2]), place)
    for i in range(3, 6):
        ned[i] = fix[slot, i]


@kernel
def _settle_fix(
    navs: np.ndarray, book: np.record, sheet: np.record, P: FloatArray, z: FloatArray, frame: int
) -> None:
    """Begin anew where too many fixes were refused in a row, and learn the barometer's offset.

    It is learnt from fixes, never from the filter, which would confirm itself.
    """
    if book.rejected >= RESET_AFTER:
        reset_to(navs, P, sheet.fix_variance, z)
        book.rejected, book.fix_frame = 0, frame
    heights: int = book.heights + 1
    book.heights = heights
    share = max(1.0 / heights, FIX_S / BARO_BIAS_TIME_S)
    book.baro_bias_m += share * (book.baro_alt_m - (book.origin[2] - z[2]) - book.baro_bias_m)


@kernel
def _look_at(
    kind: int, nav: np.record, book: np.record, sheet: np.record, work: np.record, slot: int
) -> None:
    """Write into `work` what was measured less what was expected, its Jacobian and its covariance."""
    m = 1 if kind == BARO else 3
    first = 2 if kind == BARO else 3 if kind == SPEED else 6 if kind == MAG else 0
    work.rows, work.first, work.last = m, first, first + m
    for a in range(m):
        for b in range(m):
            work.R[a, b], work.H[a, first + b] = 0.0, 1.0 if a == b else 0.0
        if kind in (SPEED, PLACE):
            work.residual[a] = work.fix_ned[first + a] - nav.pose[first + a]
            work.R[a, a] = sheet.fix_variance[first + a]
    if kind == BARO:
        book.baro_alt_m = nav.baro_alt_m[slot]
        work.residual[0] = nav.baro_alt_m[slot] - book.baro_bias_m - book.origin[2] + nav.pose[2]
        work.H[0, 2], work.R[0, 0] = -1.0, sheet.baro_variance_m2
    if kind == MAG:
        expected = field_frd(nav.q_ned_frd, sheet.field_ned_gauss)
        set_cross(work.H, expected)
        for a in range(3):
            work.residual[a], work.R[a, a] = nav.mag[slot, a] - expected[a], sheet.mag_variance_gauss2


@kernel
def fuse_frame(
    navs: np.ndarray,
    books: np.ndarray,
    sheets: np.ndarray,
    works: np.ndarray,
    x: FloatArray,
    P: FloatArray,
    frame: int,
    has: int,
) -> None:
    """One frame at the horizon of an estimator that runs: `frame` is the newest, `has` what was measured."""
    nav, book, sheet, work = navs[0], books[0], sheets[0], works[0]
    slot = (frame - nav.horizon_frames) % RING
    predict_covariance(P, work.FP, navs, sheet.process_noise, PREDICT_S)
    if not has:
        if nav.follows:
            follow(navs)
        return
    if has & HAS_FIX:
        _take_fix(nav, book, work, slot)
        if frame - book.fix_frame > ALONE_FRAMES:
            P[2, 2] += sheet.baro_drift_m2
    for kind in range(4):
        if not has & (HAS_BARO if kind == BARO else HAS_MAG if kind == MAG else HAS_FIX):
            continue
        _look_at(kind, nav, book, sheet, work, slot)
        accepted = gated_update(navs, x, P, works, sheet.gate[kind])
        if accepted and kind in (SPEED, PLACE):
            book.fix_frame = frame
        if kind == PLACE:
            book.rejected = 0 if accepted else book.rejected + 1
            _settle_fix(navs, book, sheet, P, work.fix_ned, frame)
    if nav.follows:
        follow(navs)
    else:
        catch_up(navs)
