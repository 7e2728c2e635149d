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
   It is raised where the law asks too much within the window, and lowered where there is room.
4. The best law so far is stretched by the last per mille that its worst knot asks for.
"""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.motion import kernels
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.limits import Limits
from mavspiral.motion.turn import Gaze

__all__ = ["fastest_law"]

GRID_M = 0.15
GRID_ROWS = (1_000, 40_000)
KNOT_S = 0.02
KNOTS_PER_WINDOW = 25
ROUNDS = 16
GAIN = 0.7
GOOD_ENOUGH = 1.001


def fastest_law(path: Path, gaze: Gaze, limits: Limits) -> TimeLaw:
    """The time law from rest at u = 0 to rest at `path.u_end_rad`, near the fastest under `limits`.

    Raises:
        ValueError: the curve stands still somewhere (p′ = 0), so that no law can pass.
    """
    table, du, length_m = _tabulated(path, gaze)
    bounds = np.array(astuple(limits))
    caps = kernels.rate_caps(table, bounds)
    pace_m = np.sqrt(np.sum(table[:, :3] ** 2, axis=1))
    distance_m = np.concatenate([[0.0], np.cumsum(0.5 * (pace_m[1:] + pace_m[:-1])) * du])
    window_s = min(
        limits.acceleration_mps2 / limits.jerk_mps3,
        (distance_m[-1] / (2 * limits.jerk_mps3)) ** (1 / 3),
    )
    width = max(KNOTS_PER_WINDOW, math.ceil(window_s / KNOT_S))
    slowness = np.ones(len(table))
    laws: list[TimeLaw] = []
    for _ in range(ROUNDS):
        rates = kernels.fastest_rates(table, du, caps, bounds, slowness)
        rates = kernels.level_hills(rates * pace_m, distance_m, window_s) / pace_m
        times_s = kernels.time_grid(rates, du)
        steps = math.ceil(times_s[-1] / window_s * width)
        step_s = times_s[-1] / steps
        u, u1, u2 = kernels.knots(rates, times_s, steps, width, path.u_end_rad)
        ratios = kernels.demand(table, du, bounds, step_s, u, u1, u2)
        worst = float(ratios.max())
        laws.append(TimeLaw(step_s, u, u1, u2).stretched(max(1.0, worst)))
        if worst <= GOOD_ENOUGH:
            break
        slowness = kernels.slacken(slowness, times_s, ratios, steps, width, GAIN)
    return min(laws, key=lambda law: law.duration_s)


def _tabulated(path: Path, gaze: Gaze) -> tuple[FloatArray, float, float]:
    """Rows of p′, p″, p‴, ψ′, ψ″ over equal steps of u, and that step."""
    coarse = np.linspace(0.0, path.u_end_rad, GRID_ROWS[0])
    length_m = float(np.linalg.norm(path(coarse, 1), axis=1).mean() * path.u_end_rad)
    rows = int(np.clip(math.ceil(length_m / GRID_M), *GRID_ROWS))
    u = np.linspace(0.0, path.u_end_rad, rows)
    table = np.column_stack([*(path(u, order) for order in (1, 2, 3)), gaze(u, 1), gaze(u, 2)])
    still = np.flatnonzero(~table[:, :3].any(axis=1))
    if still.size:
        raise ValueError(f"the curve stands still at u = {u[still[0]]:.6g}: no law can pass there")
    return table, float(u[1]), length_m
