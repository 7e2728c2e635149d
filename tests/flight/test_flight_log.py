import io

import numpy as np
import pytest
from fake_flight import HOME, VEHICLE_ORIGIN, fly, make_session
from fake_px4 import FakePx4
from pymavlink import mavutil

from mavspiral.errors import InputError
from mavspiral.flight.flight_log import Event, FlightLog, TlogWriter

EPOCH_US = 1_700_000_000_000_000


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    path = tmp_path_factory.mktemp("flown") / "flight.tlog"
    with path.open("wb") as file:
        session = make_session(tap=TlogWriter(file.write, EPOCH_US).write)
        fly(session, FakePx4(VEHICLE_ORIGIN, HOME))
    return session, session.log(), path


def test_rows_run_at_fifty_hertz_from_take_off_to_disarming(flown):
    session, log, _ = flown
    assert set(np.diff(log.t_us)) == {20_000}
    heights = log.estimate_position_enu_m[:, 2]
    assert heights[0] == pytest.approx(heights[-1], abs=0.1) and np.ptp(heights) > 25
    off = np.isnan(log.path_t_s)
    assert np.isnan(log.reference_position_enu_m[off & (log.leg == -1)]).any()
    assert [log.legs[i] for i in dict.fromkeys(log.leg[log.leg >= 0])] == [
        "approach-1",
        "inspection",
        "return-1",
    ]
    begin_s, end_s = session.trajectory.span_s("inspection")
    inspected = log.path_t_s[log.on_leg("inspection")]
    assert inspected.min() == pytest.approx(begin_s, abs=0.021) and inspected.max() <= end_s


def test_reference_and_estimate_are_in_one_frame(flown):
    _, log, _ = flown
    on = log.on_leg("inspection")
    assert np.abs(log.reference_position_enu_m[on] - log.estimate_position_enu_m[on]).max() < 0.3
    assert np.abs(log.reference_velocity_enu_mps[on] - log.estimate_velocity_enu_mps[on]).max() < 0.3
    turned = np.angle(np.exp(1j * (log.reference_yaw_enu_rad[on] - log.estimate_yaw_enu_rad[on])))
    assert np.abs(turned).max() < 0.05


def test_saved_and_loaded_it_is_the_same(flown, tmp_path):
    _, log, _ = flown
    log.save(tmp_path / "a.flight.npz")
    back = FlightLog.load(tmp_path / "a.flight.npz")
    assert back.legs == log.legs and back.events == log.events
    assert back.truth_position_enu_m is None
    for name in (
        "t_us",
        "path_t_s",
        "leg",
        "governor_rate",
        "reference_position_enu_m",
        "estimate_yaw_enu_rad",
    ):
        assert np.array_equal(getattr(back, name), getattr(log, name), equal_nan=name != "t_us"), name
    assert [p.name for p in tmp_path.iterdir()] == ["a.flight.npz"], "nothing is left beside it"


def test_truth_travels_with_it(flown, tmp_path):
    _, log, _ = flown
    n = len(log.t_us)
    full = log.with_truth(np.ones((n, 3)), np.zeros((n, 3)), np.full(n, 0.5))
    full.save(tmp_path / "b.npz")
    assert FlightLog.load(tmp_path / "b.npz").truth_yaw_enu_rad == pytest.approx(0.5)


def test_a_failed_save_leaves_the_old_log_alone(flown, tmp_path, monkeypatch):
    _, log, _ = flown
    path = tmp_path / "c.npz"
    log.save(path)
    before = path.read_bytes()

    def full_disk(file, **columns):
        file.write(b"half")
        raise OSError(28, "no space left on device")

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    with pytest.raises(InputError, match="no space"):
        log.save(path)
    assert path.read_bytes() == before and [p.name for p in tmp_path.iterdir()] == ["c.npz"]


def test_the_tlog_is_read_by_pymavlink_and_holds_both_directions(flown):
    session, _, path = flown
    log = mavutil.mavlink_connection(str(path), robust_parsing=True)
    seen, times = {}, []
    while (message := log.recv_msg()) is not None:
        key = message.get_srcSystem(), message.get_type()
        seen[key] = seen.get(key, 0) + 1
        times.append(message._timestamp)
    assert (0, "BAD_DATA") not in seen
    assert seen[245, "SET_POSITION_TARGET_LOCAL_NED"] == session.figures.sent_n
    assert seen[1, "LOCAL_POSITION_NED"] > 5000
    assert times == sorted(times) and times[0] == pytest.approx(EPOCH_US * 1e-6 + 5, abs=0.1)


def test_a_packet_s_time_is_eight_bytes_big_endian():
    file = io.BytesIO()
    TlogWriter(file.write, 2**40).write(5, b"\xfdframe")
    assert file.getvalue() == (2**40 + 5).to_bytes(8, "big") + b"\xfdframe"


def test_events_are_told_once_and_kept(flown):
    session, log, _ = flown
    assert log.events == session.events
    assert Event(log.events[0].t_us, "info", "connect") == log.events[0]
