"""What a step of the streamer costs, in processor time.

Run: python tests/bench/bench_flight.py
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(0, str(Path(__file__).parents[1] / "flight"))

import numpy as np
from fake_flight import HOME, PLAN_ORIGIN, VEHICLE_ORIGIN, fly, make_session, make_trajectory
from fake_px4 import FakePx4
from pymavlink.dialects.v20 import common as mavlink

from mavspiral.flight.flight_log import TlogWriter
from mavspiral.flight.link import Link
from mavspiral.flight.outcome import State
from mavspiral.flight.reference import Reference
from mavspiral.frames import GeoPoint, LocalFrame


def per_call_us(what, n=20_000):
    best = min(_timed(what, n // 5) for _ in range(5))
    return best / (n // 5) * 1e6


def _timed(what, n):
    begin = time.process_time()
    for _ in range(n):
        what()
    return time.process_time() - begin


def bench_step(tap=None):
    """Streaming, 50 Hz of LOCAL_POSITION_NED and 1 Hz of GPS in, 50 Hz of setpoints out: µs a step, steps of 20 ms."""
    session = make_session(route=lambda home: make_trajectory(home, 90.0), tap=tap)
    px4 = FakePx4(VEHICLE_ORIGIN, HOME)
    fly(session, px4, until=lambda: session.path_t_s > 20)
    now_us = px4.track[-1][0]
    boot_us = session.log().vehicle_s[-1] * 1e6
    px4._out.clear()
    packets = []
    for k in range(3000):
        target = session._s.reference.at(20.0 + 0.02 * (k + 1))
        px4._boot_us = boot_us + 20_000 * (k + 1)
        px4.position, px4.velocity = list(target.position_ned_m), list(target.velocity_ned_mps)
        px4._send_local_position_ned()
        if k % 50 == 0:
            px4._send_gps_raw_int()
        packets.append(b"".join(px4._out))
        px4._out.clear()
    begin = time.process_time()
    for k, packet in enumerate(packets):
        session.step(now_us + 20_000 * (k + 1), packet)
    elapsed_s = time.process_time() - begin
    assert session.state is State.STREAM and session.path_t_s > 79, (session.state, session.path_t_s)
    return elapsed_s / len(packets) * 1e6


def bench_schedule(seconds=10.0):
    """How late setpoints leave on an absolute deadline, through a real socket: µs, p50, p99, max."""
    from mavspiral.flight.realtime import drive
    from mavspiral.flight.transports import open_transport

    transport = open_transport("udpout://127.0.0.1:9")
    session, px4 = make_session(), FakePx4(VEHICLE_ORIGIN, HOME)
    fly(session, px4, until=lambda: session.path_t_s > 20)
    offset_us = px4.track[-1][0] - time.monotonic_ns() // 1000
    session._s.config = type(session._s.config)(lost_after_s=seconds)
    late, due = [], [0]

    def note(session, step):
        now_us = time.monotonic_ns() // 1000 + offset_us
        if step.send and due[0]:
            late.append(now_us - due[0])
        due[0] = step.next_due_us

    drive(session, transport, note, now_us=lambda: time.monotonic_ns() // 1000 + offset_us)
    return np.percentile(late, [50, 99, 100])


def main():
    link = Link()
    link.vehicle = (1, 1)
    to_vehicle = LocalFrame(PLAN_ORIGIN).to_vehicle(GeoPoint(*VEHICLE_ORIGIN))
    reference = Reference.of(make_trajectory(np.array([12.0, -31.0, -3.0])), to_vehicle)
    setpoint = reference.on_time(50.0)
    mav = mavlink.MAVLink(None, 1, 1)
    positions = []
    for _ in range(256):
        positions.append(mavlink.MAVLink_local_position_ned_message(1, *range(6)).pack(mav))
        mav.seq = (mav.seq + 1) % 256
    cycle = iter(positions * 400)
    print(f"reference.at              {per_call_us(lambda: reference.at(50.01)):6.2f} µs")
    pack_us = per_call_us(lambda: link.setpoint(1, setpoint, type_mask=0, coordinate_frame=1))
    print(f"link.setpoint             {pack_us:6.2f} µs")
    print(f"link.receive(position)    {per_call_us(lambda: link.receive(next(cycle))):6.2f} µs")
    step_us = min(bench_step() for _ in range(3))
    print(f"session.step              {step_us:6.2f} µs a step of 20 ms = {20_000 / step_us:.0f} x real time")
    with Path("/dev/null").open("wb") as file:
        step_us = min(bench_step(TlogWriter(file.write).write) for _ in range(3))
    print(f"  with a .tlog            {step_us:6.2f} µs")
    p50, p99, worst = bench_schedule()
    print(f"schedule, late            {p50:6.0f} µs p50, {p99:.0f} p99, {worst:.0f} max")


if __name__ == "__main__":
    main()
