"""The first run after installing, measured: what numba compiles, and how long until something is ready.

python tests/bench/bench_cold.py [--totals]

Processor seconds are those of all processes together; wall seconds mean something on a free machine alone.
"""

from __future__ import annotations

import collections
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
TORRE = ("missions/torre.toml", "--out")
WAITS_FOR = "ready to arm"


def table() -> None:
    """Fly the torre with everything compiled in this process; each dispatcher's own time, without its callees'."""
    from numba.core import event

    class Compilations(event.Listener):
        def __init__(self) -> None:
            self.own_s: dict[str, list[float]] = collections.defaultdict(list)
            self._open: list[list[float]] = []

        def on_start(self, _: event.Event) -> None:
            self._open.append([time.thread_time(), 0.0])

        def on_end(self, ended: event.Event) -> None:
            begun_s, callees_s = self._open.pop()
            took_s = time.thread_time() - begun_s
            if self._open:
                self._open[-1][1] += took_s
            function = ended.data["dispatcher"].py_func
            self.own_s[f"{function.__module__}.{function.__qualname__}"].append(took_s - callees_s)

    compilations = Compilations()
    event.register("numba:compile", compilations)
    from mavspiral import load_mission, simulate
    from sitl import compiling

    compiling.is_compiled = lambda _: True  # so no worker takes it away
    simulate(load_mission(ROOT / TORRE[0]))
    rows = sorted(compilations.own_s.items(), key=lambda row: -sum(row[1]))
    print(f"{'dispatcher':60}{'signatures':>10}{'seconds':>9}")
    for name, own_s in rows:
        print(f"{name[-59:]:60}{len(own_s):>10}{sum(own_s):>9.2f}")
    for room in ("mavspiral.", "sitl.", "numba."):
        some = [own_s for name, own_s in rows if name.startswith(room)]
        print(f"{'all of ' + room[:-1]:60}{sum(map(len, some)):>10}{sum(map(sum, some)):>9.2f}")


def ended(command: list[str], environment: dict[str, str]) -> tuple[float, float, float]:
    """Wall s, processor s and greatest memory in MB of a command: until it ends, or says that it is ready."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", *command], cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    said = []
    for line in process.stdout:
        said.append(line)
        if WAITS_FOR in line:
            break
    wall_s = time.perf_counter() - begun
    if WAITS_FOR in (said or [""])[-1]:
        assert said[0].startswith("sitl: px4"), said[0]
        process.send_signal(signal.SIGINT)
        process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, f"{command}: {process.returncode}"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return wall_s, cpu_s, usage.ru_maxrss / 1024


def totals() -> None:
    print(f"\n{'until it ends, or is ready to arm':36}{'cache':>7}{'wall s':>9}{'all s':>9}{'MB':>7}  asked")
    for name, command, asked in (
        ("mavspiral plan, torre", ["mavspiral.cli", "plan", *TORRE], ""),
        ("mavspiral simulate, torre", ["mavspiral.cli", "simulate", *TORRE], "≤ 60 s cold"),
        ("python -m sitl", ["sitl", "--instance", "93"], "≤ 20 s cold, ≤ 3 s warm, ≤ 250 MB"),
    ):
        with tempfile.TemporaryDirectory() as empty:
            environment = {**os.environ, "NUMBA_CACHE_DIR": f"{empty}/numba"}
            whole = [*command, f"{empty}/out"] if command[-1] == "--out" else command
            for cache in ("empty", "full"):
                wall_s, cpu_s, memory_mb = ended(whole, environment)
                print(f"{name:36}{cache:>7}{wall_s:>9.1f}{cpu_s:>9.1f}{memory_mb:>7.0f}  {asked}", flush=True)


def main() -> None:
    if "--totals" not in sys.argv:
        with tempfile.TemporaryDirectory() as empty:
            environment = {**os.environ, "NUMBA_CACHE_DIR": empty, "BENCH_ONLY_TABLE": "1"}
            subprocess.run([sys.executable, __file__], env=environment, check=True)
    totals()


if __name__ == "__main__":
    if os.environ.get("BENCH_ONLY_TABLE"):
        table()
    else:
        main()
