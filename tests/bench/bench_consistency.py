"""The estimator's consistency over 100 seeds: mean NEES and NIS and their 95 % bounds. Prints one table.

PYTHONPATH=. python tests/bench/bench_consistency.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "sitl"))
from consistency import DOF, STATES, as_modelled, bounds, fly

from sitl.airframe import load_airframe

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


if __name__ == "__main__":
    main()
