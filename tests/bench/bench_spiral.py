"""Median milliseconds by stage, from a site to a spiral: `python tests/bench/bench_spiral.py`."""

import sys
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral.curve.gaze import inward_gaze
from mavspiral.curve.spiral import plan_spiral
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.contour import ring
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.shape.parts import parts_of
from mavspiral.shape.slicing import solid_distance

BUILDINGS = {
    "prism": [(0, 0, 40, 20, 30)],
    "U": [(0, 0, 60, 12, 30), (0, 0, 12, 40, 30), (48, 0, 60, 40, 30)],
    "torre": [(0, 0, 40, 30, 20), (6, 4, 34, 26, 40), (10, 8, 30, 22, 60)],
    "corner tower": [(0, 0, 60, 40, 12), (0, 0, 12, 12, 50)],
    "court on podium": [(0, 0, 60, 40, 10), (0, 0, 60, 8, 40), (0, 0, 8, 40, 40), (52, 0, 60, 40, 40)],
}


NUMBERS = {"standoff_m": 12.0, "rise_m": 9.0, "bottom_m": 4.0, "clearance_m": 4.0, "corner_radius_m": 3.0}


def all_orders(path, u):
    return [path(u, order) for order in range(4)]


def site_of(boxes, cell_m=0.25):
    heights = np.zeros((round(40 / cell_m), round(60 / cell_m)))
    for west, south, east, north, height in boxes:
        rows = slice(round(south / cell_m), round(north / cell_m))
        heights[rows, round(west / cell_m) : round(east / cell_m)] = height
    frame = LocalFrame(GeoPoint(19.4339, -99.1406, 2240.0))
    return Site(HeightMap(heights, cell_m, frame, np.zeros(2)), heights > 0.0)


def median_ms(work, times=15):
    work()
    taken = []
    for _ in range(times):
        begin = perf_counter()
        work()
        taken.append(perf_counter() - begin)
    return 1e3 * float(np.median(taken))


def main():
    stages = ["distance", "part", "ring", "spiral", "gaze", "evaluate"]
    print(f"{'':16}{''.join(f'{stage:>10}' for stage in stages)}  N outlines rings clearance")
    for name, boxes in BUILDINGS.items():
        site, top_m = site_of(boxes), float(max(box[4] for box in boxes))
        solid = solid_distance(site, reach_m=27.0)
        parts = partial(parts_of, solid, standoff_m=12.0, worth=lambda base_m, top_m: False)
        (part,), cut = parts(), solid.slice(5.0, 12.0)
        plan = partial(plan_spiral, solid, part, top_m=top_m - 1.0, **NUMBERS)
        planned = plan()
        u = np.linspace(0.0, planned.path.u_end_rad, 20_000)
        work = [
            partial(solid_distance, site, reach_m=27.0),
            parts,
            partial(ring, solid, cut, anchor_enu_m=part.anchor_enu_m, corner_radius_m=3.0),
            plan,
            partial(inward_gaze, planned.path, smoothing_m=4.0),
            partial(all_orders, planned.path, u),
        ]
        figures = [median_ms(stage) for stage in work]
        path = planned.path
        print(
            f"{name:16}{''.join(f'{figure:10.2f}' for figure in figures)}"
            f" {path.harmonics:2d} {len(path.coefficients_m):8d}"
            f" {path.rings:5d} {planned.clearance_min_m:9.2f}"
        )


if __name__ == "__main__":
    main()
