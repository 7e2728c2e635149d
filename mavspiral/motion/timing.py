"""The fastest time law along a curve, under limits on speed, acceleration, jerk and yaw.

1. *Without jerk* the problem is convex in b = u̇² and a = ü. At every grid point the pairs (b, a) with

       |p″b + p′a| ≤ A,   |ψ″b + ψ′a| ≤ α,   b ≤ β

   are a convex set about the origin, and b_{i+1} = b_i + 2·a_i·Δ along the grid. One pass backwards
   finds the largest controllable b, one pass forwards takes the largest a that stays below it
   (TOPP-RA: Pham & Pham, IEEE T-RO 34(3), 2018, here with the cone of the norm solved in closed form).
2. *Jerk.* The running mean of u̇ over a window T = A/J turns each step of acceleration into a ramp of
   slope J. That is the optimal S-curve of a straight line if the top of each hill of speed takes at
   least T to cross, so hills are levelled first. The mean is C² by construction.
3. *What a line does not show* (curvature under the mean, steps that add up) is measured. Each stretch
   of the curve has a slowness σ ≥ 1: its speed and acceleration are allowed σ⁻¹ and σ⁻² of the limits.
   It is raised where the law asks too much within the window, and lowered, with care, where there is room.
4. The fastest law so far is measured on the curve itself (`measured`), and stretched by the last per mille.
"""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.curve.gaze import GIMBAL_RADPS
from mavspiral.motion import kernels
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.limits import Limits
from mavspiral.motion.measured import slower
from mavspiral.motion.sight import Sight
from mavspiral.motion.turn import LEVEL, Gaze

__all__ = ["fastest_law"]

GRIDS_M = (0.3, 0.05)
"""Rows are so far apart, or finer where the coarser ones overlook more than"""
OVERLOOKED = 1.003
GRID_ROWS = (1_000, 40_000)
KNOT_S = 0.04
KNOTS_PER_WINDOW = 20
WINDOW_IN_BENDS = 1.6
SHORTEST_WINDOW_S = 0.1
ROUNDS = 16
PATIENCE = 4  # rounds without a gain of
CLOSE = 1.001
MARGIN = 1 + 2e-5  # for what is finer than is looked at
STILL = 1e-6  # s/rad: a picture that hardly moves


def fastest_law(
    path: Path, gaze: Gaze, limits: Limits, *, sight: Sight | None = None, pitch: Gaze = LEVEL
) -> TimeLaw:
    """The time law from rest at u = 0 to rest at `path.u_end_rad`, near the fastest under `limits`.

    Also so slow that the gimbal can follow the camera's `pitch`, and with a `sight` that its pictures are sharp.

    Raises:
        ValueError: the curve stands still somewhere (p′ = 0), so that no law can pass.
    """
    found: list[TimeLaw] = []
    for grid_m in GRIDS_M:
        table, du = _tabulated(path, gaze, grid_m)
        blur = _blur(table, du, gaze, pitch, sight)
        law = _quickest(table, du, limits, blur)
        overlooked = slower(path, gaze, law, limits, pitch, sight)
        found.append(law.stretched(max(1.0, overlooked) * MARGIN))
        if overlooked <= OVERLOOKED:
            break
    return min(found, key=lambda law: law.duration_s)


def _blur(table: FloatArray, du: float, gaze: Gaze, pitch: Gaze, sight: Sight | None) -> FloatArray:
    """At each row, 1/u̇ of the fastest way past it that the gimbal follows and that leaves the picture sharp."""
    u = du * np.arange(len(table))
    tilt = pitch.jet(u)
    turning: FloatArray = np.abs(tilt[1]) / GIMBAL_RADPS
    if sight is None:
        return turning if turning.any() else np.zeros(0)
    return np.maximum(turning, sight.passing(table[:, :3], gaze.jet(u)[:2], tilt[:2]) / sight.speed_mps)


def _quickest(table: FloatArray, du: float, limits: Limits, blur: FloatArray) -> TimeLaw:
    """The fastest of laws within the limits at their knots, on the whole ever faster, until that no longer pays."""
    bounds = np.array(astuple(limits))
    caps = kernels.rate_caps(table, bounds)
    if blur.size:
        caps = np.minimum(caps, 1.0 / np.maximum(blur, STILL) ** 2)
    pace_m = np.sqrt(np.einsum("ij,ij->i", table[:, :3], table[:, :3]))
    distance_m = np.concatenate([[0.0], np.cumsum(0.5 * (pace_m[1:] + pace_m[:-1])) * du])
    window_s = _window_s(table, float(distance_m[-1]), limits)
    width = max(KNOTS_PER_WINDOW, math.ceil(window_s / KNOT_S))
    slowness = np.ones(len(table))
    durations_s: list[float] = []
    for _ in range(ROUNDS):
        rates = kernels.fastest_rates(table, du, caps, bounds, slowness)
        rates = kernels.level_hills(rates * pace_m, distance_m, window_s) / pace_m
        times_s = kernels.time_grid(rates, du)
        steps = max(2, math.floor(times_s[-1] / window_s * width))
        step_s = float(times_s[-1]) / steps
        u, u1, u2 = kernels.knots(rates, times_s, steps, width, du * (len(table) - 1))
        ratios = kernels.demand(table, du, bounds, blur, step_s, u, u1, u2)
        worst = max(1.0, float(ratios.max()))
        durations_s.append(step_s * worst * (len(u) - 1))
        if durations_s[-1] == min(durations_s):
            best = step_s, u, u1, u2, worst
        before_s, lately_s = durations_s[:-PATIENCE], durations_s[-PATIENCE:]
        if worst <= CLOSE or (before_s and min(before_s) <= min(lately_s) * CLOSE):
            break
        slowness = kernels.adjusted(slowness, times_s, ratios, step_s, width)
    *law, worst = best
    return TimeLaw(*law).stretched(worst)


def _window_s(table: FloatArray, length_m: float, limits: Limits) -> float:
    """The width of the mean.

    Full acceleration is built up in A/J. A straight line too short for that is flown best in four equal
    ramps; a bend has jerk of its own, and needs a share.
    """
    share = WINDOW_IN_BENDS if table[:, 3:9].any() else 1.0
    full_s = limits.acceleration_mps2 / limits.jerk_mps3
    quarter_s = math.cbrt(length_m / (2 * limits.jerk_mps3))
    return max(SHORTEST_WINDOW_S, min(share * full_s, quarter_s))


def _tabulated(path: Path, gaze: Gaze, grid_m: float) -> tuple[FloatArray, float]:
    """Rows of p′, p″, p‴, ψ′, ψ″ over equal steps of u, and that step."""
    coarse = np.linspace(0.0, path.u_end_rad, GRID_ROWS[0])
    length_m = float(np.linalg.norm(path(coarse, 1), axis=1).mean() * path.u_end_rad)
    rows = int(np.clip(math.ceil(length_m / grid_m), *GRID_ROWS))
    u = np.linspace(0.0, path.u_end_rad, rows)
    table = np.column_stack([*path.jet(u)[1:], *gaze.jet(u)[1:]])
    still = np.flatnonzero(~table[:, :3].any(axis=1))
    if still.size:
        raise ValueError(f"the curve stands still at u = {u[still[0]]:.6g}: no law can pass there")
    return table, float(u[1])
