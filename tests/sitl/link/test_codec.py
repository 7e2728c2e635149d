"""The codec against pymavlink: the same bytes out, no frame fewer in, whatever comes."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from sitl.link.codec import Codec, CodecState
from sitl.link.messages import layout, message_type

HEARTBEAT = message_type("HEARTBEAT")
STATUSTEXT = message_type("STATUSTEXT")
SETPOINT = message_type("SET_POSITION_TARGET_LOCAL_NED")

WIRE_RANGES = {
    "char": None,
    "float": st.floats(width=32),
    "double": st.floats(),
    **{f"uint{n}_t": st.integers(0, 2**n - 1) for n in (8, 16, 32, 64)},
    **{f"int{n}_t": st.integers(-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
}
KNOWN_IDS = sorted(i for i in common.mavlink_map if layout(i) is not None and i >= 0)


@st.composite
def messages(draw):
    """Any message of the dialect, with any values that fit the wire."""
    entry = common.mavlink_map[draw(st.sampled_from(KNOWN_IDS))]
    wire_types = dict(zip(entry.fieldnames, entry.fieldtypes, strict=True))
    values = []
    for name, length, array_length in zip(
        entry.ordered_fieldnames, entry.lengths, entry.array_lengths, strict=True
    ):
        kind = WIRE_RANGES[wire_types[name].replace("uint8_t_mavlink_version", "uint8_t")]
        if kind is None:
            values.append(draw(st.binary(max_size=max(array_length, 1))).rstrip(b"\0"))
        elif length > 1:
            values.append(tuple(draw(st.lists(kind, min_size=length, max_size=length))))
        else:
            values.append(draw(kind))
    return layout(entry.id).type(*values)


def pymavlink_frame(message, sequence=0, system=1, component=1, force_mavlink1=False):
    mav = common.MAVLink(None, srcSystem=system, srcComponent=component)
    mav.seq = sequence
    theirs = common.mavlink_map[message.ID](**message._asdict())
    return theirs.pack(mav, force_mavlink1=force_mavlink1)


def same(a, b):
    """Equal, with NaN equal to NaN."""
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return a == b or (isinstance(a, float) and math.isnan(a) and math.isnan(b))


@given(messages(), st.integers(0, 255))
@settings(max_examples=300, deadline=None)
def test_every_message_is_packed_to_the_bytes_that_pymavlink_packs(message, sequence):
    codec = Codec(1, 1)
    codec.restore(CodecState(sequence=sequence))
    assert codec.encode(message) == pymavlink_frame(message, sequence)


@given(messages())
@settings(max_examples=200, deadline=None)
def test_every_message_survives_the_wire(message):
    (received,) = Codec(1, 1).decode(Codec(42, 7).encode(message))
    assert (received.system, received.component) == (42, 7)
    assert type(received.message) is type(message)
    assert same(received.message, message)


def test_mavlink_1_frames_are_understood():
    message = HEARTBEAT(custom_mode=5, type=6, autopilot=8, base_mode=1, system_status=4, mavlink_version=3)
    (received,) = Codec(1, 1).decode(pymavlink_frame(message, system=255, force_mavlink1=True))
    assert received.message == message
    assert received.system == 255


def test_signed_frames_are_understood():
    mav = common.MAVLink(None, srcSystem=3, srcComponent=4)
    mav.signing.secret_key = b"k" * 32
    mav.signing.sign_outgoing = True
    message = HEARTBEAT(custom_mode=5, type=6, autopilot=8, base_mode=1, system_status=4, mavlink_version=3)
    frame = common.MAVLink_heartbeat_message(**message._asdict()).pack(mav)
    (received,) = Codec(1, 1).decode(frame)
    assert received.message == message
    assert (received.system, received.component) == (3, 4)


def test_a_message_that_the_dialect_does_not_know_is_passed_over():
    frame = bytearray(Codec(9, 1).encode(HEARTBEAT(1, 2, 3, 4, 5, 3)))
    frame[7:10] = (54321).to_bytes(3, "little")
    after = Codec(9, 1).encode(HEARTBEAT(1, 2, 3, 4, 5, 3))
    codec = Codec(1, 1)
    assert [r.message for r in codec.decode(bytes(frame) + after)] == [None, HEARTBEAT(1, 2, 3, 4, 5, 3)]


def test_sequence_numbers_wrap():
    codec = Codec(1, 1)
    beat = HEARTBEAT(0, 2, 12, 0, 3, 3)
    assert [codec.encode(beat)[4] for _ in range(257)] == [*range(256), 0]


corruption = st.lists(
    st.one_of(
        st.binary(max_size=40),
        messages().map(lambda m: Codec(7, 1).encode(m)),
        st.tuples(messages(), st.integers(0, 299), st.integers(1, 255)).map(
            lambda t: flipped(Codec(7, 1).encode(t[0]), t[1], t[2])
        ),
        st.tuples(messages(), st.integers(0, 299)).map(lambda t: Codec(7, 1).encode(t[0])[: t[1]]),
        messages().map(lambda m: pymavlink_frame(m, force_mavlink1=True) if m.ID < 256 else b""),
    ),
    max_size=8,
)


def flipped(frame, at, mask):
    frame = bytearray(frame)
    frame[at % len(frame)] ^= mask
    return bytes(frame)


@given(corruption)
@settings(max_examples=300, deadline=None)
def test_under_corruption_no_frame_is_lost_that_pymavlink_accepts(chunks):
    codec = Codec(1, 1)
    theirs = common.MAVLink(None)
    theirs.robust_parsing = True
    ours, expected = [], []
    for chunk in chunks:
        ours += [r.message.ID for r in codec.decode(chunk) if r.message]
        expected += [m.get_msgId() for m in theirs.parse_buffer(chunk) or [] if m.get_msgId() >= 0]
        assert len(codec.snapshot().pending) <= LONGEST
    ours += [r.message.ID for r in codec.decode(bytes(LONGEST)) if r.message]
    rest = iter(ours)
    assert all(number in rest for number in expected)


LONGEST = 280  # a signed frame with a full payload


def numbered(count):
    return [SETPOINT(n, *[float(n)] * 11, 0, 1, 1, 1) for n in range(count)]


def heard(codec, data):
    return [r.message for r in codec.decode(data) if r.message is not None]


@pytest.mark.parametrize("end", [b"", b"\xfd\xff", b"\xfe\xff", b"\xfd\xff\x00", b"\xfd\xff\x01", b"\xfd"])
@pytest.mark.parametrize("force_mavlink1", [False, True])
def test_garbage_costs_none_of_the_frames_behind_it(end, force_mavlink1):
    noise = np.random.default_rng(1)
    sent = numbered(200)
    frames = [pymavlink_frame(message, force_mavlink1=force_mavlink1) for message in sent]
    data = b"".join(noise.bytes(40) + end + frame for frame in frames)
    assert heard(Codec(1, 1), data + bytes(LONGEST)) == sent
    data += bytes(LONGEST)
    codec = Codec(1, 1)
    parts = [heard(codec, data[at : at + 37]) for at in range(0, len(data), 37)]
    assert [message for part in parts for message in part] == sent


@given(st.lists(st.binary(max_size=60), max_size=6), st.lists(st.integers(0, 600), max_size=6))
@settings(max_examples=300, deadline=None)
def test_every_frame_between_garbage_is_heard_however_the_stream_is_cut(garbage, cuts):
    sent = numbered(len(garbage))
    data = b"".join(noise + Codec(9, 1).encode(message) for noise, message in zip(garbage, sent, strict=True))
    codec, got = Codec(1, 1), []
    for begin, end in itertools.pairwise([0, *sorted(cuts), len(data) + LONGEST]):
        got += heard(codec, (data + bytes(LONGEST))[begin:end])
        assert len(codec.snapshot().pending) <= LONGEST
    assert got == sent


@pytest.mark.parametrize("inside", [0, 1])
def test_a_false_frame_of_an_unknown_number_costs_none_either(inside):
    frames = [Codec(9, 1).encode(message) for message in numbered(3)]
    length = len(frames[0]) * (1 + inside) - 2
    false = b"\xfd" + bytes((length, 0, 0, 0, 1, 1)) + (54321).to_bytes(3, "little")
    assert heard(Codec(1, 1), false + b"".join(frames)) == numbered(3)


def test_a_last_frame_of_an_unknown_number_waits_for_what_follows():
    unknown = bytearray(Codec(9, 1).encode(HEARTBEAT(1, 2, 3, 4, 5, 3)))
    unknown[7:10] = (54321).to_bytes(3, "little")
    codec = Codec(1, 1)
    assert codec.decode(bytes(unknown)) == []
    assert len(codec.decode(Codec(9, 1).encode(HEARTBEAT(1, 2, 3, 4, 5, 3)))) == 2
    assert (codec.received, codec.rejected) == (2, 0)


def test_a_broken_frame_among_whole_ones_is_counted_once():
    frames = [Codec(9, 1).encode(message) for message in numbered(3)]
    codec = Codec(1, 1)
    assert heard(codec, frames[0] + flipped(frames[1], 20, 1) + frames[2]) == [numbered(3)[i] for i in (0, 2)]
    assert codec.received == 2
    assert codec.rejected == 1


def test_garbage_is_counted_and_the_next_frame_is_heard():
    codec = Codec(1, 1)
    beat = HEARTBEAT(0, 2, 12, 0, 3, 3)
    assert [r.message for r in codec.decode(b"Init ArduCopter\n" + Codec(1, 1).encode(beat))] == [beat]
    assert (codec.received, codec.rejected) == (1, 1)


@pytest.mark.parametrize("cut", [1, 2, 11, 17])
def test_a_frame_in_two_datagrams_is_put_together_even_across_a_snapshot(cut):
    frame = Codec(1, 1).encode(STATUSTEXT(severity=4, text=b"hello", id=0, chunk_seq=0))
    first, second = Codec(1, 1), Codec(1, 1)
    assert first.decode(frame[:cut]) == []
    second.restore(first.snapshot())
    (received,) = second.decode(frame[cut:])
    assert received.message.text == b"hello"
    assert second.snapshot().pending == b""


def test_absurd_numbers_pass_through_the_codec_unharmed():
    message = SETPOINT(0, math.nan, math.inf, -1e38, *[0.0] * 8, 0, 1, 1, 1)
    (received,) = Codec(1, 1).decode(Codec(2, 2).encode(message))
    assert math.isnan(received.message.x)
    assert received.message.y == math.inf
