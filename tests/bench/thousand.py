"""No flake: closed-loop flights of the kiosk, a seed each, every one flown twice and compared bit by bit.

python tests/bench/thousand.py [--flights 1000] [--processes 2]

It is planned once, by the process that the others are forked from.
"""

from __future__ import annotations

import argparse
import hashlib
import multiprocessing
import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
MISSION = ROOT / "missions" / "kiosk.toml"


class Result(NamedTuple):
    """One flight: what it showed, and a digest of every byte on the link and every column of its log."""

    seed: int
    failures: tuple[str, ...]
    p95_m: float
    clearance_m: float
    digest: str


@cache
def inspection():
    from mavspiral import load_mission, plan

    return plan(load_mission(MISSION))


def flown(seed: int) -> Result:
    from mavspiral import simulate

    flight = simulate(inspection(), seed=seed)
    digest = hashlib.sha256(flight.tlog)
    digest.update(flight.log.truth_position_enu_m.tobytes())
    return Result(
        seed, tuple(flight.failures), flight.tracking_p95_m, flight.clearance_min_m, digest.hexdigest()
    )


def twice(seed: int) -> tuple[Result, Result]:
    return flown(seed), flown(seed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    begin_s = time.perf_counter()
    inspection()
    print(f"planned in {time.perf_counter() - begin_s:.0f} s", flush=True)
    pairs = []
    with ProcessPoolExecutor(options.processes, multiprocessing.get_context("fork")) as pool:
        for pair in pool.map(twice, range(options.flights)):
            pairs.append(pair)
            if len(pairs) % max(1, options.flights // 20) == 0:
                spent_s, bad = (
                    time.perf_counter() - begin_s,
                    sum(bool(a.failures) or a != b for a, b in pairs),
                )
                print(f"{len(pairs):5d} seeds   {spent_s:6.0f} s   {bad} failed or differ", flush=True)
    wall_s = time.perf_counter() - begin_s
    first = [pair[0] for pair in pairs]
    failed = [result for result in first if result.failures]
    differing = [a.seed for a, b in pairs if a != b]
    print(f"kiosk, {len(first)} seeds, each flown twice, in {wall_s:.0f} s")
    print(f"passed                          {len(first) - len(failed)} of {len(first)}")
    print(f"differ when repeated            {len(differing)} {differing[:10] or ''}")
    print(f"different flights               {len({result.digest for result in first})}")
    print(f"tracking p95: median, worst     {statistics.median(r.p95_m for r in first):.3f} m, "
          f"{max(r.p95_m for r in first):.3f} m")  # fmt: skip
    print(f"clearance: median, least        {statistics.median(r.clearance_m for r in first):.2f} m, "
          f"{min(r.clearance_m for r in first):.2f} m")  # fmt: skip
    for result in failed[:10]:
        print(f"seed {result.seed}: {'; '.join(result.failures)}")


if __name__ == "__main__":
    main()
