"""ArduCopter's commander looks only when it must: not a frame later than one that looks in each."""

from __future__ import annotations

from copter_client import Client, new_simulator

from sitl.faults import parse_fault

STEP_US = 20_000


def live_both(by_frame, at_once, until_us, data_at=lambda _: b"") -> None:
    for at_us in range(at_once.time_us + STEP_US, until_us + 1, STEP_US):
        data = data_at(at_us)
        halves = by_frame.step(at_us - STEP_US // 2, b""), by_frame.step(at_us, data)
        whole = at_once.step(at_us, data)
        assert whole.send == b"".join(half.send for half in halves)
        assert whole.events == halves[0].events + halves[1].events
    assert by_frame.truth.numbers.tobytes() == at_once.truth.numbers.tobytes()


def test_until_it_is_armed_two_frames_at_once_are_the_same_as_one_by_one():
    by_frame, at_once = new_simulator(seed=5), new_simulator(seed=5)
    live_both(by_frame, at_once, 42_000_000)
    assert at_once.report.flight.knows_place


def test_in_guided_two_frames_at_once_are_the_same_flight_as_one_by_one_whatever_befalls_it(aloft):
    """A stream that ends, and a position that is lost in an odd frame."""
    by_frame, at_once = new_simulator(), aloft.simulator
    by_frame.restore(at_once.snapshot())
    start_us = at_once.time_us // STEP_US * STEP_US
    pilot = Client(at_once)

    def stream(at_us: int) -> bytes:
        ahead_s = 1e-6 * (at_us - start_us)
        if 4.0 < ahead_s < 10.0:  # GUID_TIMEOUT passes
            return b""
        pilot.target(p=(2.0 * ahead_s, 1.0, -12.0), v=(2.0, 0.0, 0.0), yaw=0.1 * ahead_s)
        data, pilot.outbox = pilot.outbox, b""
        return data

    for one in (by_frame, at_once):
        one.inject(parse_fault(f"gps_loss@{start_us * 1e-6 + 12.01:.2f}+9"))
    live_both(by_frame, at_once, start_us + 24_000_000, stream)
    assert at_once.report.flight.mode.name == "LAND"  # FS_EKF_ACTION
