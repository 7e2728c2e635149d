"""A million hostile datagrams: what they do to a flight. `python tests/bench/hostile.py [DATAGRAMS]` prints its counts.

1. In lockstep: `mavspiral`'s session flies the kiosk on the bundled vehicle while both are fed random bytes,
   bit-flipped, truncated and over-long frames, valid messages with absurd numbers, and mission items out of order.
2. In lockstep, anything goes: valid commands and parameters too. The flight may end; nothing may raise.
3. Over UDP: 64 peers flood `python -m sitl` with 50 000 datagrams a second while one client flies it.
"""

from __future__ import annotations

import math
import multiprocessing
import random
import resource
import socket
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pymavlink import mavutil
from pymavlink.dialects.v20 import common

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from mavspiral import load_mission, plan  # noqa: E402
from mavspiral.closedloop import _config  # noqa: E402
from mavspiral.flight.autopilots import PROFILES, Autopilot  # noqa: E402
from mavspiral.flight.outcome import SessionConfig  # noqa: E402
from mavspiral.flight.session import Session  # noqa: E402
from sitl.link.codec import Codec  # noqa: E402
from sitl.link.endpoint import is_free  # noqa: E402
from sitl.link.messages import layout  # noqa: E402
from sitl.simulator import Simulator  # noqa: E402

KNOWN = [number for number in sorted(common.mavlink_map) if number >= 0 and layout(number) is not None]
ABSURD = (math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-45, 0.0, 1.0, 21196.0, 65535.0)
# Whoever may say these flies the vehicle: in the first part they are said to somebody else.
AUTOPILOTS: tuple[Autopilot, Autopilot] = ("px4", "ardupilot")
AUTHORITY = {
    "COMMAND_LONG", "COMMAND_INT", "SET_MODE", "PARAM_SET", "SET_POSITION_TARGET_LOCAL_NED",
    "SET_POSITION_TARGET_GLOBAL_INT", "SET_ATTITUDE_TARGET", "MANUAL_CONTROL", "HEARTBEAT",
}  # fmt: skip
COMMANDS = sorted({v for k, v in vars(common).items() if k.startswith("MAV_CMD_") and isinstance(v, int)})
PEERS, FLOOD_HZ, FLOOD_S = 64, 50_000, 20.0


class Hostile:
    """Makes datagrams, and counts them by kind."""

    def __init__(self, seed: int, *, obeyed: bool) -> None:
        self.random = random.Random(seed)
        self.obeyed = obeyed
        self.counts: Counter[str] = Counter()
        self._codec = Codec(255, 190)
        self._kinds: dict[str, Callable[[], bytes]] = {
            "random bytes": self.noise,
            "bits flipped": self.flipped,
            "truncated": self.truncated,
            "over-long": self.overlong,
            "absurd numbers": self.absurd,
            "mission items out of order": self.item,
        }

    def datagram(self) -> bytes:
        """One of any kind."""
        name = self.random.choice(tuple(self._kinds))
        self.counts[name] += 1
        return self._kinds[name]()

    def noise(self) -> bytes:
        data = self.random.randbytes(self.random.randrange(300))
        return (b"\xfd" if self.random.random() < 0.5 else b"\xfe") + data

    def absurd(self) -> bytes:
        if self.obeyed and self.random.random() < 0.5:
            name = self.random.choice(sorted(AUTHORITY))
            return self._frame(getattr(common, f"MAVLINK_MSG_ID_{name}"), meant=True)
        return self._frame(self.random.choice(KNOWN))

    def flipped(self) -> bytes:
        data = bytearray(self.absurd())
        for _ in range(self.random.randint(1, 3)):
            data[self.random.randrange(len(data))] ^= 1 << self.random.randrange(8)
        return bytes(data)

    def truncated(self) -> bytes:
        data = self.absurd()
        return data[: self.random.randrange(len(data))]

    def overlong(self) -> bytes:
        data = bytearray(self.absurd())
        data[1] = self.random.randrange(256)
        return bytes(data) + self.random.randbytes(self.random.randrange(1000))

    def item(self) -> bytes:
        name = self.random.choice(("MISSION_COUNT", "MISSION_ITEM_INT", "MISSION_ITEM", "MISSION_ACK"))
        return self._frame(getattr(common, f"MAVLINK_MSG_ID_{name}"), meant=True)

    def _frame(self, number: int, *, meant: bool = False) -> bytes:
        entry, kind = common.mavlink_map[number], layout(number).type
        types = dict(zip(entry.fieldnames, entry.fieldtypes, strict=True))
        others = not self.obeyed and entry.msgname in AUTHORITY
        values = []
        for name, length in zip(entry.ordered_fieldnames, entry.lengths, strict=True):
            values.append(self._value(name, types[name].split("_mavlink")[0], length, meant, others))
        return self._codec.encode(kind(*values), (199, 7) if others or not meant else None)

    def _value(self, name: str, wire: str, length: int, meant: bool, others: bool) -> object:
        if wire == "char":
            return self.random.randbytes(self.random.randrange(length + 1))
        if name == "target_system":
            return 77 if others else self.random.choice((1, 1, 0)) if not meant else 1
        if name == "target_component":
            return 1
        if name == "command" and length == 1 and wire == "uint16_t":
            return self.random.choice(COMMANDS)
        values = tuple(self._number(wire) for _ in range(length))
        return values if length > 1 else values[0]

    def _number(self, wire: str) -> float | int:
        if wire in ("float", "double"):
            return self.random.choice(ABSURD) if self.random.random() < 0.7 else self.random.gauss(0.0, 1e4)
        bits, low = int(wire.strip("uint_")), 0 if wire[0] == "u" else 1
        if self.random.random() < 0.5:
            return self.random.randrange(10)
        return self.random.randrange(-low << (bits - 1), 1 << (bits - low))


def peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def besieged_flight(
    seed: int, per_step: int, autopilot: Autopilot, *, obeyed: bool
) -> tuple[Counter[str], Session, Simulator]:
    """The kiosk, flown in lockstep while both ends get `per_step` hostile datagrams in each 20 ms."""
    inspection = plan(load_mission(ROOT / "missions/kiosk.toml")).flown_by(autopilot)
    simulator = Simulator(_config(inspection, seed, 0.0, False, ()))
    session = Session(
        inspection.route_from,
        inspection.site.heights.frame,
        SessionConfig(safe_height_enu_m=inspection.safe_height_enu_m),
        profiles=(PROFILES[autopilot],),
        way_home=inspection.way_home,
    )
    hostile = Hostile(seed, obeyed=obeyed)
    now_us, to_vehicle = 0, b""
    while session.outcome is None and now_us < 600_000_000:
        to_vehicle = b"".join([*(hostile.datagram() for _ in range(per_step)), to_vehicle])
        step = simulator.step(now_us, to_vehicle)
        to_session = b"".join([*(hostile.datagram() for _ in range(per_step)), step.send])
        answer = session.step(now_us, to_session)
        to_vehicle, now_us = answer.send, answer.next_due_us
        assert np.isfinite(simulator.truth.position_ned_m).all()
    return hostile.counts, session, simulator


def flood(port: int, seconds: float, sent: multiprocessing.Value) -> None:  # type: ignore[valid-type]
    """64 peers, together FLOOD_HZ datagrams a second."""
    hostile = Hostile(1, obeyed=False)
    datagrams = [hostile.datagram() for _ in range(4096)]
    peers = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(PEERS)]
    begin = time.monotonic()
    count = 0
    while (elapsed := time.monotonic() - begin) < seconds:
        while count < elapsed * FLOOD_HZ:
            try:
                peers[count % PEERS].sendto(datagrams[count % len(datagrams)], ("127.0.0.1", port))
            except OSError:
                time.sleep(0.001)
            count += 1
        time.sleep(0.0005)
    sent.value = count


def process_mb(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmRSS:")[1].split()[0]) / 1024


def besieged_socket() -> None:
    """One client hovers; 64 others flood. Both links' ports are private."""
    instance = next(n for n in range(20, 200) if all(is_free(p + n) for p in (14540, 14550, 14580, 18570)))
    process = subprocess.Popen(
        [sys.executable, "-m", "sitl", "--instance", str(instance)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        while "ready to arm" not in (line := process.stdout.readline()):
            assert line, "the vehicle did not start"
        link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{14540 + instance}", dialect="common")
        link.wait_heartbeat()
        nan = math.nan
        link.mav.command_long_send(instance + 1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
        link.mav.command_long_send(instance + 1, 1, 22, 0, 0, 0, 0, nan, nan, nan, nan)
        link.motors_armed_wait()
        while link.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=1.0).z > -2.3:
            pass
        before_mb = process_mb(process.pid)
        sent = multiprocessing.Value("Q", 0)
        sender = multiprocessing.Process(target=flood, args=(14580 + instance, FLOOD_S, sent))
        sender.start()
        heard: Counter[str] = Counter()
        heights = []
        begin = time.monotonic()
        boot_ms = None
        while time.monotonic() - begin < FLOOD_S:
            message = link.recv_match(blocking=True, timeout=1.0)
            if message is None:
                continue
            heard[message.get_type()] += 1
            if message.get_type() == "LOCAL_POSITION_NED":
                heights.append(-message.z)
                boot_ms = boot_ms or message.time_boot_ms
                last_ms = message.time_boot_ms
        sender.join()
        print(f"UDP flood by {PEERS} peers            {sent.value} datagrams in {FLOOD_S:.0f} s")
        print(
            f"  heard by the client meanwhile      {heard.total()} messages, {heard['HEARTBEAT']} heartbeats"
        )
        print(f"  simulated time passed               {(last_ms - boot_ms) / 1e3:.1f} s")
        print(f"  height, least and greatest          {min(heights):.2f} {max(heights):.2f} m")
        print(f"  memory before and after             {before_mb:.0f} {process_mb(process.pid):.0f} MB")
        process.terminate()
        print(f"  exit code                           {process.wait(10.0)}")
    finally:
        process.kill()


def main(datagrams: int) -> None:
    counts: Counter[str] = Counter()
    seed, flights = 0, Counter[str]()
    begin_mb, begin_s = 0.0, time.process_time()
    while counts.total() < datagrams:
        more, session, _ = besieged_flight(seed, 10, AUTOPILOTS[seed % 2], obeyed=False)
        counts += more
        begin_mb = begin_mb or peak_mb()
        seed += 1
        flights[AUTOPILOTS[(seed - 1) % 2]] += session.outcome is not None and session.outcome.ok
        if not (session.outcome and session.outcome.ok):
            print(f"  seed {seed - 1}: {session.outcome}; {[e.text for e in session.events][-6:]}")
    print(
        f"in lockstep, both ends besieged        {counts.total()} datagrams, {time.process_time() - begin_s:.0f} s"
    )
    for name, count in sorted(counts.items()):
        print(f"  {name:36s}{count}")
    print(f"  flights flown as planned            {dict(flights)} of {seed}")
    print(f"  memory after the first and the last {begin_mb:.0f} {peak_mb():.0f} MB")
    for autopilot in AUTOPILOTS:
        more, session, _ = besieged_flight(1000, 10, autopilot, obeyed=True)
        print(
            f"in lockstep, absurd orders obeyed      {more.total()} datagrams: {autopilot}: "
            f"{session.outcome and session.outcome.reason}"
        )
    besieged_socket()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
