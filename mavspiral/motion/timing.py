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
4. The fastest law so far is measured between its knots too, and stretched by the last per mille.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import astuple

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve import Path
from mavspiral.motion import kernels
from mavspiral.motion.law import TimeLaw
from mavspiral.motion.limits import Limits
from mavspiral.motion.sight import Sight
from mavspiral.motion.turn import Gaze, TurnGaze

__all__ = ["fastest_law"]

GRID_M = 0.15
GRID_ROWS = (1_000, 40_000)
KNOT_S = 0.02
KNOTS_PER_WINDOW = 25
WINDOW_IN_BENDS = 1.6
SHORTEST_WINDOW_S = 0.1
ROUNDS = 16
PATIENCE = 4  # rounds without a gain of
CLOSE = 1.001
FINE_STEPS_PER_KNOT = 8
MARGIN = 1 + 2e-5  # for what is finer still
BETWEEN_ROWS = 1.002
"""A gaze's peaks are sharp: between two rows pictures were seen to pass faster by 0.05 % at the most."""
STILL = 1e-6  # s/rad: a picture that hardly moves
NEARLY = 0.95
FINER = 81
_LEVEL = TurnGaze(0.0, 0.0)


def fastest_law(
    path: Path, gaze: Gaze, limits: Limits, *, sight: Sight | None = None, pitch: Gaze | None = None
) -> TimeLaw:
    """The time law from rest at u = 0 to rest at `path.u_end_rad`, near the fastest under `limits`.

    With a `sight`, and the camera's `pitch` unless it is level, also so slow that its pictures are sharp.

    Raises:
        ValueError: the curve stands still somewhere (p′ = 0), so that no law can pass.
    """
    table, du = _tabulated(path, gaze)
    bounds = np.array(astuple(limits))
    blur = np.zeros(0) if sight is None else _blur(table, du, gaze, pitch or _LEVEL, sight)
    law, ratios = min(_laws(table, du, limits, blur), key=lambda found: found[0].duration_s)
    between = _between(table, du, bounds, blur, law, ratios)
    return law.stretched(max(1.0, between, _turning(gaze, law, limits)) * MARGIN)


def _between(
    table: FloatArray, du: float, bounds: FloatArray, blur: FloatArray, law: TimeLaw, ratios: FloatArray
) -> float:
    """The greatest demand between knots, at which it is `ratios`; 0 where none can be above 1.

    Between two knots it rises above both by less than it changes from one to the other.
    """
    highest = np.maximum(ratios[:-1], ratios[1:]) + np.abs(np.diff(ratios))
    spans = np.flatnonzero(highest > 1.0)
    if not len(spans):
        return 0.0
    step_s = law.step_s / FINE_STEPS_PER_KNOT
    t_s = law.step_s * spans[:, None] + step_s * np.arange(-1, FINE_STEPS_PER_KNOT + 2)
    u, u1, u2, _ = law.derivatives(t_s.ravel())
    ratios = _demand(table, du, bounds, blur, step_s, u, u1, u2).reshape(t_s.shape)
    return float(ratios[:, 1:-1].max())  # the outer ones have neighbours in other spans


def _turning(gaze: Gaze, law: TimeLaw, limits: Limits) -> float:
    """How much slower a law must be for its yaw: between the rows of the table a gaze may turn and bend faster.

    A spline's peaks are sharp: where knots come near the greatest, it is looked at more finely about them.
    """

    def needed(u: FloatArray, u1: FloatArray, u2: FloatArray) -> FloatArray:
        _, slope, bend = gaze.jet(u)
        turn, bends = np.abs(slope * u1), np.abs(bend * u1**2 + slope * u2)
        slower: FloatArray = np.maximum(
            turn / limits.yaw_rate_radps, np.sqrt(bends / limits.yaw_acceleration_radps2)
        )
        return slower

    coarse = needed(law.phase_rad, law.phase_rate_radps, law.phase_acceleration_radps2)
    high = np.flatnonzero(coarse >= max(NEARLY, NEARLY * float(coarse.max())))
    if not len(high):
        return 0.0
    finer_s = law.step_s * (high[:, None] + np.linspace(-0.5, 0.5, FINER))
    return float(needed(*law.derivatives(finer_s.ravel())[:3]).max())


