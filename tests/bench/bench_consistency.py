"""The estimator's consistency over 100 seeds: mean NEES and NIS and their 95 % bounds. Prints one table.

python tests/bench/bench_consistency.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(0, str(Path(__file__).parents[1] / "sitl"))
from consistency import DISARMED, DOF, STATES, as_modelled, bounds, demand, error, fly

from sitl.airframe import load_airframe
from sitl.faults import parse_fault
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.vehicle import Vehicle, VehicleConfig

SEEDS = 100
X500 = load_airframe("x500")


def row(name: str, values: np.ndarray, span: tuple[float, float]) -> None:
    """Means over the seeds: of all looks, and at how many looks they lie inside."""
    at_look = values.mean(axis=0)
    inside = int(((at_look >= span[0]) & (at_look <= span[1])).sum())
    print(f"  {name:26} {values.mean():6.3f}   {span[0]:.2f} … {span[1]:.2f}   {inside} of {len(at_look)}")


def main() -> None:
    print(f"{SEEDS} seeds, by degrees of freedom          mean   bounds        looks inside")
    sets = {
        "as modelled": as_modelled(X500),
        "rtk, full senses": {"airframe": X500},
        "standard, full senses": {"airframe": X500, "gps": "standard"},
    }
    for name, config in sets.items():
        flights = [fly(seed=seed, **config) for seed in range(SEEDS)]
        modelled = name == "as modelled"
        nees = np.array([flown.nees for flown in flights])
        row(f"{name}: NEES", nees, bounds(STATES, SEEDS) if modelled else (0.7, 1.3))
        if modelled:
            for sense, dof in DOF.items():
                row(f"NIS of {sense}", np.array([f.nis[sense] for f in flights]), bounds(dof, SEEDS))
    drift()


def drift() -> None:
    """How far the estimate strays in 30 s of hover without a fix, and 3 s after, and whether it says so."""
    looks: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {at_s: [] for at_s in (40, 50, 60, 63)}
    for seed in range(SEEDS):
        loss = parse_fault("gps_loss@30s+30s")
        home = GeoPoint(19.4332, -99.1412, 2240.0)
        one = Vehicle(VehicleConfig(X500, Params(X500.params), home, seed=seed, faults=(loss,)))
        one.advance(3_000_000, DISARMED)
        for at_s, seen in looks.items():
            one.advance(at_s * 1_000_000, demand((0.0, 0.0, -10.0)))
            seen.append(error(one))
    print(
        "no fixes from 30 s to 60 s, hover, rtk: RMS and what is told (1 σ), m; mean NEES by degrees of freedom"
    )
    for at_s, seen in looks.items():
        nees = np.mean([e @ np.linalg.solve(P, e) for e, P in seen]) / STATES
        squares = np.mean([e * e for e, _ in seen], axis=0)
        told = np.mean([P.diagonal() for _, P in seen], axis=0)
        across, height = slice(0, 2), slice(2, 3)
        figures = [np.sqrt(values[axes].sum()) for axes in (across, height) for values in (squares, told)]
        print(f"  at {at_s} s: across {figures[0]:.3f} ({figures[1]:.3f}), height {figures[2]:.3f} ({figures[3]:.3f}), "
              f"NEES {nees:.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
