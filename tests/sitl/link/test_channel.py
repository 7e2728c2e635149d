import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.faults import LinkDelay, LinkLoss, PacketLoss
from sitl.link.channel import Channel
from sitl.link.codec import Codec
from sitl.link.frames import frames
from sitl.link.messages import message_type

HEARTBEAT = message_type("HEARTBEAT")
SOUND, LOSSY = (), (PacketLoss(0, None, 0.3),)


def channel(seed=1):
    return Channel(np.random.SeedSequence(seed))


def beats(count):
    codec = Codec(1, 1)
    return [codec.encode(HEARTBEAT(number, 2, 12, 0, 3, 3)) for number in range(count)]


@given(st.binary(max_size=600))
def test_cutting_into_frames_loses_nothing_and_ends(data):
    assert b"".join(frames(data)) == data


def test_frames_are_cut_where_frames_end_also_after_garbage_and_in_both_versions():
    one, two = beats(2)
    old = bytes([0xFE, 9, 0, 1, 1, 0]) + bytes(9) + b"xx"
    signed = bytes([one[0], one[1], 1]) + one[3:] + bytes(13)
    pieces = [one, b"\x00\x01", old, signed, two]
    assert list(frames(b"".join(pieces))) == pieces


def test_a_sound_channel_passes_everything_at_once():
    assert channel().carry(0, b"anything", SOUND) == b"anything"


def test_packet_loss_loses_whole_frames_as_often_as_it_says():
    sent = beats(4000)
    got = set(frames(channel().carry(0, b"".join(sent), LOSSY)))
    assert got < set(sent)
    assert len(got) / len(sent) == pytest.approx(0.7, abs=0.02)


def test_the_dice_are_the_seeds_alone():
    sent = b"".join(beats(200))
    assert channel(3).carry(0, sent, LOSSY) == channel(3).carry(0, sent, LOSSY)
    assert channel(3).carry(0, sent, LOSSY) != channel(4).carry(0, sent, LOSSY)


def test_delayed_frames_arrive_in_order_when_their_time_has_come():
    slow, one = (LinkDelay(0, None, 200_000),), channel()
    first, second, third = beats(3)
    assert one.carry(0, first, slow) == b""
    assert one.carry(100_000, second, slow) == b""
    assert one.carry(199_999, b"", slow) == b""
    assert one.carry(200_000, b"", slow) == first
    assert one.carry(210_000, third, SOUND) == b""  # sound again, but nothing overtakes
    assert one.carry(300_000, b"", SOUND) == second + third


def test_nothing_passes_a_lost_link_and_nothing_comes_later():
    one, lost = channel(), (LinkLoss(0, None),)
    assert one.carry(0, beats(1)[0], lost) == b""
    assert one.carry(10_000_000, b"", SOUND) == b""


def test_a_restored_channel_goes_on_as_the_one_that_was_copied():
    faults = (*LOSSY, LinkDelay(0, None, 50_000))
    one, sent = channel(), b"".join(beats(50))
    one.carry(0, sent, faults)
    state = one.snapshot()
    rest = [one.carry(t, sent, faults) for t in (50_000, 100_000)]
    two = channel(9)
    two.restore(state)
    assert [two.carry(t, sent, faults) for t in (50_000, 100_000)] == rest
