"""How long each reader takes for the same building: `python tests/bench/bench_readers.py [CELL_M]`.

A podium with a tower and a neighbour, written in every format; processor time, the best of five. What the reader
allocates at its peak, beyond what was there before, is that of Python and numpy.
"""

from __future__ import annotations

import runpy
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from mavspiral.shape.readers import MapRequest, read_site

trial = runpy.run_path(str(Path(__file__).parents[1] / "mavspiral" / "shape" / "conftest.py"))
MESH = {"units": "m", "up": "z"}
FORMATS = {
    "GeoJSON": ("geojson", {}, {}),
    "npz": ("npz", {}, {}),
    "CityJSON": ("cityjson", {}, {}),
    "CityJSONSeq": ("cityjson_lines", {}, {}),
    "GeoTIFF": ("geotiff", {}, {}),
    "STL": ("stl", {}, MESH),
    "OBJ": ("obj", {}, MESH),
    "PLY": ("ply", {}, MESH),
    "LAS": ("las", {"spacing_m": 0.1}, {}),
    "LAZ": ("las", {"name": "stepped.laz", "spacing_m": 0.1}, {}),
}


def best_ms(work: Callable[[], object], times: int = 5) -> float:
    work()
    took = []
    for _ in range(times):
        begin = time.process_time()
        work()
        took.append(time.process_time() - begin)
    return 1e3 * min(took)


def main() -> None:
    cell_m = float(sys.argv[1]) if len(sys.argv) > 1 else 0.25
    stepped = trial["Stepped"]()
    print(f"{'format':14}{'file':>11}{'time':>11}{'peak':>10}{'cells':>13}   at {cell_m:g} m")
    with tempfile.TemporaryDirectory() as folder:
        for name, (write, options, keys) in FORMATS.items():
            if name == "npz":
                options = {"cell_m": cell_m}
            path = getattr(stepped, write)(Path(folder), **options)
            request = MapRequest(path, cell_m, stepped.ground_m, at=stepped.at, **keys)
            took_ms = best_ms(lambda request=request: read_site(request))
            tracemalloc.start()
            rows, cols = read_site(request).site.heights.shape
            peak_mb = tracemalloc.get_traced_memory()[1] / 1e6
            tracemalloc.stop()
            size_kb = path.stat().st_size / 1e3
            print(f"{name:14}{size_kb:8.0f} kB{took_ms:8.1f} ms{peak_mb:7.0f} MB{rows:6} × {cols:<6}")


if __name__ == "__main__":
    main()
