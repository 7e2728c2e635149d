"""Our end of a signed link, against pymavlink's own signing and against the bundled vehicle."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common

from mavspiral.errors import InputError
from mavspiral.flight.link import Link
from mavspiral.flight.messages import Command
from mavspiral.flight.signing import Signer, read_key
from mavspiral.flight.upload import Upload

KEY = bytes(range(1, 33))
NOW = 37_000_000_000_000


def pymavlink(key=KEY, timestamp=NOW, sign=True):
    mav = common.MAVLink(None, srcSystem=1, srcComponent=1)
    mav.robust_parsing = True
    mav.signing.secret_key, mav.signing.sign_outgoing, mav.signing.timestamp = key, sign, timestamp
    return mav


def beat(mav):
    return mav.heartbeat_encode(2, 12, 81, 0, 3).pack(mav)


def test_pymavlink_takes_every_kind_of_frame_that_we_send():
    link, vehicle = Link(signer=Signer(KEY, NOW)), pymavlink()
    link.vehicle = 1, 1
    setpoint = (1.0, 2.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0)
    sent = [
        link.heartbeat(),
        link.command(Command.COMPONENT_ARM_DISARM, 1.0),
        link.parameter_request("NAV_RCL_ACT"),
        link.setpoint(5, setpoint, type_mask=0, coordinate_frame=1),
    ]
    heard = vehicle.parse_buffer(b"".join(sent))
    assert [m.get_type() for m in heard] == [
        "HEARTBEAT",
        "COMMAND_LONG",
        "PARAM_REQUEST_READ",
        "SET_POSITION_TARGET_LOCAL_NED",
    ]
    assert vehicle.signing.goodsig_count == 4
    assert (heard[3].z, heard[3].yaw) == (-3.0, 0.5)


def test_what_is_signed_is_heard_once():
    link, frame = Link(signer=Signer(KEY, NOW)), beat(pymavlink())
    assert len(link.receive(frame)) == 1
    assert link.receive(frame) == []
    assert link.refused_n == 1


@pytest.mark.parametrize(
    "mav",
    [pymavlink(sign=False), pymavlink(key=bytes(32)), pymavlink(timestamp=NOW - 6_100_000)],
    ids=["unsigned", "another key", "old"],
)
def test_all_else_is_refused_and_counted(mav):
    link = Link(signer=Signer(KEY, NOW))
    assert link.receive(beat(mav)) == []
    assert link.refused_n == 1
    assert len(link.receive(beat(pymavlink()))) == 1


def test_unsigned_links_hear_both():
    link = Link()
    assert len(link.receive(beat(pymavlink()) + beat(pymavlink(sign=False)))) == 2
    assert link.refused_n == 0


def test_a_key_file_that_is_none_is_named_with_a_fix(tmp_path):
    path = tmp_path / "key"
    with pytest.raises(InputError, match="openssl rand -hex 32"):
        read_key(path)
    path.write_text("secret")
    with pytest.raises(InputError, match="6 bytes"):
        read_key(path)
    path.write_text(KEY.hex() + "\n")
    assert read_key(path) == KEY


def test_nothing_is_uploaded_to_who_has_another_key():
    upload, stranger = Upload({}, None, signer=Signer(KEY, NOW)), pymavlink(key=bytes(32))
    for second in range(12):
        upload.step(second * 1_000_000, beat(stranger))
    assert upload.outcome is not None
    assert upload.outcome.exit_code == 3
    assert "no vehicle within 10 s that signs with our key: 12 frames refused" in upload.outcome.reason
