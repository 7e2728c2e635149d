"""Whatever comes in, a session does not raise, keeps less than a frame of it, and flies on."""

from __future__ import annotations

import random

from fake_flight import fly, make_session
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from mavspiral.flight.link import Link

STRANGER = common.MAVLink(None, srcSystem=66, srcComponent=1)
FRAMES = [
    STRANGER.heartbeat_encode(2, 12, 209, 0xFFFFFFFF, 7).pack(STRANGER),
    STRANGER.local_position_ned_encode(0, *[float("nan")] * 6).pack(STRANGER),
    STRANGER.command_ack_encode(400, 4).pack(STRANGER),
    STRANGER.gps_global_origin_encode(2**31 - 1, -(2**31), 0).pack(STRANGER),
]


def hostile(draw):
    """Random bytes, or a stranger's frame: whole, cut, or with a bit turned."""
    kind, data = draw.randrange(4), bytearray(draw.choice(FRAMES))
    if kind == 0:
        return b"\xfd" + draw.randbytes(draw.randrange(300))
    if kind == 1:
        return bytes(data[: draw.randrange(len(data))])
    if kind == 2:
        data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
    return bytes(data)


def test_a_besieged_flight_is_flown_as_planned(px4):
    session, draw = make_session(), random.Random(4)
    fly(
        session, px4, down=lambda frames: [data for f in frames for data in (hostile(draw), f, hostile(draw))]
    )
    assert session.outcome.ok, session.outcome
    assert session.garbage_n > 10_000


def test_a_vehicle_that_says_nothing_but_nan_is_not_taken_off_with(px4):
    session, mav = make_session(), common.MAVLink(None, srcSystem=1, srcComponent=1)
    nan = [float("nan")] * 6

    def lie(frames):
        position = mav.local_position_ned_encode(0, *nan).pack(mav)
        return [
            position if frame[7] == common.MAVLINK_MSG_ID_LOCAL_POSITION_NED else frame for frame in frames
        ]

    fly(session, px4, down=lie)
    assert not session.outcome.ok
    assert not px4.armed


@settings(max_examples=300, deadline=None)
@given(st.lists(st.binary(max_size=400) | st.sampled_from(FRAMES), max_size=30))
def test_no_bytes_break_the_link_and_little_is_kept(chunks):
    link = Link()
    link.vehicle = 1, 1
    for chunk in chunks:
        assert link.receive(chunk) == []
    assert len(link._decoder._rest) < 300
    assert link.receive(bytes(300)) == []
