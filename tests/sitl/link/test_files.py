"""MAVLink FTP: ArduPilot's parameters come as a file; whatever else is asked for is refused at once, in both dialects."""

import struct

import pytest
from copter_client import mavlink, pick

ACK, NAK = 128, 129
TERMINATE, LIST, OPEN, READ, CREATE, BURST = 1, 3, 4, 5, 6, 15
END, UNKNOWN, PROTECTED, NOT_FOUND, INVALID_SESSION = 6, 7, 9, 10, 4


def ask(copter, opcode, data=b"", offset=0, size=None, session=3, seconds=0.05):
    """(opcode, asked for, session, burst complete, offset, data) of each answer."""
    size = len(data) if size is None else size
    payload = struct.pack("<HBBBBBxI", 7, session, opcode, size, 0, 0, offset) + data
    copter.say(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload.ljust(251, b"\0"))))
    answers = []
    for message in pick(copter.live(seconds), "FILE_TRANSFER_PROTOCOL"):
        raw = bytes(message.payload)
        _, said, op, length, asked, complete, at = struct.unpack_from("<HBBBBBxI", raw)
        answers.append((op, asked, said, complete, at, raw[12 : 12 + length]))
    return answers


ON_FILE = {1: "<b", 2: "<h", 3: "<i", 4: "<f"}


def decoded(content):
    """Name to (value, default): as AP_Filesystem_Param.cpp describes the file."""
    _, count, total = struct.unpack_from("<HHH", content)
    at, before, found = 6, b"", {}
    while at < len(content):
        kind, lengths = content[at], content[at + 1]
        packed = struct.Struct(ON_FILE[kind & 15])
        own, common = (lengths >> 4) + 1, lengths & 15
        name = before[:common] + content[at + 2 : at + 2 + own]
        at += 2 + own
        (value,) = packed.unpack_from(content, at)
        at += packed.size
        default = value
        if kind >> 4 & 1:
            (default,) = packed.unpack_from(content, at)
            at += packed.size
        found[name.decode()], before = (value, default), name
    assert count == total == len(found)
    return found


@pytest.mark.parametrize("by_burst", [True, False])
def test_all_parameters_and_their_defaults_come_as_one_file(copter, by_burst):
    copter.say(mavlink.MAVLink_param_set_message(1, 1, b"WPNAV_SPEED", 640.0, 9))
    copter.say(mavlink.MAVLink_param_set_message(1, 1, b"RTL_ALT", 3000.0, 9))
    ((op, asked, session, _, _, size),) = ask(copter, OPEN, b"@PARAM/param.pck?withdefaults=1")
    (size,) = struct.unpack("<I", size)
    assert (op, asked, session) == (ACK, OPEN, 3)
    if by_burst:
        answers = ask(copter, BURST, size=100, seconds=1.0)
        assert [answer[3] for answer in answers] == [0] * (len(answers) - 1) + [1]
        assert {answer[2] for answer in answers} == {3}
        content = b"".join(answer[5] for answer in answers)
    else:
        content = b""
        while len(content) < size:
            ((op, _, _, _, at, data),) = ask(copter, READ, size=239, offset=len(content), seconds=0.02)
            assert (op, at) == (ACK, len(content))
            content += data
        assert ask(copter, READ, size=239, offset=size)[0][::5] == (NAK, bytes([END]))
    assert len(content) == size
    parameters = decoded(content)
    assert list(parameters) == list(copter.simulator.parameters)
    assert parameters["WPNAV_SPEED"] == (640.0, 1000.0)
    assert parameters["RTL_ALT"] == (3000, 1500)
    assert isinstance(parameters["RTL_ALT"][0], int)
    assert len(parameters) == 1392
    assert ask(copter, TERMINATE)[0][0] == ACK
    assert ask(copter, READ, size=10)[0][::5] == (NAK, bytes([INVALID_SESSION]))


@pytest.mark.parametrize(
    ("opcode", "data", "error"),
    [
        (OPEN, b"/fs/microsd/log.ulg", NOT_FOUND),
        (OPEN, b"@MISSION/mission.dat", NOT_FOUND),
        (LIST, b"/", END),
        (LIST, b"/fs", NOT_FOUND),
        (CREATE, b"/a", PROTECTED),
        (READ, b"", INVALID_SESSION),
        (77, b"", UNKNOWN),
    ],
)
def test_what_is_not_there_is_refused_at_once(copter, client, pick, opcode, data, error):
    (answer,) = ask(copter, opcode, data)
    assert (answer[0], answer[1], answer[5]) == (NAK, opcode, bytes([error]))
    payload = (struct.pack("<HBBBBBxI", 7, 3, opcode, len(data), 0, 0, 0) + data).ljust(251, b"\0")
    client.say(
        "FILE_TRANSFER_PROTOCOL",
        target_network=0,
        target_system=1,
        target_component=1,
        payload=tuple(payload),
    )
    (told,) = pick(client.live(0.05), "FILE_TRANSFER_PROTOCOL")
    assert bytes(told.payload[3:6]) == bytes([NAK, 1, opcode])
    assert told.payload[12] == error


def test_a_burst_goes_on_after_a_snapshot(copter):
    ask(copter, OPEN, b"@PARAM/param.pck")
    ask(copter, BURST, size=80, seconds=0.03)
    state = copter.simulator.snapshot()
    first = b"".join(bytes(m.payload) for m in pick(copter.live(1.0), "FILE_TRANSFER_PROTOCOL"))
    copter.simulator.restore(state)
    assert first
    assert first == b"".join(bytes(m.payload) for m in pick(copter.live(1.0), "FILE_TRANSFER_PROTOCOL"))
