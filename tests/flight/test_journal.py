"""What is written as it happens, and read after any end."""

import threading
import time
from pathlib import Path

import numpy as np
import pytest
from fake_flight import PLAN_ORIGIN, fly, make_session

from mavspiral.errors import InputError
from mavspiral.flight import spool as spools
from mavspiral.flight.journal import JournalWriter, borrowed_in, read_journal, whole_n
from mavspiral.flight.spool import Spool
from mavspiral.frames import LocalFrame
from mavspiral.logbook.recording import Recording

FACTS = {"digest": "0", "resumes": False, "begin_s": 0.0, "end_s": 40.0}


class Noted:
    """A session that keeps a journal as it is stepped."""

    def __init__(self, session, data):
        self.session, self.journal = session, JournalWriter(data.extend)
        self.journal.begin(FACTS)

    def step(self, now_us, received):
        step = self.session.step(now_us, received)
        self.journal.note(self.session, step)
        return step

    def __getattr__(self, name):
        return getattr(self.session, name)


@pytest.fixture
def written(px4):
    data = bytearray()
    noted = Noted(make_session(), data)
    fly(noted, px4)
    noted.journal.end(noted.session)
    return bytes(data), noted.session


def test_the_log_comes_back_from_the_journal(written, tmp_path):
    data, session = written
    (tmp_path / "j").write_bytes(data)
    [flight] = read_journal(tmp_path / "j")
    ours, theirs = session.log(), flight.log(LocalFrame(PLAN_ORIGIN))
    assert flight.begin == FACTS and flight.end["ok"]
    assert theirs.events == ours.events and theirs.legs == ours.legs and len(theirs.t_us) > 2000
    for column in ("t_us", "path_t_s", "estimate_position_enu_m", "reference_velocity_enu_mps"):
        assert np.array_equal(getattr(theirs, column), getattr(ours, column), equal_nan=True)


def test_a_journal_torn_anywhere_is_read_to_the_tear_and_goes_on_there(written, tmp_path):
    data, _ = written
    path = tmp_path / "j"
    for cut in (*range(len(data) - 400, len(data), 7), len(data) // 2):
        path.write_bytes(data[:cut])
        whole = whole_n(path)
        assert cut - 10_000 < whole <= cut
        path.write_bytes(data[:whole] + data)
        assert [f.begin for f in read_journal(path)] == [FACTS, FACTS], (
            "the next flight is not lost behind it"
        )


def test_one_flipped_bit_ends_the_reading(written, tmp_path):
    data, _ = written
    spoiled = bytearray(data)
    spoiled[len(data) // 2] ^= 4
    (tmp_path / "j").write_bytes(spoiled)
    [flight] = read_journal(tmp_path / "j")
    assert flight.end is None and len(flight.rows) > 0


@pytest.mark.parametrize("content", [None, b"no journal at all"])
def test_what_is_no_journal_is_refused_in_a_line(tmp_path, content):
    if content is not None:
        (tmp_path / "j").write_bytes(content)
    with pytest.raises(InputError, match=r"Fix:.*without --resume"):
        read_journal(tmp_path / "j")


@pytest.mark.parametrize("read", [borrowed_in, whole_n])
def test_a_journal_that_cannot_be_read_is_refused_in_a_line_and_one_that_is_not_there_is_empty(
    tmp_path, read
):
    assert not read(tmp_path / "j")
    (tmp_path / "j").mkdir()
    with pytest.raises(InputError, match=r"j: cannot be read \(Is a directory\)\. Fix:"):
        read(tmp_path / "j")


def test_a_spool_appends_what_it_is_given_in_order(tmp_path):
    path = tmp_path / "folder" / "s"
    for keep_n, begin in ((None, 0), (300, 100)):
        spool = Spool(path, keep_n=keep_n)
        for number in range(begin, begin + 100):
            spool.write(b"%03d" % number)
        spool.close()
    assert path.read_bytes() == b"".join(b"%03d" % number for number in range(200))


def test_it_is_in_the_file_within_a_second_without_being_closed(tmp_path, monkeypatch):
    """The thread rests so long at a time; when the machine lets it run is not its to say."""
    rests_s, wait = [], threading.Event.wait
    monkeypatch.setattr(
        threading.Event, "wait", lambda event, rest_s=None: rests_s.append(rest_s) or wait(event, rest_s)
    )
    spool = Spool(tmp_path / "s")
    spool.write(b"soon")
    until = time.monotonic() + 60.0
    while (tmp_path / "s").read_bytes() != b"soon":
        assert time.monotonic() < until
        time.sleep(0.01)
    assert max(rest_s for rest_s in rests_s if rest_s is not None) <= 0.5
    spool.close()


def test_what_outlasts_us_is_in_the_file_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(spools, "_EVERY_S", 1e6)
    with Recording(tmp_path, "hut") as recording:
        recording.journal(b"E, which may wait")
        recording.journal(b"F, which may not")
        until = time.monotonic() + 60.0
        while (tmp_path / "hut.journal").read_bytes() != b"E, which may waitF, which may not":
            assert time.monotonic() < until
            time.sleep(0.01)


def test_a_disk_that_fails_costs_log_and_nothing_else():
    if not Path("/dev/full").exists():
        pytest.skip("needs /dev/full")
    spool = Spool(Path("/dev/full"))
    for _ in range(100):
        spool.write(b"x" * 1000)
    spool.close()
    assert spool.lost_n == 100_000 and "space" in str(spool.error)


def test_a_file_that_fails_is_said_once_while_it_flies_and_summed_up_afterwards(tmp_path):
    if not Path("/dev/full").exists():
        pytest.skip("needs /dev/full")
    (tmp_path / "hut.tlog").symlink_to("/dev/full")
    with Recording(tmp_path, "hut") as recording:
        assert recording.news() == ()
        recording.packets(b"x" * 1000)
        recording.journal(b"")
        until = time.monotonic() + 5.0
        while not (news := recording.news()):
            assert time.monotonic() < until
            time.sleep(0.01)
        recording.packets(b"x" * 1000)
        assert len(news) == 1 and "hut.tlog is not written any more" in news[0] and "space" in news[0]
        assert recording.news() == ()
    assert recording.news() == ()
    assert [words.split(": ")[1] for words in recording.troubles] == [
        "2000 bytes could not be written ([Errno 28] No space left on device)"
    ]
