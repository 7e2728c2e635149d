"""The vehicle's .tlog: pymavlink reads it, garbage is not in it, a full disk ends it and nothing else."""

from __future__ import annotations

import io

from hypothesis import given
from hypothesis import strategies as st
from pymavlink import mavutil

from sitl.link.codec import Codec
from sitl.link.frames import whole_frames
from sitl.link.messages import message_type
from sitl.link.tlog import TlogWriter, logged_frames

STATUSTEXT = message_type("STATUSTEXT")


def frames(texts):
    codec = Codec(7, 1)
    return [codec.encode(STATUSTEXT(6, text, 0, 0)) for text in texts]


def test_pymavlink_reads_it_back(tmp_path):
    path = tmp_path / "vehicle.tlog"
    with path.open("wb", buffering=0) as file:
        log = TlogWriter(file)
        one, two, three = frames([b"one", b"two", b"three"])
        log.write(10_000, one + two, b"")
        log.write(20_000, b"not mavlink", three)
    reader = mavutil.mavlink_connection(str(path), dialect="common")
    read = [reader.recv_msg() for _ in range(3)]
    assert [message.text for message in read] == ["one", "two", "three"]
    assert read[2]._timestamp == 1767225600.02  # 2026 began 20 ms ago
    assert read[0].get_srcSystem() == 7


@given(st.lists(st.binary(min_size=1, max_size=50), max_size=20), st.binary(max_size=30))
def test_every_frame_before_garbage_is_logged_and_read(texts, garbage):
    sent = frames(texts)
    file = io.BytesIO()
    TlogWriter(file).write(0, b"".join(sent) + b"\0" + garbage)
    assert list(logged_frames(file.getvalue())) == sent


@given(st.binary(max_size=600))
def test_whatever_comes_is_walked_to_an_end(data):
    assert b"".join(whole_frames(data)) == data[: sum(map(len, whole_frames(data)))]


def test_a_full_disk_is_told_once_and_the_flight_goes_on():
    class Full(io.BytesIO):
        def write(self, data):
            raise OSError(28, "No space left on device")

    log = TlogWriter(Full())
    for now_us in (0, 10_000):
        log.write(now_us, *frames([b"x"]))
    assert log.fault.errno == 28
