"""Both ends sign over UDP: `sitl --signing` and `fly --signing`; a stranger is refused by both."""

from __future__ import annotations

import pytest
from patience import LIMIT_S
from pymavlink import mavutil

import mavspiral
from sitl.link.codec import Codec
from sitl.link.frames import datagrams
from sitl.link.messages import message_type
from sitl.link.signing import Signer, Signing

KEY = bytes(range(7, 39))


@pytest.fixture
def key_file(tmp_path):
    path = tmp_path / "key"
    path.write_text(KEY.hex())
    return path


def test_a_signed_dry_run_goes_well_and_a_stranger_is_refused(start_vehicle, key_file, planned):
    vehicle = start_vehicle("--speedup", "8", "--signing", str(key_file))
    stranger = mavutil.mavlink_connection(
        f"udpout:127.0.0.1:{18570 + vehicle.instance}", dialect="common", source_system=77
    )
    for _ in range(3):
        stranger.mav.command_long_send(vehicle.system, 1, 400, 0, 1, 21196, 0, 0, 0, 0, 0)
    url = f"udpin://127.0.0.1:{vehicle.offboard_port}"
    flight = mavspiral.fly(planned("kiosk"), url, dry_run=True, signing_key=KEY)
    assert flight.outcome.ok, flight.outcome
    assert flight.summary()["refused"] == 0
    vehicle.process.terminate()
    vehicle.process.wait(LIMIT_S)
    vehicle.says("refused")
    assert vehicle.lines[-1] == "sitl: 3 frames refused: unsigned, wrongly signed or replayed"
    assert not [line for line in vehicle.lines if "armed" in line]
    stranger.close()


def test_an_unsigned_vehicle_is_nobody(start_vehicle, planned):
    vehicle = start_vehicle("--speedup", "8")
    url = f"udpin://127.0.0.1:{vehicle.offboard_port}"
    flight = mavspiral.fly(planned("kiosk"), url, dry_run=True, signing_key=KEY)
    assert flight.outcome.exit_code == 3
    assert flight.summary()["refused"] > 100
    assert any("not signed with our key" in event.text for event in flight.events)


def test_signed_frames_are_not_cut_by_datagrams():
    codec = Codec(1, 1, Signer(Signing(KEY, 0)))
    text = message_type("STATUSTEXT")
    frames = [codec.encode(text(6, b"x" * length, 0, 0)) for length in range(1, 50)]
    parts = list(datagrams(b"".join(frames), 200))
    assert b"".join(parts) == b"".join(frames)
    ends = {sum(map(len, frames[:i])) for i in range(len(frames) + 1)}
    assert {sum(map(len, parts[:i])) for i in range(len(parts) + 1)} <= ends
