"""How late setpoints leave: `python tests/bench/bench_schedule.py [SECONDS]`. A whole flight of the kiosk over UDP.

The vehicle is `python -m sitl`, the log is written as `fly` writes it. A setpoint's lateness is from its deadline, a
multiple of 20 ms after the first, to the return of the system call that sends it. Quiet, then with one core kept busy.
Below each row: a bare loop of the same priority that only sleeps, at the same time on the same machine (what is late there, we
cannot mend), and the processor time that we took from waking up to having sent (what a stolen processor adds is in it, too).
"""

from __future__ import annotations

import multiprocessing
import os
import random
import select
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
SETPOINT = b"\x54\x00\x00"  # message 84, bytes 7 to 9 of its frame
PERIOD_US = 20_000
ASKED_MS = {"quiet": (1.0, 5.0), "one core busy": (3.0, float("nan"))}


class Timed:
    """A transport that notes when setpoints were gone."""

    def __init__(self, transport, begin_us):
        self.transport, self.begin_us, self.gone_us = transport, begin_us, []
        self.took_ms, self._woke_ns = [], time.thread_time_ns()

    def send(self, data):
        self.transport.send(data)
        if data[7:10] == SETPOINT or SETPOINT in data:
            self.gone_us.append(time.monotonic_ns() // 1000 - self.begin_us)
            self.took_ms.append((time.thread_time_ns() - self._woke_ns) / 1e6)

    def receive(self, timeout_s):
        data = self.transport.receive(timeout_s)
        self._woke_ns = time.thread_time_ns()
        return data

    def __getattr__(self, name):
        return getattr(self.transport, name)


def bare(seconds, told):
    """Lateness in ms of a loop that does nothing, put into the queue `told`."""
    from mavspiral.flight.priority import run_first

    run_first()
    late_ms, due_ns = [], time.monotonic_ns()
    end_ns = due_ns + round(seconds * 1e9)
    while due_ns < end_ns:
        due_ns += PERIOD_US * 1000
        select.select([], [], [], max(0.0, (due_ns - time.monotonic_ns()) / 1e9))
        late_ms.append((time.monotonic_ns() - due_ns) / 1e6)
    told.put(late_ms)


def flight(seconds: float) -> tuple[np.ndarray, np.ndarray, str]:
    """Lateness of each setpoint in ms, the processor time it took, and how it ended."""
    from mavspiral import load_mission, plan
    from mavspiral.flight.flight_log import TlogWriter
    from mavspiral.flight.journal import JournalWriter
    from mavspiral.flight.outcome import SessionConfig
    from mavspiral.flight.realtime import drive
    from mavspiral.flight.session import Session
    from mavspiral.flight.transports import open_transport
    from mavspiral.logbook.recording import Recording

    inspection = plan(load_mission(ROOT / "missions" / "kiosk.toml"))
    instance = random.randrange(20, 240)
    vehicle = subprocess.Popen(
        [sys.executable, "-m", "sitl", "--instance", str(instance)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        next(line for line in vehicle.stdout if "ready to arm" in line)
        begin_us = time.monotonic_ns() // 1000
        stop_s = time.monotonic() + seconds
        firsts = []
        with tempfile.TemporaryDirectory() as folder, Recording(Path(folder), "kiosk") as recording:
            session = Session(
                inspection.route_from,
                inspection.site.heights.frame,
                SessionConfig(safe_height_enu_m=inspection.safe_height_enu_m),
                shots=inspection.shot_orders(inspection.sorties()[0]),
                tap=TlogWriter(recording.packets).write,
            )
            journal = JournalWriter(recording.journal)
            journal.begin({})
            timed = Timed(open_transport(f"udpin://127.0.0.1:{14540 + instance}"), begin_us)

            def told(_, step):
                journal.note(session, step)
                if not firsts:
                    firsts.append(session._streamer.schedule.due_us)
                if time.monotonic() > stop_s:
                    session.link_broke("the bench is over")

            drive(session, timed, told, now_us=lambda: time.monotonic_ns() // 1000 - begin_us)
            timed.close()
        late_us = (np.array(timed.gone_us) - firsts[0]) % PERIOD_US
        missed = np.diff(timed.gone_us) > 1.5 * PERIOD_US
        return (
            late_us / 1e3,
            np.array(timed.took_ms),
            f"{len(late_us)} setpoints, {missed.sum()} deadlines missed; {session.outcome.reason}",
        )
    finally:
        vehicle.send_signal(signal.SIGINT)
        vehicle.wait()


def burn() -> None:
    while True:
        pass


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    print(f"load of the machine before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print(f"{'':16}{'p50':>8}{'p99':>8}{'max':>8}  ms   asked p99, max")
    for name, (p99, worst) in ASKED_MS.items():
        burner = multiprocessing.Process(target=burn, daemon=True)
        if name != "quiet":
            burner.start()
        queue = multiprocessing.Queue()
        beside = multiprocessing.Process(target=bare, args=(seconds, queue), daemon=True)
        beside.start()
        late_ms, took_ms, told = flight(seconds)
        bare_ms = np.array(queue.get())
        if burner.is_alive():
            burner.terminate()
        print(f"{name:16}{quantiles(late_ms)}       {p99:g}, {worst:g}   {told}")
        print(f"{'  a bare loop':16}{quantiles(bare_ms)}")
        print(f"{'  processor':16}{quantiles(took_ms)}", flush=True)


def quantiles(values_ms):
    return "".join(f"{ms:8.2f}" for ms in (*np.quantile(values_ms, [0.5, 0.99]), values_ms.max()))


if __name__ == "__main__":
    main()
