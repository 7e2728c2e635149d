"""What jerk costs, and how long it takes to work out: `python tests/bench/bench_timing.py`.

`toppra` is the time of toppra's TOPP-RA under the same limits, jerk aside: |p″b + p′a| ≤ A is a disc in the plane of p′ and
p″, given to its seidel solver as a 128-gon about that disc, wider by 0.03 % at the most. `off` is ours without jerk against it.
"""

import runpy
import sys
import time
from dataclasses import astuple
from pathlib import Path

import numpy as np
import toppra

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral import load_mission, plan
from mavspiral.curve.line import LinePath
from mavspiral.motion import kernels
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg, Trajectory
from mavspiral.motion.turn import TurnGaze

trial = runpy.run_path(str(Path(__file__).parents[1] / "mavspiral" / "motion" / "conftest.py"))
FourierHelix, SwayingGaze = trial["FourierHelix"], trial["SwayingGaze"]
ROOT = Path(__file__).parents[2]
toppra.setup_logging("ERROR")
LIMITS = Limits(5.0, 2.0, 1.5, 2.0, 4.0, np.radians(45), np.radians(60))
ROUND, SHARP = {1: (30, 20), 3: (2.7, -1.8), 5: (-0.6, -0.4)}, {1: (30, 20), 3: (5.4, -3.6), 5: (-1.3, -0.9)}
CASES = {
    "spiral, 20 turns": (FourierHelix(20, ROUND), SwayingGaze()),
    "spiral, sharp corners": (FourierHelix(20, SHARP), SwayingGaze()),
    "spiral, small tower": (FourierHelix(20, {1: (12, 9), 3: (1, -0.8)}), SwayingGaze()),
    "line, 300 m": (LinePath([0, 0, 9], [300, 0, 9]), TurnGaze(0, 2)),
    "line, 8 m": (LinePath([0, 0, 9], [8, 0, 9]), TurnGaze(0, 0)),
    "line, 0.05 m": (LinePath([0, 0, 9], [0.05, 0, 9]), TurnGaze(0, 0)),
    "half a turn on 0.05 m": (LinePath([0, 0, 9], [0.05, 0, 9]), TurnGaze(0, 3)),
    "up 60 m": (LinePath([0, 0, 0], [0, 0, 60]), TurnGaze(0, 0)),
}


def without_jerk_s(path, gaze):
    u = np.linspace(0.0, path.u_end_rad, 20_000)
    table = np.column_stack([*(path(u, order) for order in (1, 2, 3)), gaze(u, 1), gaze(u, 2)])
    bounds = np.array(astuple(LIMITS))
    rates = kernels.fastest_rates(table, u[1], kernels.rate_caps(table, bounds), bounds, np.ones(len(u)))
    return kernels.time_grid(rates, u[1])[-1]


def toppra_s(path, gaze, rows=4_000):
    """toppra's time, and ours without jerk, on the same grid."""
    u = np.linspace(0.0, path.u_end_rad, rows)
    table = np.column_stack([*(path(u, order) for order in (1, 2, 3)), gaze(u, 1), gaze(u, 2)])
    pace = np.linalg.norm(table[:, :3], axis=1)
    along = (table[:, :3] * table[:, 3:6]).sum(axis=1) / pace
    bend = np.sqrt(np.maximum((table[:, 3:6] ** 2).sum(axis=1) - along**2, 0.0))
    angles = 2 * np.pi * np.arange(128) / 128
    faces = np.vstack([np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]), [0, 0, 1], [0, 0, -1]])
    bounds = np.array([LIMITS.acceleration_mps2] * 128 + [LIMITS.yaw_acceleration_radps2] * 2)
    with np.errstate(divide="ignore"):
        rise = np.where(table[:, 2] > 0, LIMITS.climb_mps, LIMITS.descent_mps) / table[:, 2]
        turn = LIMITS.yaw_rate_radps / table[:, 9]
    fastest = np.minimum((LIMITS.speed_mps / pace) ** 2, np.minimum(rise**2, turn**2))

    class Norms(toppra.constraint.LinearConstraint):
        def compute_constraint_params(self, path, gridpoints):
            first = np.column_stack([pace, 0 * pace, table[:, 9]])
            second = np.column_stack([along, bend, table[:, 10]])
            rest, squares = np.zeros((rows, 3)), np.column_stack([np.zeros(rows), fastest])
            return first, second, rest, np.array([faces] * rows), np.array([bounds] * rows), None, squares

    class Curve(toppra.interpolator.AbstractGeometricPath):
        path_interval = np.array([0.0, path.u_end_rad])
        dof = 3

        def __call__(self, positions, order=0):
            return path(positions, order)

    solver = toppra.algorithm.TOPPRA([Norms()], Curve(), gridpoints=u, solver_wrapper="seidel")
    _, theirs, _ = solver.compute_parameterization(0.0, 0.0)
    limits = np.array(astuple(LIMITS))
    ours = kernels.fastest_rates(table, u[1], kernels.rate_caps(table, limits), limits, np.ones(rows))
    return kernels.time_grid(np.asarray(theirs), u[1])[-1], kernels.time_grid(ours, u[1])[-1]


def planned(name):
    (part,) = plan(load_mission(ROOT / "missions" / f"{name}.toml")).passes
    return part.path, part.leg.gaze


def best_ms(work, times=5):
    took = []
    for _ in range(times):
        begin = time.perf_counter()
        work()
        took.append(time.perf_counter() - begin)
    return 1e3 * min(took)


def main():
    print(
        f"{'':24}{'length':>8}{'duration':>10}{'no jerk':>9}{'cost':>8}{'toppra':>10}{'off':>9}{'law':>9}{'50 Hz':>9}"
        "   worst at 1 kHz: v, a, j, yaw"
    )
    missions = {f"{name}, as planned": planned(name) for name in ("torre", "setbacks", "silo")}
    for name, (path, gaze) in (CASES | missions).items():
        law = fastest_law(path, gaze, LIMITS)
        flight = Trajectory((Leg("leg", path, gaze, law),))
        state = flight.sampled(0.001)
        worst = [
            np.linalg.norm(state.velocity_enu_mps, axis=1).max() / LIMITS.speed_mps,
            np.linalg.norm(state.acceleration_enu_mps2, axis=1).max() / LIMITS.acceleration_mps2,
            np.linalg.norm(state.jerk_enu_mps3, axis=1).max() / LIMITS.jerk_mps3,
            np.abs(state.yaw_rate_enu_radps).max() / LIMITS.yaw_rate_radps,
        ]
        length_m = np.linalg.norm(np.diff(state.position_enu_m, axis=0), axis=1).sum()
        without_s = without_jerk_s(path, gaze)
        theirs_s, ours_s = toppra_s(path, gaze)
        law_ms = best_ms(lambda path=path, gaze=gaze: fastest_law(path, gaze, LIMITS))
        table_ms = best_ms(lambda flight=flight: flight.sampled(0.02))
        print(
            f"{name:24}{length_m:6.0f} m{law.duration_s:8.2f} s{without_s:7.1f} s"
            f"{law.duration_s / without_s - 1:8.2%}{theirs_s:8.1f} s{ours_s / theirs_s - 1:9.3%}"
            f"{law_ms:6.1f} ms{table_ms:6.1f} ms   {' '.join(f'{ratio:.5f}' for ratio in worst)}"
        )


if __name__ == "__main__":
    main()
