"""Signing by pymavlink's own: what it signs is taken, what we sign it takes; all else is refused and counted."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common

from sitl.link.signing import Signer, SignerState, Signing, parse_key

KEY = bytes(range(32))
NOW = 37_000_000_000_000
MINUTE = 6_000_000


def peer(key=KEY, timestamp=NOW, link_id=3, sign=True):
    """A ground station: pymavlink's own codec, which demands signatures itself."""
    mav = common.MAVLink(None, srcSystem=255, srcComponent=190)
    mav.robust_parsing = True
    mav.signing.secret_key, mav.signing.sign_outgoing = key, sign
    mav.signing.timestamp, mav.signing.link_id = timestamp, link_id
    return mav


def arm(mav, **how):
    message = mav.command_long_encode(1, 1, 400, 0, 1, 21196, 0, 0, 0, 0, 0)
    return message.pack(mav, **how)


@pytest.fixture
def simulator(new_client):
    client = new_client(signing=Signing(KEY, NOW))
    client.simulator.exchange(5_000_000, (b"",))
    return client.simulator


def hear(simulator, data):
    """The vehicle's answers; by then it has taken `data`."""
    return simulator.exchange(simulator.time_us + 10_000, (data,))[0]


def test_pymavlink_takes_all_that_the_vehicle_says(simulator):
    station = peer()
    said = b"".join(hear(simulator, b"") for _ in range(200))
    messages = station.parse_buffer(said)
    assert len(messages) > 500
    kinds = [message.get_type() for message in messages]
    assert "BAD_DATA" not in kinds
    # CURRENT_EVENT_SEQUENCE and CURRENT_MODE: pymavlink's common dialect cannot check them.
    unknown = kinds.count("UNKNOWN_411") + kinds.count("UNKNOWN_436")
    assert station.signing.goodsig_count == len(messages) - unknown


def test_a_signed_command_is_obeyed_and_its_replay_is_refused_and_counted(simulator):
    station = peer()
    frame = arm(station)
    hear(simulator, frame)
    assert simulator.report.flight.armed
    assert simulator.refused == 0
    off = station.command_long_encode(1, 1, 400, 0, 0, 21196, 0, 0, 0, 0, 0).pack(station)
    hear(simulator, off)
    assert not simulator.report.flight.armed
    hear(simulator, frame)
    assert not simulator.report.flight.armed
    assert simulator.refused == 1


@pytest.mark.parametrize(
    "frame",
    [
        arm(peer(sign=False)),
        arm(peer(), force_mavlink1=True),
        arm(peer(key=bytes(32))),
        arm(peer(timestamp=NOW - MINUTE - 1000)),
        arm(peer())[:-1] + bytes([arm(peer())[-1] ^ 1]),
    ],
    ids=["unsigned", "MAVLink 1", "another key", "more than a minute old", "one bit of the signature"],
)
def test_what_is_not_signed_as_it_must_be_is_refused_and_counted(simulator, frame):
    hear(simulator, frame)
    assert not simulator.report.flight.armed
    assert simulator.refused == 1
    hear(simulator, arm(peer()))
    assert simulator.report.flight.armed


def test_a_late_but_honest_newcomer_is_heard(simulator):
    hear(simulator, arm(peer(timestamp=NOW - MINUTE // 2)))
    assert simulator.report.flight.armed


def test_who_has_no_key_cannot_make_it_forget_or_remember():
    signer, station = Signer(Signing(KEY, NOW)), peer()
    before = signer.snapshot()
    for i in range(300):
        signer.accepts(arm(peer(key=bytes(32), timestamp=NOW + i * MINUTE, link_id=i % 256)))
    assert signer.snapshot() == SignerState(before.timestamp, before.streams, 300)
    assert signer.accepts(arm(station))


def test_a_snapshot_remembers_what_was_heard(simulator):
    station = peer()
    frame = arm(station)
    hear(simulator, frame)
    state = simulator.snapshot()
    hear(simulator, b"")
    simulator.restore(state)
    hear(simulator, frame)
    assert simulator.refused == 1
    assert simulator.snapshot().signer.timestamp >= state.signer.timestamp


def test_without_a_key_signed_and_unsigned_are_heard(client):
    client.until(lambda: client.flight.ready, 10.0)
    hear(client.simulator, arm(peer()))
    assert client.flight.armed
    assert client.simulator.refused == 0


@pytest.mark.parametrize("data", [KEY, KEY.hex().encode(), KEY.hex().upper().encode() + b"\n"])
def test_a_key_is_32_bytes_or_64_digits(data):
    assert parse_key(data) == KEY


@pytest.mark.parametrize("data", [b"", b"secret", b"0" * 63, b"g" * 64])
def test_anything_else_is_no_key(data):
    with pytest.raises(ValueError, match="openssl rand -hex 32"):
        parse_key(data)


def test_a_setpoint_stream_steers_through_signatures(simulator):
    station = peer()
    hear(simulator, arm(station))
    for step in range(300):
        message = station.set_position_target_local_ned_encode(
            0, 1, 1, 1, 0x5F8, 0, 0, -4.0, *[math.nan] * 6, 0, 0
        )
        data = message.pack(station)
        if step == 5:
            data += station.command_long_encode(1, 1, 176, 0, 1, 6, 0, 0, 0, 0, 0).pack(station)
        hear(simulator, data)
    assert simulator.report.flight.mode.name == "OFFBOARD"
    assert simulator.refused == 0
