"""What the estimator does at the horizon in one frame, as one kernel: `Ekf` does the same step by step.

Predict, then fuse what was measured at the frame's end. To the bit what `Ekf` makes of the same with its filter's kernels;
a test holds both equal.
"""

from __future__ import annotations

import numpy as np

from sitl.estimator.error_state import STATES, mag_expected, mag_jacobian, predict_covariance
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
def _fix_ned(nav: np.record, book: np.record, slot: int) -> FloatArray:
    """Place and speed of the fix in that slot."""
    origin, fix = book.origin, nav.fix[slot]
    ned = ned_of_geodetic((origin[0], origin[1], origin[2]), (fix[0], fix[1], fix[2]))
    return np.array([ned[0], ned[1], ned[2], fix[3], fix[4], fix[5]])


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
def _measured(
    nav: np.record, book: np.record, sheet: np.record, fix: FloatArray, kind: int, slot: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """What was measured, what was expected, the Jacobian and the covariance."""
    if kind == MAG:
        expected = mag_expected(nav.q_ned_frd, sheet.field_ned_gauss)
        H = mag_jacobian(nav.q_ned_frd, sheet.field_ned_gauss)
        return nav.mag[slot].copy(), expected, H, sheet.mag_variance_gauss2 * np.eye(3)
    n, first = 1 if kind == BARO else 3, 3 if kind == SPEED else 0
    z, expected, H, R = np.empty(n), np.empty(n), np.zeros((n, STATES)), np.zeros((n, n))
    if kind == BARO:
        z[0] = nav.baro_alt_m[slot] - book.baro_bias_m - book.origin[2]
        expected[0], H[0, 2], R[0, 0] = -nav.pose[2], -1.0, sheet.baro_variance_m2
        return z, expected, H, R
    for i in range(3):
        z[i], expected[i], H[i, first + i] = fix[first + i], nav.pose[first + i], 1.0
        R[i, i] = sheet.fix_variance[first + i]
    return z, expected, H, R


@kernel
def fuse_frame(
    navs: np.ndarray,
    books: np.ndarray,
    sheets: np.ndarray,
    x: FloatArray,
    P: FloatArray,
    work: FloatArray,
    frame: int,
    has: int,
) -> None:
    """One frame at the horizon of an estimator that runs: `frame` is the newest, `has` what was measured."""
    nav, book, sheet = navs[0], books[0], sheets[0]
    slot = (frame - nav.horizon_frames) % RING
    predict_covariance(P, work, navs, sheet.process_noise, PREDICT_S)
    if not has:
        if nav.follows:
            follow(navs)
        return
    fix = _fix_ned(nav, book, slot) if has & HAS_FIX else np.empty(0)
    if has & HAS_FIX and frame - book.fix_frame > ALONE_FRAMES:
        P[2, 2] += sheet.baro_drift_m2
    for kind in range(4):
        if not has & (HAS_BARO if kind == BARO else HAS_MAG if kind == MAG else HAS_FIX):
            continue
        if kind == BARO:
            book.baro_alt_m = nav.baro_alt_m[slot]
        z, expected, H, R = _measured(nav, book, sheet, fix, kind, slot)
        accepted = gated_update(navs, x, P, z, expected, H, R, sheet.gate[kind])
        if accepted and kind in (SPEED, PLACE):
            book.fix_frame = frame
        if kind == PLACE:
            book.rejected = 0 if accepted else book.rejected + 1
            _settle_fix(navs, book, sheet, P, fix, frame)
    if nav.follows:
        follow(navs)
    else:
        catch_up(navs)
