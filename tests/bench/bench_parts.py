"""Planning of whole buildings, warm, by stage, in milliseconds; medians: `python tests/bench/bench_parts.py`."""

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral import load_mission, plan

STAGES = ("map", "curve", "timing", "transits", "certificate", "coverage")
MISSION = """
schema = 1
name = "bench"
[building]
map = "bench.npz"
cell_m = 0.25
map_error_m = 0.3
[camera]
focal_length_mm = 8.8
sensor_mm = [13.2, 8.8]
min_interval_s = 0.7
[inspection]
standoff_m = {standoff_m}
overlap = {overlap}
[limits]
clearance_m = 3.0
ceiling_m = 150
[vehicle]
endurance_s = 20000
"""


def block(size_m, *boxes):
    """A map of `size_m` east and north at 0.25 m; boxes are west, south, east, north, height."""
    heights = np.zeros((round(size_m[1] * 4), round(size_m[0] * 4)))
    for west, south, east, north, height in boxes:
        heights[round(south * 4) : round(north * 4), round(west * 4) : round(east * 4)] = height
    return heights


def tower_on(size_m):
    """A prismatic tower of 60 m in the middle of a map."""
    east, north = size_m[0] / 2, size_m[1] / 2
    return block(size_m, (east - 15, north - 10, east + 15, north + 10, 60.0))


PODIUM = ((160, 170, 240, 230, 12.0), (165, 185, 185, 215, 50.0), (215, 185, 235, 215, 40.0))
CASES = {
    "tower 60 m, 120 × 80 m": (tower_on((120, 80)), 8.0, 0.55),
    "the same, 240 × 160 m": (tower_on((240, 160)), 8.0, 0.55),
    "the same, 480 × 320 m": (tower_on((480, 320)), 8.0, 0.55),
    "podium, two towers, 400 × 400 m": (block((400, 400), *PODIUM), 10.0, 0.25),
}


ASKED_MS = {"tower 60 m, 120 × 80 m": 25, "podium, two towers, 400 × 400 m": 150, "torre": 150}
TORRE = Path(__file__).parents[2] / "missions" / "torre.toml"


def missions(folder):
    """The missions by name, each with its map in the folder; the torre is the gallery's own."""
    for number, (case, (heights, standoff_m, overlap)) in enumerate(CASES.items()):
        np.savez(folder / f"{number}.npz", height_agl_m=heights, cell_m=0.25, origin=[40.05, -1.93])
        text = MISSION.replace("bench.npz", f"{number}.npz").format(standoff_m=standoff_m, overlap=overlap)
        (folder / f"{number}.toml").write_text(text)
        yield case, load_mission(folder / f"{number}.toml")
    yield "torre", load_mission(TORRE)


def main(times=15):
    """Without coverage: the median and the least of the runs, for machines that others use too."""
    print(
        f"{'':32}{'cells':>10}{'turns':>7}{'parts':>7}{'without coverage':>18}{'least':>8}{'asked':>8}{'all':>8}   ",
        end="",
    )
    print("".join(f"{stage:>12}" for stage in STAGES))
    with tempfile.TemporaryDirectory() as name:
        for case, mission in missions(Path(name)):
            inspection = plan(mission)
            laps = []
            for _ in range(times):
                inspection = plan(mission)
                laps.append(inspection.planning_ms)
            stages = {stage: float(np.median([lap[stage] for lap in laps])) for stage in STAGES}
            without_ms = [lap["total"] - lap["coverage"] for lap in laps]
            turns = sum(part.rings for part in inspection.passes)
            asked = f"≤ {ASKED_MS[case]}" if case in ASKED_MS else ""
            print(
                f"{case:32}{inspection.site.heights.height_agl_m.size:10d}{turns:7d}{len(inspection.passes):7d}"
                f"{np.median(without_ms):18.1f}{min(without_ms):8.1f}{asked:>8}"
                f"{np.median([lap['total'] for lap in laps]):8.0f}   "
                f"{''.join(f'{stages[stage]:12.1f}' for stage in STAGES)}"
            )


if __name__ == "__main__":
    sys.exit(main())
