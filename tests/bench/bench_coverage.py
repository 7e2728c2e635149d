"""Sight, measured: 100 000 patches from 500 shots, one core, by its own time. `python tests/bench/bench_coverage.py`."""

import math
import sys
from pathlib import Path
from time import thread_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral import load_mission, plan
from mavspiral.frames import GeoPoint, LocalFrame
from mavspiral.shape.heightmap import HeightMap, Site
from mavspiral.survey.camera import Camera
from mavspiral.survey.coverage import Demand, measure_coverage
from mavspiral.survey.patches import patches_of
from mavspiral.survey.shots import Shots

CAMERA = Camera(0.0088, (0.0132, 0.0088), (5472, 3648), 0.0005, 0.7, True)
ROOT = Path(__file__).parents[2]


def tower(turn_deg):
    """A tower of 40 × 30 m and 178 m among neighbours on a 120 × 120 m map at 0.25 m, turned against the grid."""
    c = (np.arange(480) + 0.5) * 0.25 - 60
    east, north = np.meshgrid(c, c)
    turn = math.radians(turn_deg)
    a, b = east * math.cos(turn) + north * math.sin(turn), north * math.cos(turn) - east * math.sin(turn)
    own = (abs(a) < 20) & (abs(b) < 15)
    heights = np.where(own, 178.0, 0.0)
    heights[(abs(a) > 45) & (abs(b) < 20)] = 90.0
    return Site(HeightMap(heights, 0.25, LocalFrame(GeoPoint(19.4, -99.1, 0.0)), np.full(2, -60.0)), own)


def turns(standoff_m, shots_n):
    """A helix of 20 turns about the tower."""
    angle = np.linspace(0.0, 40 * np.pi, shots_n)
    place = np.stack([(20 + standoff_m) * np.cos(angle), (15 + standoff_m) * np.sin(angle)], axis=1)
    up_m = np.linspace(6.0, 172.0, shots_n)[:, None]
    return Shots(np.arange(shots_n), np.hstack([place, up_m]), angle + np.pi, np.zeros(shots_n))


def median_ms(work, times=7):
    work()
    taken = []
    for _ in range(times):
        begin = thread_time()
        work()
        taken.append(thread_time() - begin)
    return 1e3 * float(np.median(taken))


def main():
    print(f"{'':34}{'patches':>9}{'shots':>7}{'patches of':>12}{'sight':>9}   walls seen")
    for turn_deg, gsd_m in ((0, 0.005), (30, 0.005), (30, 0.020), (30, 0.100)):
        site, shots = tower(turn_deg), turns(12.0, 500)
        patches, demand = patches_of(site), Demand(gsd_m, math.radians(60), 1)
        found = measure_coverage(patches, shots, site, CAMERA, demand)
        print(
            f"tower at {turn_deg:2d}°, GSD up to {1e3 * gsd_m:3.0f} mm    {len(patches):12,d}{len(shots):7d}"
            f"{median_ms(lambda site=site: patches_of(site)):9.1f} ms"
            f"{median_ms(lambda a=(patches, shots, site, CAMERA, demand): measure_coverage(*a)):6.0f} ms"
            f"{found.walls:10.2%}"
        )
    for path in sorted((ROOT / "missions").glob("*.toml")):
        mission = load_mission(path)
        inspection = plan(mission)
        laps = [plan(mission).planning_ms["coverage"] for _ in range(5)]
        print(
            f"{mission.name:34}{len(inspection.coverage.patches):9,d}{len(inspection.shots):7d}"
            f"   coverage lap {np.median(laps):6.1f} ms{inspection.coverage.walls:10.2%}"
        )


if __name__ == "__main__":
    main()