def _blur(table: FloatArray, du: float, gaze: Gaze, pitch: Gaze, sight: Sight) -> FloatArray:
    """At each row, 1/u̇ of the fastest way past it that leaves the picture sharp."""
    u = du * np.arange(len(table))
    passing = sight.passing(table[:, :3], gaze.jet(u)[:2], pitch.jet(u)[:2])
    return np.asarray(BETWEEN_ROWS * passing / sight.speed_mps)


def _demand(
    table: FloatArray,
    du: float,
    bounds: FloatArray,
    blur: FloatArray,
    dt: float,
    u: FloatArray,
    u1: FloatArray,
    u2: FloatArray,
) -> FloatArray:
    """How many times slower each knot would have to be passed, for limits and pictures."""
    ratios: FloatArray = kernels.demand(table, du, bounds, dt, u, u1, u2)
    if blur.size:
        ratios = np.maximum(ratios, u1 * np.interp(u, du * np.arange(len(blur)), blur))
    return ratios


def _laws(
    table: FloatArray, du: float, limits: Limits, blur: FloatArray
) -> Iterator[tuple[TimeLaw, FloatArray]]:
    """Laws within the limits at their knots, and how near to them; on the whole ever faster, until that no longer pays."""
    bounds = np.array(astuple(limits))
    caps = kernels.rate_caps(table, bounds)
    if blur.size:
        caps = np.minimum(caps, 1.0 / np.maximum(blur, STILL) ** 2)
    pace_m = np.linalg.norm(table[:, :3], axis=1)
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
        ratios = _demand(table, du, bounds, blur, step_s, u, u1, u2)
        worst = max(1.0, float(ratios.max()))
        law = TimeLaw(step_s, u, u1, u2).stretched(worst)
        yield law, ratios / worst
        durations_s.append(law.duration_s)
        before_s, lately_s = durations_s[:-PATIENCE], durations_s[-PATIENCE:]
        if worst <= CLOSE or (before_s and min(before_s) <= min(lately_s) * CLOSE):
            return
        slowness = kernels.adjusted(slowness, times_s, ratios, step_s, width)


def _window_s(table: FloatArray, length_m: float, limits: Limits) -> float:
    """The width of the mean.

    Full acceleration is built up in A/J. A straight line too short for that is flown best in four equal
    ramps; a bend has jerk of its own, and needs a share.
    """
    share = WINDOW_IN_BENDS if table[:, 3:9].any() else 1.0
    full_s = limits.acceleration_mps2 / limits.jerk_mps3
    quarter_s = math.cbrt(length_m / (2 * limits.jerk_mps3))
    return max(SHORTEST_WINDOW_S, min(share * full_s, quarter_s))


def _tabulated(path: Path, gaze: Gaze) -> tuple[FloatArray, float]:
    """Rows of p′, p″, p‴, ψ′, ψ″ over equal steps of u, and that step."""
    coarse = np.linspace(0.0, path.u_end_rad, GRID_ROWS[0])
    length_m = float(np.linalg.norm(path(coarse, 1), axis=1).mean() * path.u_end_rad)
    rows = int(np.clip(math.ceil(length_m / GRID_M), *GRID_ROWS))
    u = np.linspace(0.0, path.u_end_rad, rows)
    table = np.column_stack([*path.jet(u)[1:], *gaze.jet(u)[1:]])
    still = np.flatnonzero(~table[:, :3].any(axis=1))
    if still.size:
        raise ValueError(f"the curve stands still at u = {u[still[0]]:.6g}: no law can pass there")
    return table, float(u[1])
